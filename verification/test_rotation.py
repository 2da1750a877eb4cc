"""Vectorial rotational variables: derivatives, switching and its invariants (Eqs. 24-30)."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from solver import Model, Settings, simulate
from solver.kernels import rotation
from solver.system import System
from verification.jets import Jet, norm
from verification.models import rectangle, spinning

NO_CHART = np.zeros(4, dtype=np.int64)

component = st.floats(-1.0, 1.0, allow_subnormal=False)
directions = st.tuples(component, component, component).filter(
    lambda v: np.linalg.norm(v) > 1e-3).map(lambda v: np.array(v) / np.linalg.norm(v))
vectors = st.tuples(*[st.floats(-10.0, 10.0, allow_subnormal=False)] * 3).map(np.array)


def chart_of(p, fixed_component=-1):
    chart = np.empty(4, dtype=np.int64)
    rotation.choose_chart(p, p, NO_CHART, fixed_component, chart)
    return chart


def rates_in_chart(p, chart, p_dot, p_ddot):
    """(p_dot, p_ddot) rebuilt from the variables' rates through A1 and A2 (Eq. 30)."""
    A1, rebuilt = np.zeros((3, 3)), np.zeros(3)
    n, m, l = chart[:3]
    rotation.first_derivatives(p, chart, A1)
    rebuilt[l] = rotation.convective(p, chart, p_dot[n], p_dot[m])
    return A1[:, :2] @ p_dot[[n, m]], A1[:, :2] @ p_ddot[[n, m]] + rebuilt


@given(directions)
@example(np.array([0.0, 0.0, 1.0]))
@example(np.array([-1.0, 0.0, 0.0]))
@example(np.array([0.0, -1.0, 0.0]))
@example(np.ones(3) / np.sqrt(3.0))
def test_round_trip(p):
    """p -> (variables, chart) -> p over the whole sphere; the two smallest are the variables."""
    chart = chart_of(p)
    n, m, l, sign = chart
    assert sorted(chart[:3]) == [0, 1, 2]
    assert abs(p[l]) == max(abs(p)) and sign == (1 if p[l] >= 0 else -1)
    back = np.empty(3)
    assert rotation.normal(p[n], p[m], chart, back)
    # p_l = sqrt(1 - n^2 - m^2) with p_l >= 1/sqrt 3: rounding grows by at most 2
    assert np.abs(back - p).max() < 1e-15


@given(directions)
def test_derivatives_against_oracle(p):
    """A1 (Eq. 27) and the second derivatives (Eq. 29) against automatic differentiation."""
    chart = chart_of(p)
    n, m, l, sign = chart
    variables = Jet.variables([p[n], p[m]])
    dependent = (1.0 - variables[0] * variables[0] - variables[1] * variables[1]).sqrt() * sign
    A1 = np.zeros((3, 3))
    rotation.first_derivatives(p, chart, A1)
    assert np.allclose(A1[l, :2], dependent.gradient, rtol=1e-13, atol=1e-14)
    assert np.array_equal(A1[[n, m], :2], np.eye(2))
    nn, nm, mm = rotation.second_derivatives(p, chart)
    assert np.allclose([[nn, nm], [nm, mm]], dependent.hessian, rtol=1e-13, atol=1e-14)
    assert abs(norm(np.array(p)) - 1.0) < 1e-15


@given(directions, vectors, vectors, st.sampled_from([0, 1, 2]))
@settings(max_examples=300)
def test_switch_carries_all_rates(p, spin, change, dependent):
    """Switching keeps p, p_dot and p_ddot, whatever component becomes the dependent one."""
    if abs(p[dependent]) < 0.25:
        return
    p_dot = np.cross(spin, p)
    p_ddot = np.cross(change, p) + np.cross(spin, p_dot)
    old = np.array([(dependent + 1) % 3, (dependent + 2) % 3, dependent,
                    1 if p[dependent] >= 0 else -1])
    start, chart = np.array([0]), old[None].copy()
    variables = np.array([[p[old[0]], p[old[1]], 0.0]])
    velocity = np.array([0.0, 0.0, 0.0, p_dot[old[0]], p_dot[old[1]]])
    acceleration = np.array([0.0, 0.0, 0.0, p_ddot[old[0]], p_ddot[old[1]]])
    switched = rotation.switch_charts(start, np.array([-1]), variables, chart, velocity,
                                      acceleration, p[None].copy(), p[None].copy())
    new = chart[0]
    largest = np.argmax(np.abs(p))
    should = abs(p[largest]) > rotation.SWITCH_RATIO * abs(p[dependent])
    assert switched == should and new[2] == (largest if should else dependent)
    rebuilt = np.empty(3)
    assert rotation.normal(variables[0, 0], variables[0, 1], new, rebuilt)
    # the old dependent component is at least 0.25: its rates lose at most two digits
    scale = 1.0 + np.abs(spin).max() ** 2 + np.abs(change).max()
    assert np.abs(rebuilt - p).max() < 1e-14
    full_dot, full_ddot = np.zeros(3), np.zeros(3)
    full_dot[new[:2]], full_ddot[new[:2]] = velocity[3:], acceleration[3:]
    p_dot_new, p_ddot_new = rates_in_chart(p, new, full_dot, full_ddot)
    assert np.abs(p_dot_new - p_dot).max() < 1e-13 * scale
    assert np.abs(p_ddot_new - p_ddot).max() < 1e-11 * scale


