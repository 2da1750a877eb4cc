"""Hinges with moments, as an item of the system; the angles of all, and what joints hold."""

import numpy as np
from scipy.sparse import coo_array

from ..kernels import hinges
from ..kernels.arguments import DONE
from ..kernels.calls import Call
from ..model.bodies import GROUND, own_nodes
from ..model.joints import shares_of_edge
from ..model.linkages import LINKED, Cylindrical, Prismatic, Revolute, RigidLink, Tie, Universal
from ..model.mechanism import carried, moved, turns
from .failure import NotConverged
from .state import blank_state
from .turning import nearest


class Angle:
    """The angle of a hinge of a model, whether it has a moment or not."""

    def __init__(self, model, hinge):
        """``hinge``: ``Hinge``."""
        line, cells = np.array(hinge.nodes), hinge.tied
        self._edges, self._share = _edges(line), shares_of_edge(model.nodes[line])
        self._directors = model.directors.first[cells]
        self._angles, self._found = Call(hinges.angles), np.zeros(len(cells))
        self._initial = 0.0
        self._initial = self._measured(blank_state(model.nodes, 0), model.normals).copy()

    def __call__(self, state, p, last):
        """The mean angle [rad] at a state with normals p, within half a turn of the ``last``."""
        return float(self._share @ nearest(self._measured(state, p), last))

    def _measured(self, state, p):
        self._angles(self._edges, self._directors, state.motion, p, self._found)
        return self._found - self._initial


class Relative:
    """How far ``other`` has moved against ``one`` by a joint with an axis: turned about it, slid
    along it; of a universal joint, how far its cross has turned about ``axis`` against ``one``, and
    ``other`` about ``other_axis`` against the cross.

    Attributes:
        turns, slides, crosses: whether the joint lets it, as far as both ends know of the turn; and
            no moment follows the first already.
    """

    def __init__(self, model, joint):
        self._axis = np.array(joint.axis)
        node_of = own_nodes(model)
        self._ends = [None if end == GROUND else node_of.get(end, end) for end in joint.ends]
        smooth = [end is not None and np.diff(model.directors.first[end:end + 2])[0] == 1
                  for end in self._ends]
        self._at = [None if end is None else slice(*model.directors.first[end:end + 2].tolist())
                    for end in self._ends]
        self._normals = [None if at is None else model.normals[at] for at in self._at]
        self._place = joint.place(model.nodes)
        self._arms = [self._place if end is None else np.zeros(3) if single else
                      self._place - model.nodes[end] for end, single in zip(self._ends, smooth)]
        cross = isinstance(joint, Universal)
        self._side = np.array(joint.other_axis) if cross else (  # at right angles to the axis
            np.linalg.svd(self._axis[None])[2][1])
        self.slides = isinstance(joint, (Cylindrical, Prismatic))
        self.crosses = cross and not any(smooth)
        self.turns = isinstance(joint, (Cylindrical, Revolute, Universal)) and not any(
            smooth) and not (isinstance(joint, Revolute) and joint.places)

    def __call__(self, state, p, last, last_other):
        """Angle [rad] and that of ``other`` about the cross, each within half a turn of the last
        one, and slide [m], at a state with normals p."""
        turned = [np.eye(3) if end is None else turns(initial, p[None, at])[0]
                  for end, at, initial in zip(self._ends, self._at, self._normals)]
        axis, side = turned[0] @ self._axis, turned[0] @ self._side
        arm = turned[1] @ self._side
        points = [turn @ arm + (0.0 if end is None else state.x[end] + state.x_low[end])
                  for end, turn, arm in zip(self._ends, turned, self._arms)]
        angle, crossed = _about(axis, side, arm), _about(arm, axis, turned[1] @ self._axis)
        return (float(nearest(angle, last)) if self.turns else 0.0,
                float(nearest(crossed, last_other)) if self.crosses else 0.0,
                float((points[1] - points[0]) @ axis) if self.slides else 0.0)


def _about(axis, begin, end):
    """Angle from one vector to another about an axis at right angles to both [rad]."""
    return np.arctan2(end @ np.cross(axis, begin), end @ begin)


class EndPlaces:
    """Places of joints with ends, each on the end on which its force is told."""

    def __init__(self, model):
        node_of, self._points = own_nodes(model), {}
        for number, joint in enumerate(model.joints):
            if isinstance(joint, Tie):
                self._points[number] = [carried(model, i, model.nodes[i]) for i in joint.nodes]
            elif isinstance(joint, LINKED):
                side = 0 if joint.other == GROUND else 1
                node = node_of.get(joint.ends[side], joint.ends[side])
                at = (joint.at, joint.to)[side] if isinstance(joint, RigidLink) else (
                    joint.place(model.nodes))
                if node == joint.ends[side] or at is None:
                    at = model.nodes[node]
                self._points[number] = [carried(model, node, at)]

    def __call__(self, positions, directors):
        """``{number: (3,)}`` means of the places with positions (2, n_nodes, 3) of the nodes and
        directors (2, n_directors, 3) [m]."""
        return {number: np.mean([moved(point, positions, directors) for point in points],
                                axis=(0, 1)) for number, points in self._points.items()}


