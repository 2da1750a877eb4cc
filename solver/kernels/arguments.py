"""What Python passes to kernels and gets back: arrays and numbers with names, shapes and units.

All of it stands here, beside the kernels, because a field is a position in compiled code: the
cache of compiled kernels is named after a hash of this folder.  A kernel that can fail returns the
index of what failed (a node, a pivot), or ``DONE``.
"""

from typing import NamedTuple

import numpy as np

DONE = -1
"""Returned where nothing failed."""


class Elements(NamedTuple):
    """Connectivity and constants of all elements.

    y0, r0, l, Q, k_b, inertia and coupling are given here for one element; they are stored side by
    side, in groups of ``lanes.WIDTH`` elements: (n_groups, ..., WIDTH).

    Attributes:
        nodes: (n_elem, 4) node of each vertex.
        directors: (n_elem, 4) mid-surface normal of each vertex.
        y0: (3, 3) initial local positions of nodes 2..4 relative to node 1, Eq. (7) [m].
        r0: (4, 2) initial local x, y components of the normals, Eq. (9).
        l: (n_s, 3, 3) linear part of the scaled membrane measures [sqrt(J)/m].
        Q: (n_s, 3, 3) their quadratic part in w [sqrt(J)/m^2].
        k_b: (11, 11) bending and shear stiffness on (w_2..w_4, dr_1..dr_4).
        mass: (n_elem, 4, 4) rho h int N_i N_j dA, Eq. (40a) [kg].
        rotary: (n_elem, 4, 4) the same of the normals, rho h^3/12 int N_i N_j dA, Eq. (40b)
            [kg m^2].
        inertia: (2, 4, 4) mass and rotary once more, side by side.
        coupling: (n_s, 8) linear part of the measures in dr_1..dr_4, of sections that couple
            stretch and bending [sqrt(J)]; no groups at all where there are none.
        eccentric: (n_elem, 4, 4) int rho z dz int N_i N_j dA, of mass that is not centred on the
            surface of the nodes [kg m]; (0, 4, 4) where there is none.
    """

    nodes: np.ndarray
    directors: np.ndarray
    y0: np.ndarray
    r0: np.ndarray
    l: np.ndarray
    Q: np.ndarray
    k_b: np.ndarray
    mass: np.ndarray
    rotary: np.ndarray
    inertia: np.ndarray
    coupling: np.ndarray
    eccentric: np.ndarray


class Nodes(NamedTuple):
    """Where the unknowns and the directors of each node stand.

    Attributes:
        start: (n_nodes,) first dof of each node: 3 displacements, then its rotational variables.
        n_rot: (n_nodes,) number of rotational variables, 2 on a smooth node, 3 at a junction.
        first: (n_nodes + 1,) directors of node i are ``first[i] .. first[i + 1] - 1``.
        body: (n_directors, 3) their components in the nodal frame of a junction.
    """

    start: np.ndarray
    n_rot: np.ndarray
    first: np.ndarray
    body: np.ndarray


class Dofs(NamedTuple):
    """The unknowns: those of the nodes, and which of them are held.

    Attributes:
        nodes: ``Nodes``.
        fixed: (n_dof,) bool.
        any_fixed: whether there is one.
    """

    nodes: Nodes
    fixed: np.ndarray
    any_fixed: bool


class Motion(NamedTuple):
    """The arrays of a state.

    Attributes:
        x: (n_nodes, 3) positions [m].
        x_low: (n_nodes, 3) their rounding errors [m].
        variables: (n_nodes, 3) rotational variables n_g, Eqs. (5), (11).
        chart: (n_nodes, 3, 3) the axes that they are components in, rows t_1, t_2, t_3.
        velocity: (n_dof,) U_dot [m/s, 1/s].
        acceleration: (n_dof,) U_ddot [m/s^2, 1/s^2].
    """

    x: np.ndarray
    x_low: np.ndarray
    variables: np.ndarray
    chart: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray


