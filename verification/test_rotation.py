"""Vectorial rotational variables: derivatives, charts and their invariants (Eqs. 24-36)."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from corovec import AccuracyWarning, Newton, Scheme, Settings, Support, simulate
from corovec.solver.dynamics.newton import StepRecord
from corovec.solver.dynamics.stepping import Stepper
from corovec.solver.kernels import charts, junctions, nodes
from corovec.solver.kernels.arguments import STATIC, Motion, Nodes, nodal_work
from corovec.solver.model.model import STEEPEST_COMPONENT
from corovec.solver.system.coordinates import Charts
from corovec.solver.system.system import System
from corovec.verification.jets import Jet, norm
from corovec.verification.models import rectangle, spinning

NONE = np.zeros((3, 3))
GLOBAL, FOLLOWING = False, True

FREE = np.zeros(3)
"""No axis that a support keeps."""

AS_IT_IS = STATIC._replace(alpha_f=0.5, stiffness=0.5, acceleration=-1.0, rate_velocity=-1.0,
                           strain_end=0.5, strain_start=0.5)
"""Rates and second rates of a state, without an increment."""

component = st.floats(-1.0, 1.0, allow_subnormal=False)
directions = st.tuples(component, component, component).filter(
    lambda v: np.linalg.norm(v) > 1e-3).map(lambda v: np.array(v) / np.linalg.norm(v))
vectors = st.tuples(*[st.floats(-10.0, 10.0, allow_subnormal=False)] * 3).map(np.array)
seeds = st.integers(0, 2**31 - 1)


def triad_of(p, kept=FREE):
    """Global axes of a normal that has none yet."""
    triad = np.empty((3, 3))
    charts.choose_triad(p, p, NONE, kept, GLOBAL, triad)
    return triad


def axes_triad(dependent, p):
    """Global axes with a given dependent component."""
    triad = np.eye(3)[[(dependent + 1) % 3, (dependent + 2) % 3, dependent]]
    triad[2] *= 1.0 if p[dependent] >= 0.0 else -1.0
    return triad


def smooth_node():
    """``Nodes`` of one smooth node whose rotational variables are dofs 3 and 4."""
    return Nodes(np.array([0]), np.array([2]), np.array([0, 1]), np.zeros((1, 3)))


def motion(variables, chart, velocity, acceleration):
    """``Motion`` of one node at the origin."""
    return Motion(np.zeros((1, 3)), np.zeros((1, 3)), variables, chart, velocity, acceleration)


def rates_in_chart(p, triad, n_dot, n_ddot):
    """(p_dot, p_ddot) rebuilt from the variables' rates through A1 and A2 (Eq. 30)."""
    A1 = np.zeros((3, 3))
    charts.first_derivatives(p, triad, A1)
    nn, nm, mm = charts.second_derivatives(p, triad)
    bent = nn * n_dot[0]**2 + 2.0 * nm * n_dot[0] * n_dot[1] + mm * n_dot[1]**2
    return A1[:, :2] @ n_dot, A1[:, :2] @ n_ddot + bent * triad[2]


@given(directions)
@example(np.array([0.0, 0.0, 1.0]))
@example(np.array([-1.0, 0.0, 0.0]))
@example(np.array([0.0, -1.0, 0.0]))
@example(np.ones(3) / np.sqrt(3.0))
def test_round_trip(p):
    """p -> (variables, axes) -> p over the whole sphere; the two smallest are the variables."""
    triad = triad_of(p)
    n, m, l = (int(np.flatnonzero(axis)[0]) for axis in triad)
    assert sorted((n, m, l)) == [0, 1, 2] and np.all(triad[:2] >= 0.0)
    assert abs(p[l]) == max(abs(p)) and triad[2, l] == (1 if p[l] >= 0 else -1)
    back = np.empty(3)
    assert charts.normal(p[n], p[m], triad, back)
    # p_l = sqrt(1 - n^2 - m^2) with p_l >= 1/sqrt 3: rounding grows by at most 2
    assert np.abs(back - p).max() < 1e-15


@given(directions, st.booleans(), seeds)
def test_derivatives_against_oracle(p, turned, seed):
    """A1 (Eq. 27) and the second derivatives (Eq. 29) against automatic differentiation, in global
    and in any other axes."""
    triad = triad_of(p)
    if turned:
        triad = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
        assume(abs(p @ triad[2]) > 0.3)
        triad[2] *= np.sign(p @ triad[2])
    variables = Jet.variables([p @ triad[0], p @ triad[1]])
    dependent = (1.0 - variables[0] * variables[0] - variables[1] * variables[1]).sqrt()
    A1 = np.zeros((3, 3))
    charts.first_derivatives(p, triad, A1)
    expected = triad[:2].T + np.outer(triad[2], dependent.gradient)
    assert np.allclose(A1[:, :2], expected, rtol=1e-13, atol=1e-13)
    nn, nm, mm = charts.second_derivatives(p, triad)
    assert np.allclose([[nn, nm], [nm, mm]], dependent.hessian, rtol=1e-12, atol=1e-13)
    assert abs(norm(np.array(p)) - 1.0) < 1e-15


