"""Several threads give what one gives, to the last bit."""

import numpy as np
import pytest

import corovec
from corovec import (
    Lamina,
    Laminate,
    Model,
    Ply,
    Scheme,
    Section,
    Settings,
    Support,
    block,
    simulate,
)
from corovec.solver.runtime.memory import peak_memory
from corovec.solver.system import threads
from corovec.solver.system.failure import NotConverged
from corovec.solver.system.linear import SparseLDL, make_solver, rslab
from corovec.solver.system.system import System
from corovec.verification.models import box, rectangle

METAL = Lamina.isotropic(youngs=1e6, poisson=0.3, density=1.0)


@pytest.fixture(autouse=True)
def small(monkeypatch):
    """Threads have work for small models."""
    monkeypatch.setattr(threads, "LEAST_NODES", 8)


def bent(**options):
    """A doubly curved shell."""
    flat = rectangle(3.0, 2.0, (14, 11))
    x, y, _ = flat.nodes.T
    return Model(np.stack([x, y, 0.1 * x**2 - 0.08 * x * y], axis=1), flat.quads, thickness=0.1,
                 youngs=1e6, poisson=0.25, density=1.0, **options)


def eccentric():
    """A plate whose mass and stretch are beside its nodes."""
    mesh = block([(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)], (13, 9))
    layer = Section(Laminate([Ply(METAL, 0.1)], offset=0.03), elements=range(len(mesh.quads)))
    return Model(mesh.nodes, mesh.quads, sections=[layer])


SHELLS = {
    "bent": bent,
    "held": lambda: rectangle(2.0, 1.0, (15, 10), supports=[Support((0, 1, 40), ("x", "y", "z"))]),
    "junctions": lambda: box((1.0, 1.0, 1.0), 5),
    "eccentric": eccentric}


@pytest.mark.parametrize("shell", SHELLS)
@pytest.mark.parametrize("solver", ["auto", "superlu"])
@pytest.mark.parametrize("averaged", [False, True])
def test_assembly(shell, solver, averaged, monkeypatch):
    """Residuals and matrices, of an iterate somewhere."""
    monkeypatch.setattr(threads, "MOST_TWICE", 9.0)
    if solver == "superlu":
        monkeypatch.setattr("corovec.solver.system.linear.DIRECT_LIMIT", 0.0)
        monkeypatch.setattr("corovec.solver.system.linear.rslab", lambda: None)
    model, step, found = SHELLS[shell](), Scheme(rho_inf=0.7).midpoint(0.01), []
    for count in (1, 2, 3, 7):
        system = System(model, threads=count)
        assert (system._team is not None) == (count > 1)
        state = system.start()
        delta = 1e-2 * np.sin(np.arange(system.numbering.n_dof))
        for tangent in (True, False):
            system.assemble(state, system.observe(state), step, delta, system.loads(0.0),
                            averaged=averaged, tangent=tangent)
        found.append([*system.residual, system.solver.values])
    for several in found[1:]:
        assert all(map(np.array_equal, several, found[0]))
    assert np.abs(found[0][0]).max() > 0.0 and np.count_nonzero(found[0][-1]) > 1000


def test_run():
    """A whole motion, whose history says the same."""
    model = bent(velocity=np.random.default_rng(2).normal(size=(180, 3)))
    runs = [simulate(model, Settings(dt=1e-3, end_time=1e-2), threads=n) for n in (1, 4)]
    assert np.array_equal(runs[0].history, runs[1].history)
    assert np.array_equal(runs[0].displacement, runs[1].displacement)


def test_a_node_that_is_lost_is_the_same(monkeypatch):
    """The first node that leaves its chart is named, whichever thread it belongs to."""
    model, said = bent(), []
    for count in (1, 3):
        system = System(model, threads=count)
        state, delta = system.start(), np.zeros(system.numbering.n_dof)
        for node in (170, 90):
            delta[system.numbering.start[node] + 3] = 3.0
        with pytest.raises(NotConverged) as lost:
            system.assemble(state, system.observe(state), Scheme().midpoint(0.01), delta,
                            system.loads(0.0))
        said.append(str(lost.value))
    assert "90" in said[0] and said[0] == said[1]


def test_elements_numbered_at_random_are_left_to_one_thread():
    """Every group of eight elements would be worked on by all threads."""
    plate = rectangle(2.0, 1.0, (80, 40))
    mixed = np.random.default_rng(0).permutation(len(plate.quads))
    for quads, several in ((plate.quads, True), (plate.quads[mixed], False)):
        model = Model(plate.nodes, quads, thickness=0.1, youngs=1.0, poisson=0.0, density=1.0)
        system = System(model, threads=2)
        assert (system._team is not None) == several


@pytest.mark.skipif(rslab() is None, reason="RSLAB is not installed")
def test_sparse_factorization(monkeypatch):
    """RSLAB's factors and solutions are the same too."""
    monkeypatch.setattr("corovec.solver.system.linear.SPARSE_LIMIT", 0.0)
    model, found = rectangle(1.0, 1.0, (40, 40)), []
    for count in (1, 2):
        system = System(model, threads=count)
        assert isinstance(system.solver, SparseLDL)
        state, n = system.start(), system.numbering.n_dof
        system.assemble(state, system.observe(state), Scheme().midpoint(0.01), np.zeros(n),
                        system.loads(0.0))
        system.factorize()
        found.append(system.solver.solve(np.sin(np.arange(n))))
    assert np.array_equal(*found)
    assert isinstance(make_solver("auto", system.numbering), SparseLDL)


def test_memory_is_told(tmp_path):
    """In megabytes, of a run and of its file; a process with NumPy takes some 50 at least."""
    result = simulate(rectangle(1.0, 1.0, (2, 2), velocity=np.eye(9, 3)),
                      Settings(dt=1e-2, end_time=2e-2), output=tmp_path / "run.h5")
    kept = corovec.read(tmp_path / "run.h5")["memory"]
    assert 50.0 < kept <= result.memory <= peak_memory() < 1e5


@pytest.mark.filterwarnings("ignore::corovec.AccuracyWarning")
def test_accelerations_at_the_start(monkeypatch):
    """Nothing is assembled or solved for them where no step depends on them."""
    solved = []
    monkeypatch.setattr("corovec.solver.system.system.solve_mass",
                        lambda solver, rhs: solved.append(0) or np.zeros_like(rhs))
    plate = rectangle(1.0, 1.0, (2, 2), loads=[corovec.NodalLoad(0, (0.0, 0.0, 1e-3))])
    for scheme, needed in ((Scheme(), False), (Scheme("exact"), False), (Scheme(rho_inf=0.9), True),
                           (Scheme("newmark"), True)):
        solved.clear()
        simulate(plate, Settings(dt=1e-2, end_time=1e-2, scheme=scheme))
        assert bool(solved) == needed == scheme.uses_accelerations