class Start(NamedTuple):
    """What follows from a state where a step starts from it.

    Attributes:
        p: (n_directors, 3) mid-surface normals.
        A1: (n_directors, 3, 3) columns dp/dn, Eqs. (27), (33).
        p_dot: (n_directors, 3) their rates [1/s], Eq. (30).
        t: (n_elem, 3, 3) local displacements of nodes 2..4 [m], Eq. (8).
        b: (n_elem, 11) local variables of bending and shear, Eqs. (8), (10).
        e: (n_elem, n_s) scaled membrane measures [sqrt(J)].
        energy: (n_elem,) strain energy [J].
    """

    p: np.ndarray
    A1: np.ndarray
    p_dot: np.ndarray
    t: np.ndarray
    b: np.ndarray
    e: np.ndarray
    energy: np.ndarray


class Factors(NamedTuple):
    """Coefficients of one step at the generalized midpoint, Eqs. (57)-(65).

    ``U_ddot_mid = delta dU - velocity U_dot - acceleration U_ddot`` and
    ``U_dot_mid = rate_delta dU - rate_velocity U_dot - rate_acceleration U_ddot``.

    Attributes:
        alpha_f: weight of the start of the step.
        stiffness: factor of K_G in the matrix.
        delta: factor of dU in U_ddot [1/s^2], and of M in the matrix.
        velocity: factor of U_dot [1/s].
        acceleration: factor of U_ddot.
        rate_delta: factor of dU in U_dot [1/s].
        rate_velocity: factor of U_dot.
        rate_acceleration: factor of U_ddot [s].
        per_step: ``1/dt``, of the rate that a change in the step has in dampers [1/s].
        strain_end: weight of the strains at the end, Eq. (70); with damping, that and what it adds.
        strain_start: weight of those at the start; both sum to 1.
        mass: factor of M in the matrix [1/s^2]: ``delta``, and what damping adds.
    """

    alpha_f: float
    stiffness: float
    delta: float
    velocity: float
    acceleration: float
    rate_delta: float
    rate_velocity: float
    rate_acceleration: float
    per_step: float
    strain_end: float
    strain_start: float
    mass: float


STATIC = Factors(alpha_f=0.0, stiffness=1.0, delta=0.0, velocity=0.0, acceleration=0.0,
                 rate_delta=0.0, rate_velocity=0.0, rate_acceleration=0.0, per_step=0.0,
                 strain_end=1.0, strain_start=0.0, mass=0.0)
"""Equilibrium at the end of the increment: no inertia, no averaging."""

MASS_ONLY = STATIC._replace(stiffness=0.0, delta=1.0, rate_velocity=-1.0, mass=1.0)
"""M U_ddot = F_ext - F_m - F_int, Eq. (55): unit mass, no stiffness, velocities as they are."""


class EndFactors(NamedTuple):
    """Factors of (dU, U_dot, U_ddot) in U_dot and in U_ddot at the end of a step (Newmark).

    Attributes:
        rate_delta: of dU in U_dot [1/s].
        rate_velocity: of U_dot in U_dot.
        rate_acceleration: of U_ddot in U_dot [s].
        second_delta: of dU in U_ddot [1/s^2].
        second_velocity: of U_dot in U_ddot [1/s].
        second_acceleration: of U_ddot in U_ddot.
    """

    rate_delta: float
    rate_velocity: float
    rate_acceleration: float
    second_delta: float
    second_velocity: float
    second_acceleration: float


class Loads(NamedTuple):
    """Dead loads at one time.

    Attributes:
        forces: (n_dof,) [N].
        moments: (n_nodes, 3) about fixed axes [N m].
        on_normals: (n_directors, 3) forces of turning springs on the normals [N m].
    """

    forces: np.ndarray
    moments: np.ndarray
    on_normals: np.ndarray


class Predicted(NamedTuple):
    """Strains from which a mixed tangent takes its stresses, see ``updates.predict_strains``.

    Attributes:
        used: whether the tangent is a mixed one.
        b: (n_elem, 11) local variables of bending and shear.
        e: (n_elem, n_s) membrane measures.
    """

    used: bool
    b: np.ndarray
    e: np.ndarray


class Residual(NamedTuple):
    """Forces of an iterate, (n_dof,) each [N, N m].

    Attributes:
        balance: F_ext - M U_ddot - F_m - F_int, Eq. (58), zero at held dofs.
        unmasked: the same with the reactions of held dofs.
        applied: generalized external forces.
    """

    balance: np.ndarray
    unmasked: np.ndarray
    applied: np.ndarray