class JointForces:
    """Forces by which each joint holds the first of its plates, of those on joined nodes."""

    def __init__(self, model, joined):
        """``joined``: nodes in the order of the forces."""
        at = {node: k for k, node in enumerate(joined.tolist())}
        group_of = {node: k for k, group in enumerate(model.joined) for node in group}
        pairs = [[] for _ in model.joined]
        for number, joint in enumerate(model.joints):
            for one, other in joint.tied.tolist():
                pairs[group_of[one]].append((number, one, other))
        rows, columns, values = [], [], []
        for group, tied in zip(model.joined, pairs):
            places = {node: k for k, node in enumerate(group)}
            A = np.zeros((len(group), len(tied)))
            for k, (_, one, other) in enumerate(tied):
                A[places[one], k], A[places[other], k] = 1.0, -1.0
            # of a loop of joints at one place, the least forces that there are
            for (number, *_), row in zip(tied, np.linalg.pinv(A)):
                rows += [number] * len(group)
                columns += [at[node] for node in group]
                values += row.tolist()
        self._of_joints = coo_array((values, (rows, columns)),
                                    shape=(len(model.joints), len(joined))).tocsr()

    def __call__(self, forces):
        """(n_joints, 3) of forces (n_joined, 3) on the nodes [N]."""
        return self._of_joints @ forces


