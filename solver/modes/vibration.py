"""Small vibrations about a state: eigenfrequencies, modes, participation."""

from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from ..errors import InputError
from ..model.bodies import moved, spreads
from ..model.inertia import mass_properties
from ..model.loads import Centrifugal
from ..model.model import Model
from ..results.frame import table
from ..results.stresses import Configuration, configuration
from ..signatures import Count, checked
from ..statics.result import StaticResult
from ..system.loads import at_factor, unloaded
from .eigen import lowest, lowest_gyroscopic
from .matrices import coriolis, mass, of_all, sparse_system, stiffness
from .result import Shapes, shape_fields


@dataclass(frozen=True, eq=False, repr=False)
class Modes(Shapes):
    """Modes in the order of their eigenvalues, each with the modal mass 1: ``v^T M v = 1 kg m^2``
    for a displacement in m, so that ``displacement`` is per root of kg.

    Attributes:
        eigenvalues: (n,) omega^2 [1/s^2]; below zero the state is unstable.
        participation: (n, 6) momentum of the mode at unit rate along x, y, z, and its angular
            momentum about axes through the centre of mass; None of a shell that spins.
        mass: of the shell [kg].
        centre: (3,) of mass in the state [m].
        inertia: (3, 3) about it, rotary inertia included [kg m^2].
    """

    eigenvalues: np.ndarray
    participation: np.ndarray | None
    mass: float
    centre: np.ndarray
    inertia: np.ndarray

    def __repr__(self):
        return (f"<Modes: {len(self)} from {self.frequencies[0]:.6g} to "
                f"{self.frequencies[-1]:.6g} Hz>")

    @property
    def omega(self):
        """(n,) angular frequencies [rad/s]; below zero: of ``exp(|omega| t)`` instead."""
        return np.sign(self.eigenvalues) * np.sqrt(np.abs(self.eigenvalues))

    @property
    def frequencies(self):
        """(n,) ``omega / 2 pi`` [Hz]."""
        return self.omega / (2.0 * np.pi)

    @property
    def effective_mass(self):
        """(n, 6) squares of ``participation`` [kg, kg m^2]: over all modes they sum up to the mass
        and the moments of inertia, of a shell with supports less what these hold."""
        return self.participation**2

    def names(self):
        """Number and frequency of each mode."""
        return [f"mode {k + 1}: {f:.6g} Hz" for k, f in enumerate(self.frequencies)]

    def frame(self):
        """Frequencies and effective masses as a ``pandas.DataFrame``, a row a mode."""
        columns = {"frequency": self.frequencies, "omega": self.omega}
        if self.participation is not None:
            columns |= {"effective_mass": self.effective_mass[:, :3],
                        "effective_inertia": self.effective_mass[:, 3:]}
        return table(columns)


@checked
@threadpool_limits.wrap(limits=1)
def modes(model: Model, n: Count = 10, state: object = None, factor: float = None):
    """Modes of small vibrations ``(K - omega^2 M) v = 0`` about a state, the lowest first.

    K is the tangent of statics at the state, with the stress in it and the stiffness of loads that
    follow the shell; M is the consistent mass with the rotary inertia of the normals.  A free body
    has its six zero modes.  In a state under a ``Centrifugal`` load the frame turns: K has the
    softening by the centrifugal forces, and Coriolis forces make the modes complex,
    ``(K + i omega G - omega^2 M) v = 0``.

    Args:
        model: ``Model``.
        n: how many.
        state: ``StaticResult``, whose last row is taken, or one of its ``states``; left out, the
            initial shell without loads.
        factor: load factor of the state; left out, that of the row, or 1.

    Returns:
        ``Modes``.

    Warns:
        AccuracyWarning: the state is no equilibrium, or the loads' stiffness is not symmetric.

    Raises:
        InputError: a wrong argument; a load factor without a state; two frames that turn.
        StepError: eigenvalues were not found, or a shell that spins is unstable without Coriolis
            forces.
    """
    start, factor = base(model, state, factor)
    system = sparse_system(model)
    at = system.coordinates.initial_state(model, start)
    place = system.observe(at)
    value = unloaded if start is None else at_factor(factor)
    omega = _spin(model, value)
    K, M = stiffness(system, at, place, system.loads_by(value)), mass(system, at, place)
    if spins := omega.any():
        frequencies, vectors = lowest_gyroscopic(K, coriolis(system, place, omega), M, n)
        eigenvalues = frequencies**2
    else:
        eigenvalues, vectors = lowest(K, M, n, _bending(model))
    u, q, energy = shape_fields(system, at, place, of_all(system, vectors))
    x, p = at.x + at.x_low, place.start.p
    body = mass_properties(model.elements, x, p, moved(model.bodies, x, p))
    momenta = None if spins else _momenta(model, x - body.centre, p, u, q)
    return Modes(model, system.displacement(at), u, q, energy, eigenvalues, momenta, *body)


def base(model, state, factor):
    """(``Configuration`` or None, load factor) of what ``modes`` and ``buckling`` are given."""
    if state is None:
        if factor is not None:
            raise InputError("factor is the load factor of a state, give it with one")
        return None, 0.0
    if isinstance(state, StaticResult):
        factor = float(state.factors[-1]) if factor is None else factor
        state = state.states[-1]
    if not isinstance(state, Configuration):
        raise InputError("state must be a StaticResult or one of its states")
    still = configuration("state", model, state._replace(velocity=None, director_rates=None))
    return still, 1.0 if factor is None else factor


def _spin(model, value):
    """(3,) angular velocity of the frame with ``value(history)`` of the loads [rad/s]."""
    spins = [np.sqrt(max(value(load.history), 0.0)) * np.array(load.omega)
             for load in model.loads if isinstance(load, Centrifugal)]
    if len(spins) > 1:
        raise InputError(f"modes: {len(spins)} centrifugal loads are there, one frame turns")
    return spins[0] if spins else np.zeros(3)


def _bending(model):
    """``D / (rho h L^4)`` [1/s^2]: below the lowest eigenvalue of bending, and of its order."""
    thickness, poisson = model.thickness, model.poisson
    wave = model.youngs * thickness**2 / (12.0 * (1.0 - poisson**2) * model.density)
    return float(np.mean(wave)) / model.size**4


def _momenta(model, arms, p, displacement, directors):
    """(n, 6) ``sum_ij m_ij u_j + c_ij q_j`` and ``sum_ij r_i x (m_ij u_j + c_ij q_j) + p_i x (I_ij
    q_j + c_ij u_j)``."""
    elements = model.elements
    m, rotary = elements.mass, elements.rotary
    u, q = displacement[:, elements.nodes], directors[:, elements.directors]
    of_u, of_q = np.einsum("eij,nejc->neic", m, u), np.einsum("eij,nejc->neic", rotary, q)
    if len(elements.eccentric):
        of_u = of_u + np.einsum("eij,nejc->neic", elements.eccentric, q)
        of_q = of_q + np.einsum("eij,nejc->neic", elements.eccentric, u)
    turning = (np.cross(arms[elements.nodes], of_u) + np.cross(p[elements.directors], of_q))
    found = np.concatenate([of_u.sum(axis=(1, 2)), turning.sum(axis=(1, 2))], axis=1)
    spread = spreads(model.bodies, len(p))[:, None]
    found[:, 3:] += np.cross(p, spread * directors).sum(axis=1)
    for i, own in model.body_masses:
        found[:, :3] += own * displacement[:, i]
        found[:, 3:] += np.cross(arms[i], own * displacement[:, i])
    return found