WHOLE, BEFORE, ELEMENTS, AFTER = 0, 1, 2, 3
"""Parts of an assembly: all of it, the nodes before the elements, the elements, the nodes after
them.  Each takes what the last has left at all nodes."""


class Share(NamedTuple):
    """What one of several threads does of an assembly: some nodes, and of some elements what they
    add to the nodes that it owns, in the order of all elements.

    Attributes:
        first: first node of its own before and after the elements.
        last: behind the last one.
        groups: (n,) groups of elements, ascending: all that have a node which it owns.
        owned: (n_nodes,) bool; empty: all nodes.
    """

    first: int
    last: int
    groups: np.ndarray
    owned: np.ndarray


class Storage(NamedTuple):
    """Where the lower triangle of the matrix stands in the values of a linear solver.

    The entry (row, k-th dof of a column node) of element e, vertex pair (i, j), row not before
    column, stands at ``base[row] + offset[e, i, j] + stride * k``.

    Attributes:
        base: (n_dof,) of the rows.
        offset: (n_elem, 4, 4) of the blocks.
        diagonal: (n_dof,) of the diagonal entries.
        stride: from one column to the next.
    """

    base: np.ndarray
    offset: np.ndarray
    diagonal: np.ndarray
    stride: int


class NodalWork(NamedTuple):
    """Nodal quantities of one iterate.

    Attributes:
        dx: (n_nodes, 3) displacement increments [m].
        p_end: (n_directors, 3) normals at the end of the step.
        p_mid: (n_directors, 3) normals at the generalized midpoint.
        A1: (n_directors, 3, 3) columns dp/dn there.
        inertial_x: (n_nodes, 3) accelerations of x [m/s^2].
        inertial_p: (n_directors, 3) A1 n_ddot + A2 [1/s^2].
        force_x: (n_nodes, 3) internal and inertial forces [N].
        force_p: (n_directors, 3) internal forces on the normals [N m].
        rate_p: (n_directors, 3) inertial forces on the normals [N m].
        ends_p: (2, n_directors, 3) internal forces on the normals at end and start, where T is the
            average of both; its first half takes the predicted forces of a mixed tangent, which
            statics alone has.
    """

    dx: np.ndarray
    p_end: np.ndarray
    p_mid: np.ndarray
    A1: np.ndarray
    inertial_x: np.ndarray
    inertial_p: np.ndarray
    force_x: np.ndarray
    force_p: np.ndarray
    rate_p: np.ndarray
    ends_p: np.ndarray


def _vectors(n):
    """(n, 3) zeros."""
    return np.zeros((n, 3))


def nodal_work(n_nodes, n_directors):
    """``NodalWork`` of zeros."""
    return NodalWork(
        _vectors(n_nodes), _vectors(n_directors), _vectors(n_directors),
        np.zeros((n_directors, 3, 3)), _vectors(n_nodes), _vectors(n_directors), _vectors(n_nodes),
        _vectors(n_directors), _vectors(n_directors), np.zeros((2, n_directors, 3)))


class SpinWork(NamedTuple):
    """Nodal quantities of one iterate of the exact scheme; what ``NodalWork`` has is the same.

    Attributes:
        dx: (n_nodes, 3).
        p_end: (n_directors, 3).
        p_mid: (n_directors, 3) means of the normals at both ends.
        A1: (n_directors, 3, 3) columns b_k x p_mid.
        inertial_x: (n_nodes, 3).
        force_x: (n_nodes, 3).
        force_p: (n_directors, 3).
        spin_rate: (n_nodes, 3) rates of the momenta of the spins [N m].
        frames: (n_nodes, 3, 3) nodal frames at the end of the step.
    """

    dx: np.ndarray
    p_end: np.ndarray
    p_mid: np.ndarray
    A1: np.ndarray
    inertial_x: np.ndarray
    force_x: np.ndarray
    force_p: np.ndarray
    spin_rate: np.ndarray
    frames: np.ndarray