@given(directions, vectors, vectors, st.sampled_from([0, 1, 2]), st.booleans())
@settings(max_examples=300)
def test_switch_carries_all_rates(p, spin, change, dependent, follow):
    """New axes keep p, p_dot and p_ddot, whatever component becomes the dependent one."""
    assume(abs(p[dependent]) >= 0.25)
    p_dot = np.cross(spin, p)
    p_ddot = np.cross(change, p) + np.cross(spin, p_dot)
    chart = axes_triad(dependent, p)[None]
    variables = np.zeros((1, 3))
    variables[0, :2] = chart[0, :2] @ p
    velocity, acceleration = np.zeros(5), np.zeros(5)
    velocity[3:], acceleration[3:] = chart[0, :2] @ p_dot, chart[0, :2] @ p_ddot
    switched = nodes.switch_charts(smooth_node(), FREE[None], follow, 0.0,
                                   motion(variables, chart, velocity, acceleration))
    new, largest = chart[0], np.argmax(np.abs(p))
    if follow:
        # t_1 of the old axes may be too near to p to go on from: then global axes are taken
        assert new[2] @ p > 1.0 - 1e-14 or abs(new[2]).max() == 1.0
    else:
        should = abs(p[largest]) > charts.SWITCH_RATIO * abs(p[dependent])
        assert switched == should
        assert np.argmax(np.abs(new[2])) == (largest if should else dependent)
    assert np.allclose(new @ new.T, np.eye(3), atol=1e-15)
    rebuilt = np.empty(3)
    assert charts.normal(variables[0, 0], variables[0, 1], new, rebuilt)
    # the old dependent component is at least 0.25: its rates lose at most two digits
    scale = 1.0 + np.abs(spin).max() ** 2 + np.abs(change).max()
    assert np.abs(rebuilt - p).max() < 1e-14
    p_dot_new, p_ddot_new = rates_in_chart(p, new, velocity[3:], acceleration[3:])
    assert np.abs(p_dot_new - p_dot).max() < 1e-13 * scale
    assert np.abs(p_ddot_new - p_ddot).max() < 1e-11 * scale


@pytest.mark.parametrize("excess, switches", [(1.0 - 1e-9, 0), (1.0 + 1e-9, 1)])
def test_hysteresis_border(excess, switches):
    """Just below SWITCH_RATIO the chart stays, just above it changes, and does not change back."""
    ratio = charts.SWITCH_RATIO * excess
    assert charts.SWITCH_RATIO > 1.0
    p = np.array([1.0, 0.2, ratio])
    p /= np.linalg.norm(p)
    chart = axes_triad(0, p)[None]
    variables = np.array([[p[1], p[2], 0.0]])
    args = (smooth_node(), FREE[None], GLOBAL, 0.0,
            motion(variables, chart, np.zeros(5), np.zeros(5)))
    assert nodes.switch_charts(*args) == switches
    assert nodes.switch_charts(*args) == 0


def test_switch_is_made_half_a_step_ahead():
    """A normal that will pass the border within half a step switches now, one that will not waits:
    late as often as early, which keeps unresolved oscillations from growing with every switch."""
    angle, dt = np.radians(43.5), 0.1
    for rate, switches in ((-10.0, 0), (10.0, 0), (40.0, 1)):
        p = np.array([np.sin(angle), 0.0, np.cos(angle)])
        velocity = np.array([0.0, 0.0, 0.0, np.radians(rate) * np.cos(angle), 0.0])
        assert nodes.switch_charts(
            smooth_node(), FREE[None], GLOBAL, dt, motion(
                np.array([[p[0], p[1], 0.0]]), np.eye(3)[None].copy(), velocity,
                np.zeros(5))) == switches