@pytest.mark.parametrize("excess, switches", [(1.0 - 1e-9, 0), (1.0 + 1e-9, 1)])
def test_hysteresis_border(excess, switches):
    """Just below SWITCH_RATIO the chart stays, just above it changes, and does not change back."""
    ratio = rotation.SWITCH_RATIO * excess
    assert rotation.SWITCH_RATIO > 1.0
    p = np.array([1.0, 0.2, ratio])
    p /= np.linalg.norm(p)
    chart = np.array([[1, 2, 0, 1]])
    variables = np.array([[p[1], p[2], 0.0]])
    args = (np.array([0]), np.array([-1]), variables, chart, np.zeros(5), np.zeros(5), p[None],
            p[None])
    assert rotation.switch_charts(*args) == switches
    assert rotation.switch_charts(*args) == 0


def test_switch_is_made_half_a_step_ahead():
    """A normal that will pass the border within half a step switches now, one that will not waits:
    late as often as early, which keeps unresolved oscillations from growing with every switch."""
    for last, switches in ((44.0, 0), (40.0, 1)):
        old, now = (np.array([np.sin(a), 0.0, np.cos(a)]) for a in np.radians((last, 43.5)))
        variables, chart = np.array([[now[0], now[1], 0.0]]), np.array([[0, 1, 2, 1]])
        assert rotation.switch_charts(
            np.array([0]), np.array([-1]), variables, chart, np.zeros(5), np.zeros(5), now[None],
            old[None]) == switches


def test_supported_component_stays_a_variable():
    """A component that a support fixes is the first variable, even when it is the largest."""
    chart = chart_of(np.array([0.9, 0.3, np.sqrt(1.0 - 0.81 - 0.09)]), fixed_component=0)
    assert chart[0] == 0 and chart[2] in (1, 2)
    for fixed in range(3):
        p = np.array([0.5, 0.6, 0.62449979983984])
        assert chart_of(p, fixed_component=fixed)[0] == fixed


def test_leaving_the_chart_is_reported():
    """n^2 + m^2 beyond the limit is a failure of the iterate, NaN included, never a NaN result."""
    chart, p = np.array([0, 1, 2, 1]), np.full(3, 7.0)
    assert not rotation.normal(0.9, 0.9, chart, p)
    assert not rotation.normal(np.nan, 0.0, chart, p)
    assert np.array_equal(p, [7.0, 7.0, 7.0])


@given(st.integers(0, 2**31 - 1))
@settings(max_examples=20)
def test_switching_a_moving_shell_changes_nothing(seed):
    """Energies and momenta of a moving shell are the same before and after a forced switch."""
    rng = np.random.default_rng(seed)
    plate = rectangle(2.0, 1.0, (2, 1))
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    base = Model(plate.nodes @ turn.T, plate.quads, 0.1, 1e3, 0.3, 1.0)
    velocity, omega = rng.normal(size=3), rng.normal(size=3)
    model = spinning(base, omega, velocity)
    system = System(model)
    state = system.initial_state()
    before, p = system.observe(state), system.p.copy()
    # put every node on its second-best chart: the next switch must bring it back
    for i, q in enumerate(p):
        axis = int(np.argsort(np.abs(q))[1])
        if abs(q[axis]) * rotation.SWITCH_RATIO >= np.abs(q).max() or abs(q[axis]) < 0.25:
            continue
        chart = np.array([(axis + 1) % 3, (axis + 2) % 3, axis, 1 if q[axis] >= 0 else -1])
        first = system.numbering.start[i] + 3
        state.chart[i] = chart
        state.variables[i, :2] = q[chart[:2]]
        state.velocity[first:first + 2] = model.normal_velocity[i, chart[:2]]
    middle = system.observe(state)
    rotation.switch_charts(system.numbering.start, np.full(len(p), -1), state.variables,
                           state.chart, state.velocity, state.acceleration, system.p,
                           system.p)
    after = system.observe(state)
    assert np.abs(system.p - p).max() < 1e-14
    for instant in (middle, after):
        assert np.isclose(instant.kinetic, before.kinetic, rtol=1e-12)
        assert abs(instant.strain - before.strain) < 1e-24 * 1e3
        assert np.allclose(instant.linear_momentum, before.linear_momentum, atol=1e-13)
        assert np.allclose(instant.angular_momentum, before.angular_momentum, atol=1e-12)


def test_every_component_becomes_the_largest():
    """A plate spinning about a skew axis takes each component as the dependent one in turn."""
    plate = rectangle(1.0, 1.0, (1, 1), youngs=1e4)
    system = System(spinning(plate, (3.0, 4.0, 0.5), about=(0.5, 0.5, 0.0)))
    state, seen = system.initial_state(), set()
    from solver.scheme import make_scheme
    from solver.system import NewtonRule, StepRecord
    record = StepRecord()
    for k in range(400):
        system.advance(state, make_scheme(), NewtonRule(), k * 0.01, 0.01, record)
        seen |= {(int(c[2]), int(c[3])) for c in state.chart}
        assert np.abs(np.linalg.norm(system.p, axis=1) - 1.0).max() < 1e-15
    assert {axis for axis, _ in seen} == {0, 1, 2}
    assert record.switches > 20


def test_a_step_that_leaves_the_chart_is_halved():
    """A rotation of 2 rad a step cannot be made in one chart: the record says it was divided."""
    plate = rectangle(1.0, 1.0, (1, 1))
    model = spinning(plate, (20.0, 0.0, 0.0), about=(0.5, 0.5, 0.0))
    result = simulate(model, Settings(dt=0.1, end_time=1.0))
    assert result.history["halvings"].sum() > 0
    assert np.all(np.isfinite(result.total_energy))