def spin_work(n_nodes, n_directors):
    """``SpinWork`` of zeros."""
    return SpinWork(_vectors(n_nodes), _vectors(n_directors), _vectors(n_directors),
                    np.zeros((n_directors, 3, 3)), _vectors(n_nodes), _vectors(n_nodes),
                    _vectors(n_directors), _vectors(n_nodes), np.zeros((n_nodes, 3, 3)))


class Observation(NamedTuple):
    """Energies and momenta of a state.

    Attributes:
        kinetic: kinetic energy [J].
        strain: strain energy [J].
        linear_momentum: (3,) Eq. (49) [kg m/s].
        angular_momentum: (3,) about the origin, with the consistent mass [kg m^2/s].
        angular_momentum_printed: (3,) with one sum over nodes, Eq. (50) as printed [kg m^2/s].
        momentum_scale: sum m |v| [kg m/s].
        angular_scale: sum m |x - x_c| |v| [kg m^2/s].
    """

    kinetic: float
    strain: float
    linear_momentum: np.ndarray
    angular_momentum: np.ndarray
    angular_momentum_printed: np.ndarray
    momentum_scale: float
    angular_scale: float

    @property
    def energy(self):
        """Kinetic plus strain energy [J]."""
        return self.kinetic + self.strain


class Pivots(NamedTuple):
    """What a factorization L D L^T met.

    Attributes:
        negative: how many pivots are negative.
        failed: index of a pivot that is zero or not finite, or ``DONE``.
    """

    negative: int
    failed: int


class Turning(NamedTuple):
    """A factorization carried along with the nodes, see ``transport``.

    Attributes:
        corner: (n_nodes,) an element beside each node.
        held: (n_nodes,) bool, nodes with a support.
        twin: (n_nodes,) the first of the nodes that move with each.
        frames: (n_nodes, 3, 3) axes of that element when the matrix was made.
        rates: (n_nodes, 3, 3) A_0, maps from rates of the variables then.
        Q: (n_nodes, 3, 3) rotation since then, of corrections.
        J: (n_nodes, 3, 3) map of the rotational variables since then.
        Q_forces: (n_nodes, 3, 3) rotation since then, of residuals.
        J_forces: (n_nodes, 3, 3) the same map for them.
    """

    corner: np.ndarray
    held: np.ndarray
    twin: np.ndarray
    frames: np.ndarray
    rates: np.ndarray
    Q: np.ndarray
    J: np.ndarray
    Q_forces: np.ndarray
    J_forces: np.ndarray


class Terms(NamedTuple):
    """Vectors that move with bodies, see ``multipliers``.

    Attributes:
        first: (n + 1,) terms of vector k are ``first[k] .. first[k + 1] - 1``.
        constant: (n, 3) their constant parts.
        node: (n_terms,) node of each term.
        alpha: (n_terms,) factor of its place.
        body: (n_terms, 3) vector in its frame.
    """

    first: np.ndarray
    constant: np.ndarray
    node: np.ndarray
    alpha: np.ndarray
    body: np.ndarray


class Spans(NamedTuple):
    """Local unknowns on which rows depend, of each a few nodes'.

    Attributes:
        first: (m + 1,) spans of row k are ``first[k] .. first[k + 1] - 1``.
        node: (n_spans,) whose unknowns each is.
        begin: (n_spans,) first local unknown of each.
        end: (n_spans,) behind the last one.
    """

    first: np.ndarray
    node: np.ndarray
    begin: np.ndarray
    end: np.ndarray


class Links(NamedTuple):
    """Constraints and angles of joints as products of vectors, see ``multipliers``.

    Rows are the constraints, then the angles; each product is one, but those of an angle, its
    cosine and its sine, are two.

    Attributes:
        terms: ``Terms`` of the vectors.
        pairs: (n_pairs, 2) vectors of each product.
        rows: (n_pairs,) the row of each.
        values: (n_constraints,) products of the initial configuration.
        nodes: (n,) those on which some row depends.
        local: (n_nodes,) first local unknown of each of them.
        n_rot: (n_nodes,) numbers of rotational variables.
        dofs: (n_local,) the local unknowns.
        spans: ``Spans`` of the rows.
    """

    terms: Terms
    pairs: np.ndarray
    rows: np.ndarray
    values: np.ndarray
    nodes: np.ndarray
    local: np.ndarray
    n_rot: np.ndarray
    dofs: np.ndarray
    spans: Spans