def test_following_axes_point_to_the_middle_of_the_next_step():
    """t_3 is where a steadily turning normal will be half a step later, to second order."""
    rate, dt = 3.0, 0.05
    chart, variables = np.eye(3)[None].copy(), np.zeros((1, 3))
    velocity = np.array([0.0, 0.0, 0.0, rate, 0.0])
    nodes.switch_charts(smooth_node(), FREE[None], FOLLOWING, dt,
                        motion(variables, chart, velocity, np.zeros(5)))
    middle = np.array([np.sin(0.5 * rate * dt), 0.0, np.cos(0.5 * rate * dt)])
    assert np.abs(chart[0, 2] - middle).max() < (0.5 * rate * dt) ** 3
    assert abs(variables[0, 0] + np.sin(0.5 * rate * dt)) < (0.5 * rate * dt) ** 3


def test_supported_component_stays_a_variable():
    """A component that a support fixes is the first variable, even when it is the largest."""
    triad = triad_of(np.array([0.9, 0.3, np.sqrt(1.0 - 0.81 - 0.09)]), kept=np.eye(3)[0])
    assert triad[0, 0] == 1.0 and triad[2, 0] == 0.0
    p = np.array([0.5, 0.6, 0.62449979983984])
    for fixed in range(3):
        old, new = triad_of(p, kept=np.eye(3)[fixed]), np.empty((3, 3))
        assert old[0, fixed] == 1.0
        ahead = p + 0.1 * np.cross(np.eye(3)[fixed], p)
        assert charts.choose_triad(p, ahead / np.linalg.norm(ahead), old, np.eye(3)[fixed],
                                   FOLLOWING, new)
        assert np.array_equal(new[0], np.eye(3)[fixed]) and new[2, fixed] == 0.0
        assert np.allclose(new @ new.T, np.eye(3), atol=1e-15)


def test_leaving_the_chart_is_reported():
    """n^2 + m^2 beyond the limit is a failure of the iterate, NaN included, never a NaN result."""
    p, e = np.full(3, 7.0), np.full((3, 3), 7.0)
    assert not charts.normal(0.9, 0.9, np.eye(3), p)
    assert not charts.normal(np.nan, 0.0, np.eye(3), p)
    assert np.array_equal(p, [7.0, 7.0, 7.0])
    for variables in ((0.9, 0.9, 0.0), (0.0, 0.0, 0.99), (0.5, 0.0, 0.85), (0.0, np.nan, 0.0),
                      (0.0, 0.0, np.nan)):
        assert not junctions.nodal_frame(*variables, np.eye(3), e)
    assert np.all(e == 7.0)


def test_fallback_axes_suit_the_normal_as_it_is():
    """A normal that is about to turn too far for following axes gets axes that suit it now."""
    p = np.array([np.sin(0.3), 0.0, np.cos(0.3)])
    old, new = np.empty((3, 3)), np.empty((3, 3))
    charts.choose_triad(p, p, triad_of(p), FREE, FOLLOWING, old)
    ahead = p + (0.0, 4.5, 0.0)
    assert charts.choose_triad(p, ahead / np.linalg.norm(ahead), old, FREE, FOLLOWING, new)
    assert new[2] @ p > 1.0 / np.sqrt(3.0)
    e = random_frame(np.random.default_rng(1))
    junctions.choose_junction_triad(e, e, np.eye(3), FREE, True, old)
    turned = e @ Rotation.from_rotvec(np.radians(100.0) * e[0]).as_matrix().T
    assert junctions.choose_junction_triad(e, turned, old, FREE, True, new)
    assert e[1] @ new[2] > 0.5


@pytest.mark.parametrize("axes", ["nodal", "global"])
def test_steep_normal_turns_about_its_fixed_component(axes):
    """The steepest component that a support may hold alone lets the normal turn all the way."""
    share = STEEPEST_COMPONENT - 1e-9
    tilt = np.array([np.sqrt(share), 0.0, np.sqrt(1.0 - share)])
    plate = rectangle(1.0, 1.0, (1, 1))
    # the plate is perpendicular to its normal, which turns about X once a second
    turn = Rotation.align_vectors([tilt], [(0.0, 0.0, 1.0)])[0].as_matrix()
    model = replace(plate, nodes=plate.nodes @ turn.T, normals=None,
                    supports=[Support((0, 1, 2, 3), ("x", "px"))])
    model = spinning(model, (2.0 * np.pi, 0.0, 0.0))
    result = simulate(model, Settings(dt=1.0 / 80.0, end_time=1.0, scheme=Scheme(axes=axes)))
    assert np.abs(result.normals[:, 0] - tilt[0]).max() < 1e-15
    assert np.abs(result.total_energy / result.total_energy[0] - 1.0).max() < 1e-3
    assert result.normals[0] @ tilt > 0.99


# --- junctions: three variables n = e_y . t_1, m = e_y . t_2, k = e_z . t_1

BODY = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.6, 0.48, 0.64]])


def junction_node():
    """``Nodes`` of one junction with three directors."""
    return Nodes(np.array([0]), np.array([3]), np.array([0, 3]), BODY)