class Hinges:
    """All places, two nodes each, at which a hinge has a moment.

    Attributes:
        cells: (n, 2) nodes, of ``nodes`` and of ``others``.
    """

    def __init__(self, model, turnings):
        """``turnings``: ``Turnings``, whose first places these are."""
        n = turnings.hinges
        cells, edges = [], []
        for number in dict.fromkeys(turnings.joints[:n].tolist()):
            joint = model.joints[number]
            cells.extend(joint.tied)
            edges.extend(_edges(np.array(joint.nodes)))
        self.cells = np.array(cells, dtype=np.int64).reshape(-1, 2)
        self._edges = np.array(edges, dtype=np.int64).reshape(-1, 2)
        self._directors = model.directors.first[self.cells]
        self._constants, self._n_nodes = turnings.constants[:n], len(model.nodes)
        self._on_rotations, self._found = np.zeros((n, 6)), np.zeros(n)
        self._add_forces = Call(hinges.add_hinge_forces)
        self._add_stiffness = Call(hinges.add_hinge_stiffness)
        self._angles, self._moments = Call(hinges.angles), Call(hinges.moments)
        self._initial = self._measured(blank_state(model.nodes, 0), model.normals).copy()

    def __bool__(self):
        return len(self.cells) > 0

    def follow(self, state, p):
        """Angles of a ``state`` with the normals p."""
        last = state.hinges[:len(self.cells), hinges.ANGLE]
        last[:] = nearest(self._measured(state, p) - self._initial, last)

    def add_forces(self, dofs, iterate, start, end, motors, slacks, forces):
        """Add the forces at an iterate to ``forces`` (n_dof,); ``start`` and ``end``: normals
        (n_directors, 3) there.

        Raises:
            NotConverged: plates fold by a right angle or more in the step.
        """
        n = len(self.cells)
        lost = self._add_forces(
            dofs.nodes, self._edges, self._directors, self.cells, self._constants,
            iterate.state.hinges[:n], motors[:n], slacks[:n], iterate.state.motion, iterate.delta,
            iterate.step, start, end, iterate.A1, forces, self._on_rotations)
        if lost != DONE:
            raise NotConverged(f"the hinge at node {lost} turns too far")

    def add_matrix(self, dofs, storage, values, skew):
        """Add their stiffness in the iterate whose forces were added last."""
        self._add_stiffness(dofs, storage, self.cells, self._on_rotations, values, skew)

    def linear(self, dofs, state, motion):
        """Changes (n_dof,) of the forces of springs, stops and latches by a small ``motion``
        (n_dof,) from a ``state``, whose forces were added before, at the angles of its start;
        ``moments`` are with them then."""
        change = np.zeros_like(motion)
        turned = self.moment_changes(dofs, state, motion)
        self.moments[:] += turned
        np.add.at(change, self._turning(dofs), turned[:, None] * self._on_rotations[:, :4])
        return change

    def moment_changes(self, dofs, state, motion):
        """(n,) changes of the moments that turn hinges on, the same [N m]."""
        own, found = state.hinges[:len(self.cells)], np.empty((len(self.cells), 2))
        self._moments(self._constants, own, own[:, hinges.SLACK].copy(),
                      own[:, hinges.ANGLE].copy(), 1.0, 0.0, found)
        return -found[:, 1] * np.sum(self._on_rotations[:, :4] * motion[self._turning(dofs)],
                                     axis=1)

    def _turning(self, dofs):
        """(n, 4) numbers of the rotational variables of both nodes."""
        return (dofs.nodes.start[self.cells][:, :, None] + np.array((3, 4))).reshape(-1, 4)

    def curvature(self, dofs, state, p, A1, moments):
        """``-M d2phi`` (n_dof, n_dof), sparse: what moments M (n,) that turn the hinges on add to
        the tangent at a ``state`` with the normals ``p`` and their derivatives ``A1``, as angles
        are curved in the unknowns."""
        rows, columns, values, x = [], [], [], state.x + state.x_low
        for edge, pair, cell, moment in zip(self._edges, self._directors, self.cells, moments):
            gradient, hessian = angle_derivatives(x[edge[1]] - x[edge[0]], *p[pair])
            J, at = np.zeros((9, 10)), np.empty(10, dtype=np.int64)
            J[:3, :3], J[:3, 3:6] = -np.eye(3), np.eye(3)
            at[:6] = (dofs.nodes.start[edge][:, None] + np.arange(3)).ravel()
            curved = np.zeros((10, 10))
            for side, (d, node) in enumerate(zip(pair, cell)):
                on, own = slice(3 + 3 * side, 6 + 3 * side), slice(6 + 2 * side, 8 + 2 * side)
                J[on, own], at[own] = A1[d, :, :2], dofs.nodes.start[node] + np.array((3, 4))
                *n, up = state.chart[node] @ p[d]
                second = -(np.eye(2) + np.outer(n, n) / up**2) / up  # Eq. (29)
                curved[own, own] = (gradient[on] @ state.chart[node, 2]) * second
            rows.append(np.repeat(at, 10))
            columns.append(np.tile(at, 10))
            values.append(-moment * (J.T @ hessian @ J + curved).ravel())
        size = (len(dofs.fixed),) * 2
        return coo_array((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
                         shape=size).tocsr()

    @property
    def moments(self):
        """(n,) that turn the hinges on, motors among them, of the forces that were added last
        [N m]."""
        return self._on_rotations[:, 5]

    def torques(self, p, A1):
        """(n_nodes, 3) of these moments on the nodes of the plates [N m], with the normals and
        their derivatives in the iterate whose forces were added last."""
        found = np.zeros((self._n_nodes, 3))
        for side, on in enumerate((slice(0, 2), slice(2, 4))):
            d = self._directors[:, side]
            A, g = A1[d, :, :2], self.moments[:, None] * self._on_rotations[:, on]
            f = np.einsum("nij,njk,nk->ni", A, np.linalg.inv(A.transpose(0, 2, 1) @ A), g)
            np.add.at(found, self.cells[:, side], np.cross(p[d], f))
        return found

    def _measured(self, state, p):
        """Angles (n,) of normals, in (-pi, pi]."""
        self._angles(self._edges, self._directors, state.motion, p, self._found)
        return self._found


def _edges(line):
    """(n, 2) nodes at both ends of the edge around each node of a line."""
    return np.stack([np.r_[line[0], line[:-1]], np.r_[line[1:], line[-1]]], axis=1)


def angle_derivatives(e, p_a, p_b):
    """First (9,) and second (9, 9) derivatives of ``phi = atan2(s, c)`` in e, p_a and p_b, with
    ``c = p_a . p_b``, ``s = tau / |e|`` and ``tau = e . (p_a x p_b)``."""
    edge, a, b = slice(3), slice(3, 6), slice(6, 9)
    length, n = np.linalg.norm(e), np.cross(p_a, p_b)
    c, tau = p_a @ p_b, e @ n
    dc, dtau, dl = np.zeros((3, 9))
    dc[a], dc[b] = p_b, p_a
    dtau[edge], dtau[a], dtau[b] = n, np.cross(p_b, e), np.cross(e, p_a)
    dl[edge] = e / length
    ddc, ddtau, ddl = np.zeros((3, 9, 9))
    ddc[a, b] = np.eye(3)
    ddtau[a, b], ddtau[edge, a], ddtau[edge, b] = _across(-e), _across(-p_b), _across(p_a)
    ddc, ddtau = ddc + ddc.T, ddtau + ddtau.T
    ddl[edge, edge] = (np.eye(3) - np.outer(dl[edge], dl[edge])) / length
    s = tau / length
    ds = (dtau - s * dl) / length
    dds = (ddtau - np.outer(ds, dl) - np.outer(dl, ds) - s * ddl) / length
    square = c**2 + s**2
    gradient, drift = (c * ds - s * dc) / square, (c * dc + s * ds) / square
    mixed = np.outer(gradient, drift)
    return gradient, (c * dds - s * ddc) / square - mixed - mixed.T


def _across(v):
    """(3, 3) of ``v x``."""
    return np.cross(v, np.eye(3)).T
