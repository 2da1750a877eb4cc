"""The modified Newton iteration: the same steps as the full one, from far fewer factorizations."""

import numpy as np
import pytest

from corovec import Model, Newton, NodalLoad, Scheme, Settings, Support, TimeFunction, simulate
from corovec.benchmarks import load_case
from corovec.solver.dynamics import kept_matrix
from corovec.solver.dynamics.newton import StepRecord
from corovec.solver.dynamics.stepping import Stepper
from corovec.solver.kernels import transport
from corovec.solver.system.linear import Banded, Skyline
from corovec.solver.system.system import System
from corovec.verification.models import MATERIAL, rectangle, spinning

PULSE = TimeFunction((0.0, 0.2, 0.4), (0.0, 1.0, 0.0))


def hinged():
    """A strip with one end hinged, swung by a force: normals partly supported."""
    strip = rectangle(4.0, 1.0, (8, 2))
    hinge = np.flatnonzero(strip.nodes[:, 0] == 0.0)
    load = NodalLoad(len(strip.nodes) - 1, (0.0, 1.0, 4.0), PULSE)
    return Model(strip.nodes, strip.quads, loads=[load], **MATERIAL,
                 supports=[Support(tuple(hinge), ("x", "y", "z", "py"))])


@pytest.fixture
def factorizations(monkeypatch):
    """How many matrices are factorized, as a list of ones."""
    counted = []
    for solver in (Banded, Skyline):
        original = solver.factor
        monkeypatch.setattr(solver, "factor",
                            lambda self, original=original: counted.append(1) or original(self))
    return counted


@pytest.mark.parametrize("model, settings", [
    (lambda: load_case("l-plate").model(30), {"dt": 5e-3, "end_time": 1.5}),
    (lambda: load_case("l-plate").model(30), {"dt": 5e-3, "end_time": 1.5,
                                      "scheme": Scheme(axes="global")}),
    (lambda: load_case("l-plate").model(30), {"dt": 5e-3, "end_time": 1.5,
                                      "scheme": Scheme(rho_inf=0.5, transformation="average")}),
    (lambda: load_case("plates").model(432), {"dt": 5e-3, "end_time": 0.4}),
    (hinged, {"dt": 5e-3, "end_time": 1.0}),
], ids=["l-plate", "global axes", "average", "junctions", "hinged"])
def test_same_steps_from_fewer_factorizations(model, settings, factorizations):
    """Both iterations end far below the tolerance: what is left, relative 1e-6 of a step's residual
    and less, adds up to less than 1e-6 of the motion; the schemes differ by their error in dt,
    1e-3 and more."""
    results, counts = [], []
    for newton in ("full", "modified"):
        factorizations.clear()
        results.append(simulate(model(), Settings(**settings, newton=Newton(newton))))
        counts.append(len(factorizations))
    full, modified = results
    size = np.abs(full.displacement).max()
    assert np.abs(modified.displacement - full.displacement).max() < 1e-6 * size
    assert abs(modified.total_energy[-1] / full.total_energy[-1] - 1.0) < 1e-7
    assert modified.history["work_ratio"].max() < 1e-6
    assert counts[1] < 0.4 * counts[0]


def test_matrix_is_carried_around(factorizations, monkeypatch):
    """A plate that spins about a skew axis needs few matrices a turn (the stresses oscillate);
    without the rotation of the nodes it needs many times as many."""
    plate = spinning(rectangle(2.0, 1.0, (4, 2)), (1.0, 2.0, 2.0))
    settings = Settings(dt=0.01, end_time=6.0, frame_every=1000)
    monkeypatch.setattr(kept_matrix, "LEAST_PATIENCE", 11)
    simulate(plate, settings)
    carried = len(factorizations)

    def stay(*arguments):
        turning = arguments[-1]
        turning.Q[:] = turning.J[:] = np.eye(3)

    monkeypatch.setattr(kept_matrix, "Call",
                        lambda kernel: stay if kernel is transport.carry else kernel)
    factorizations.clear()
    simulate(plate, settings)
    assert carried < 120
    assert len(factorizations) > 5 * carried


def test_balance_conserves_linear_momentum(monkeypatch):
    """Without the translation that balances a correction, what a carried matrix leaves over shows
    in the linear momentum."""
    model, settings = load_case("l-plate").model(30), Settings(dt=5e-3, end_time=3.0)
    assert simulate(model, settings).drift.linear_momentum < 1e-13
    monkeypatch.setattr(kept_matrix, "Call", lambda kernel: (
        (lambda *arguments: None) if kernel is transport.balance else kernel))
    assert simulate(model, settings).drift.linear_momentum > 1e-12


def test_a_kept_matrix_knows_that_another_was_made():
    """Two steppers on one system: neither takes the other's factorization for its own."""
    system = System(load_case("l-plate").model(30))
    scheme = Scheme()
    one, other = (Stepper(system, scheme, Newton()) for _ in range(2))
    state = system.initial_state()
    place = system.observe(state)
    one.advance(state, place, 0.0, 0.01, StepRecord())
    assert one.iteration.kept.serves(scheme.midpoint(0.01))
    state = system.initial_state()
    other.advance(state, system.observe(state), 0.0, 0.02, StepRecord())
    assert other.iteration.kept.serves(scheme.midpoint(0.02))
    assert not one.iteration.kept.serves(scheme.midpoint(0.01))