def random_frame(rng):
    """Rows e_x, e_y, e_z."""
    return Rotation.random(rng=rng).as_matrix()


def junction(e, follow=False, ahead=None):
    """(triad, variables) of a nodal frame."""
    triad = np.empty((3, 3))
    junctions.choose_junction_triad(e, e if ahead is None else ahead, NONE, FREE, False, triad)
    if follow:
        old, triad = triad, np.empty((3, 3))
        junctions.choose_junction_triad(e, e if ahead is None else ahead, old, FREE, True, triad)
    return triad, np.array([e[1] @ triad[0], e[1] @ triad[1], e[2] @ triad[0]])


def directors(variables, triad):
    """Directors (3, 3) of the junction, plainly from the definition."""
    e = np.empty((3, 3))
    assert junctions.nodal_frame(*variables, triad, e)
    return BODY @ e


@given(seeds, st.booleans())
@settings(max_examples=200)
def test_junction_frame_round_trip(seed, follow):
    """Any nodal frame comes back from its three variables, orthonormal and right-handed; with
    global axes these are the components that the paper takes."""
    e = random_frame(np.random.default_rng(seed))
    triad, variables = junction(e, follow)
    back = np.empty((3, 3))
    assert junctions.nodal_frame(*variables, triad, back)
    # the worst chart has s^2 = 1/3 and k^2/(1 - n^2) = 1/2: rounding grows by a few
    assert np.abs(back - e).max() < 5e-15
    if follow:
        assert np.abs(variables).max() < 1e-15
    else:
        n, m, l = (int(np.flatnonzero(axis)[0]) for axis in triad)
        assert abs(e[1, l]) == np.abs(e[1]).max()
        assert abs(e[2, n]) <= abs(e[2, m])


@pytest.mark.slow
@given(seeds, st.booleans())
@settings(max_examples=50)
def test_junction_derivatives(seed, follow):
    """A1 = dp/dn (Eqs. 31-35), f . d2p/dn2, and A2 against central differences of the directors."""
    rng = np.random.default_rng(seed)
    e = random_frame(rng)
    ahead = Rotation.from_rotvec(rng.uniform(-0.2, 0.2, 3)).apply(e)
    triad, x = junction(e, follow, ahead)
    node, p, A1 = junction_node(), np.empty((3, 3)), np.empty((3, 3, 3))
    assert nodes.place_directors(node, x[None], triad[None], p, A1) == -1
    assert np.abs(p - directors(x, triad)).max() < 1e-15
    step, unit = 1e-4, np.eye(3)

    def difference(function, k):
        """Fourth order."""
        near = function(x + step * unit[k]) - function(x - step * unit[k])
        far = function(x + 2 * step * unit[k]) - function(x - 2 * step * unit[k])
        return (8.0 * near - far) / (12.0 * step)

    def first(variables):
        there, A = np.empty((3, 3)), np.empty((3, 3, 3))
        nodes.place_directors(node, variables[None], triad[None], there, A)
        return A

    numeric = np.stack([difference(lambda v: directors(v, triad), k) for k in range(3)], axis=2)
    assert np.abs(A1 - numeric).max() < 1e-10
    again = np.empty((3, 3, 3))
    nodes.derivatives(node, triad[None], p, again)
    assert np.abs(again - A1).max() < 1e-13
    second = np.stack([difference(first, k) for k in range(3)], axis=3)
    forces, H = rng.normal(size=(3, 3)), np.empty((3, 3))
    nodes.curvature(node, 0, p, A1, triad[None], forces, np.zeros((1, 3)), H)
    assert np.abs(H - np.einsum("dc,dckl->kl", forces, second)).max() < 1e-8
    rate = rng.normal(size=3)
    velocity, acceleration = np.r_[np.zeros(3), rate], np.r_[np.zeros(3), rng.normal(size=3)]
    work = nodal_work(1, 3)
    assert nodes.advance_nodes(node, motion(x[None], triad[None], velocity, acceleration), AS_IT_IS,
                               np.zeros(6), work) == -1
    p_ddot = A1 @ acceleration[3:] + np.einsum("dckl,k,l->dc", second, rate, rate)
    assert np.abs(work.inertial_p - p_ddot).max() < 1e-7