class LinkWork(NamedTuple):
    """What constraints have in an iterate of a step; of m rows the h hard ones come first.

    Attributes:
        u: (3, n_vectors, 3) vectors at start, end and in the mean.
        d: (3, n_terms, 3) the same of their terms.
        weights: (n_pairs,) factors of the products in the changes of rows.
        change: (k,) changes of angles in the step [rad].
        rest: (n_nodes, 3) zeros.
        turns: (n_nodes, 3) Cayley vectors.
        G_m: (m, n_local) gradients at the middle, along which forces act.
        D: (m, n_local) derivatives of the rows.
        G_0: (h, n_local) gradients at the start.
        G_1: (h, n_local) gradients at the end.
        moved: (h, n_local) ``G M^-1`` of the last of both.
        turned: (m, n_local) rows of D in the axes of a kept matrix.
        root_0: (h, h) root L_0 of ``G_0 M^-1 G_0^T``, lower triangular.
        root_1: (h, h) the same at the end.
        impulse: (h, n_local) ``L_0^-1 G_0``.
        kick: (h, n_local) ``L_0^-1 G_0 M^-1``.
        ends: (h, h) matrix of n.
        n: (h,) of the impulses at both ends.
        pushes: (2, n_local) impulses at the start and at the end.
        rates: (n_local,) at the end without impulses.
        acting: (n_local,) forces.
        forces: (m,) multipliers.
        off: (m,) by how much rows are missed.
        give: (m,) compliances.
        columns: (m, n_dof) of ``K^-1 G_m^T``, each one after the other.
        here: (m, n_local) the local unknowns of these.
        matrix: (m, m) of the changes of the multipliers.
        exchanges: (m,) of its rows.
        changes: (m,) of the multipliers.
        way: (k,) what drives want in the step [rad].
        drive: (3,) changes of their works in the last correction and the two before [J].
    """

    u: np.ndarray
    d: np.ndarray
    weights: np.ndarray
    change: np.ndarray
    rest: np.ndarray
    turns: np.ndarray
    G_m: np.ndarray
    D: np.ndarray
    G_0: np.ndarray
    G_1: np.ndarray
    moved: np.ndarray
    turned: np.ndarray
    root_0: np.ndarray
    root_1: np.ndarray
    impulse: np.ndarray
    kick: np.ndarray
    ends: np.ndarray
    n: np.ndarray
    pushes: np.ndarray
    rates: np.ndarray
    acting: np.ndarray
    forces: np.ndarray
    off: np.ndarray
    give: np.ndarray
    columns: np.ndarray
    here: np.ndarray
    matrix: np.ndarray
    exchanges: np.ndarray
    changes: np.ndarray
    way: np.ndarray
    drive: np.ndarray


def link_work(links, hard, n_dof):
    """``LinkWork`` of zeros for ``Links``, the first ``hard`` rows of which are constraints."""
    terms, m, n = links.terms, len(links.spans.first) - 1, len(links.dofs)
    n_nodes, n_constraints = len(links.local), len(links.values)
    zeros = np.zeros
    return LinkWork(
        zeros((3, len(terms.constant), 3)), zeros((3, len(terms.node), 3)),
        zeros(len(links.pairs)), zeros(m - n_constraints), _vectors(n_nodes), _vectors(n_nodes),
        zeros((m, n)), zeros((m, n)), zeros((hard, n)), zeros((hard, n)), zeros((hard, n)),
        zeros((m, n)), zeros((hard, hard)), zeros((hard, hard)), zeros((hard, n)),
        zeros((hard, n)), zeros((hard, hard)), zeros(hard), zeros((2, n)), zeros(n), zeros(n),
        zeros(m), zeros(m), zeros(m), zeros((m, n_dof)), zeros((m, n)), zeros((m, m)),
        zeros(m, dtype=np.int64), zeros(m), zeros(hard - n_constraints), zeros(3))
