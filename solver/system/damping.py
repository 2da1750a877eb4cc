"""Damping in proportion to mass and stiffness, blind to rigid motion."""

import numpy as np
from scipy.sparse import csr_array

from ..model.constants import apart


class Viscous:
    """``Damping`` of a model; see there.

    The stiffness part is in the weights of the strains, ``arguments.Factors``; the mass part acts
    on translations, ``f = -mass M (v - v_rigid)``, v_rigid the rigid motion with the momenta of
    ``M v``, so that the sum of f and its moment are zero.
    """

    def __init__(self, model, translations):
        self._translations = translations
        self._given, self._floating = model.damping, not model.grounded
        self._mass = consistent_mass(model)
        self._lumped = model.nodal_mass
        self._k_b = apart(model.elements.k_b, len(model.quads))

    def damped(self, step, dt):
        """``arguments.Factors`` of a step of length dt [s] with damping."""
        lag = self._given.stiffness / dt
        return step._replace(strain_end=step.strain_end + lag,
                             strain_start=step.strain_start - lag,
                             mass=step.mass + self._given.mass * step.rate_delta)

    def add_forces(self, iterate, forces):
        """Add the forces of the mass part at an iterate to ``forces`` (n_dof,) [N]."""
        if self._given.mass:
            forces[self._translations] += self._forces(iterate)

    def braked(self, iterate):
        """Energy that the mass part took in the step to an iterate, ``-f . dx`` [J]."""
        if not self._given.mass:
            return 0.0
        return -float(np.sum(self._forces(iterate) * iterate.delta[self._translations]))

    def _forces(self, iterate):
        """(n_nodes, 3) of the mass part [N]."""
        state, step, delta = iterate[:3]
        translations = self._translations
        v = iterate.rates[translations]
        if self._floating:
            x = state.x + state.x_low + (1.0 - step.alpha_f) * delta[translations]
            v = v - self._rigid(x, self._mass @ v)
        return -self._given.mass * (self._mass @ v)

    def _rigid(self, x, momenta):
        """(n_nodes, 3) velocities of the rigid motion with these momenta (n_nodes, 3) of nodes."""
        total = self._lumped.sum()
        arms = x - self._lumped @ x / total
        spread = arms.T @ (self._mass @ arms)
        inertia = np.trace(spread) * np.eye(3) - spread
        spin = np.linalg.solve(inertia, np.cross(arms, momenta).sum(axis=0))
        return momenta.sum(axis=0) / total + np.cross(spin, arms)

    def lost(self, step, before, start):
        """Energy that the stiffness part took in a step, ``eta/dt (|de|^2 + db . k_b db)`` [J].

        Args:
            step: ``arguments.Factors``.
            before: ``strains`` at its start.
            start: ``arguments.Start`` at its end.
        """
        lag = step.strain_end - (1.0 - step.alpha_f)
        return 2.0 * lag * float(energies(self._k_b, start.b - before[0],
                                          start.e - before[1]).sum())


class Dissipation:
    """Dissipation of the scheme ``exact``: strains are taken later than their mean, by ``lags`` of
    the state; see the theory page of the scheme.

    Constant lags are those of a viscosity ``lag dt``.  Selective ones are ``c/2 D/(D + 4 A)`` with
    the energies of an element's increment in the last step, D, and of its mean, A: of resolved
    motion they take energy of third order in dt.
    """

    def __init__(self, model, scheme):
        """``scheme``: ``Scheme``."""
        self._most, self._selective = 0.5 * scheme.dissipation, scheme.dissipates == "selective"
        self._k_b = apart(model.elements.k_b, len(model.quads))

    def begin(self, state):
        """Lags of the first step: constant ones."""
        if not self._selective:
            state.lags[:] = self._most

    def lost(self, state, before, start):
        """Energy that a step took [J], whose lags are those of ``state``, and the lags of the next.

        Args:
            state: ``State``; its lags are renewed.
            before: ``strains`` at the start of the step.
            start: ``arguments.Start`` at its end.
        """
        db, de = start.b - before[0], start.e - before[1]
        increment = energies(self._k_b, db, de)
        lost = 2.0 * float(state.lags[:, 0] @ increment)
        if self._selective:
            mean = 4.0 * energies(self._k_b, start.b - 0.5 * db, start.e - 0.5 * de) + increment
            state.lags[:, 0] = self._most * np.divide(increment, mean, where=mean > 0.0,
                                                      out=np.zeros_like(mean))
        return lost


def consistent_mass(model):
    """(n_nodes, n_nodes) consistent mass of the shell [kg], sparse."""
    quads, n = model.quads, len(model.nodes)
    places = np.repeat(quads, 4, axis=1).ravel(), np.tile(quads, (1, 4)).ravel()
    return csr_array((model.elements.mass.ravel(), places), shape=(n, n))


def strains(start):
    """Strain measures of ``arguments.Start`` to compare later ones with."""
    return start.b.copy(), start.e.copy()


def energies(k_b, b, e):
    """(n_elem,) energies ``(|e|^2 + b . k_b b)/2`` of measures [J]."""
    return 0.5 * (np.sum(e * e, axis=1) + np.einsum("ei,eij,ej->e", b, k_b, b))