@given(seeds, st.booleans())
@settings(max_examples=100)
def test_junction_switch_carries_spin(seed, follow):
    """New axes keep the directors, their rates and their accelerations."""
    rng = np.random.default_rng(seed)
    e, spin, change = random_frame(rng), rng.normal(size=3), rng.normal(size=3)
    # axes that suited a frame turned by up to half a radian in each component
    there = Rotation.from_rotvec(rng.uniform(-0.5, 0.5, 3)).apply(e)
    triad, _ = junction(there)
    x = np.array([[e[1] @ triad[0], e[1] @ triad[1], e[2] @ triad[0]]])
    back = np.empty((3, 3))
    assume(junctions.nodal_frame(*x[0], triad, back) and np.abs(back - e).max() < 1e-12)
    node, p, A1 = junction_node(), np.empty((3, 3)), np.empty((3, 3, 3))

    def rates():
        """p, p_dot, p_ddot from the variables."""
        nodes.place_directors(node, x, chart, p, A1)
        work = nodal_work(1, 3)
        nodes.advance_nodes(node, moving, AS_IT_IS, np.zeros(6), work)
        return p.copy(), A1 @ velocity[3:], work.inertial_p

    chart = triad[None].copy()
    velocity, acceleration = np.r_[np.zeros(3), spin], np.r_[np.zeros(3), change]
    moving = motion(x, chart, velocity, acceleration)
    before = rates()
    nodes.switch_charts(node, FREE[None], follow, 0.01, moving)
    for old, new in zip(before, rates(), strict=True):
        # axes up to their limit: rates lose at most three digits
        assert np.abs(new - old).max() < 1e-11 * (1.0 + np.abs(before[2]).max())


@given(seeds)
@settings(max_examples=20)
def test_switching_a_moving_shell_changes_nothing(seed):
    """Energies and momenta of a moving shell are the same before and after a forced switch."""
    rng = np.random.default_rng(seed)
    plate = rectangle(2.0, 1.0, (2, 1))
    turn = random_frame(rng)
    base = replace(plate, nodes=plate.nodes @ turn.T, youngs=1e3, normals=None)
    velocity, omega = rng.normal(size=3), rng.normal(size=3)
    model = spinning(base, omega, velocity)
    system = System(model)
    state = system.initial_state()
    before = system.observe(state)
    p = before.start.p
    # put every node on its second-best axes: the next switch must bring it back
    for i, q in enumerate(p):
        axis = int(np.argsort(np.abs(q))[1])
        if abs(q[axis]) * charts.SWITCH_RATIO >= np.abs(q).max() or abs(q[axis]) < 0.25:
            continue
        first = system.numbering.start[i] + 3
        state.chart[i] = axes_triad(axis, q)
        state.variables[i, :2] = state.chart[i, :2] @ q
        state.velocity[first:first + 2] = state.chart[i, :2] @ model.normal_velocity[i]
    middle = system.observe(state)
    Charts(model, system.numbering, bool(rng.integers(2))).renew(state, 0.0)
    after = system.observe(state)
    assert np.abs(after.start.p - p).max() < 1e-14
    expected = before.observed
    for seen in (middle.observed, after.observed):
        assert np.isclose(seen.kinetic, expected.kinetic, rtol=1e-12)
        assert abs(seen.strain - expected.strain) < 1e-24 * 1e3
        assert np.allclose(seen.linear_momentum, expected.linear_momentum, atol=1e-13)
        assert np.allclose(seen.angular_momentum, expected.angular_momentum, atol=1e-12)


def test_every_component_becomes_the_largest():
    """A plate spinning about a skew axis takes each component as the dependent one in turn."""
    plate = rectangle(1.0, 1.0, (1, 1), youngs=1e4)
    system = System(spinning(plate, (3.0, 4.0, 0.5), about=(0.5, 0.5, 0.0)), follow=False)
    state, seen = system.initial_state(), set()
    stepper, record = Stepper(system, Scheme(), Newton("full")), StepRecord()
    place = system.observe(state)
    for k in range(400):
        stepper.advance(state, place, k * 0.01, 0.01, record)
        seen |= {int(np.argmax(np.abs(triad[2]))) for triad in state.chart}
        assert np.abs(np.linalg.norm(place.start.p, axis=1) - 1.0).max() < 1e-15
    assert seen == {0, 1, 2}
    assert record.switches > 20


def test_a_step_that_leaves_the_chart_is_halved():
    """A rotation of 2 rad a step cannot be made in one chart: the record says it was divided."""
    plate = rectangle(1.0, 1.0, (1, 1))
    model = spinning(plate, (20.0, 0.0, 0.0), about=(0.5, 0.5, 0.0))
    with pytest.warns(AccuracyWarning, match="halvings in the first"):
        result = simulate(model, Settings(dt=0.1, end_time=1.0, newton=Newton("full")))
    assert result.history["halvings"].sum() > 0
    assert np.all(np.isfinite(result.total_energy))
