"""The hash of a run: changed by each parameter, and by nothing else."""

import os
import subprocess
import sys
from dataclasses import fields, replace

import numpy as np
import pytest

from corovec import (
    Cyclic,
    Damping,
    InputError,
    Lamina,
    Laminate,
    Model,
    Newton,
    NodalLoad,
    Ply,
    PointMass,
    RigidBody,
    RigidLink,
    Scheme,
    Section,
    Settings,
    Support,
    TimeFunction,
)
from corovec.benchmarks import load_case
from corovec.convergence import Run, run

SETTINGS = {
    Settings: {"dt": 0.005, "end_time": 0.2, "scheme": Scheme("newmark"),
               "newton": Newton("full"), "solver": "skyline", "frame_every": 3,
               "stresses": True, "error": 1e-3},
    Scheme: {"name": "newmark", "rho_inf": 0.9, "transformation": "average", "axes": "global",
             "dissipation": 0.2, "dissipates": "constant", "order": 4},
    Newton: {"kind": "full", "tolerance": 1e-8, "min_iterations": 2, "max_iterations": 30}}

MODEL = {"nodes": [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1.5, 0)], "quads": [(1, 2, 3, 0)],
         "thickness": 0.2, "youngs": 2.0, "poisson": 0.2, "density": 2.0,
         "loads": [NodalLoad(0, (0, 0, 2), TimeFunction((0, 1), (1, 0)))],
         "supports": [Support((0,), ("x",))], "normals": [(0.6, 0.0, 0.8)] * 4,
         "velocity": np.ones((4, 3)), "normal_velocity": [(1, 0, 0)] * 4, "membrane": "strain",
         "shear": "compatible", "attached": [PointMass(0, 1.0)], "damping": Damping(mass=1.0),
         "joints": [RigidLink(0, 2)],
         "sections": [Section(Laminate([Ply(Lamina.isotropic(1.0, 0.3, 1.0), 0.1)]))]}


def plate(**changes):
    values = {"nodes": [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], "quads": [(0, 1, 2, 3)],
              "thickness": 0.1, "youngs": 1.0, "poisson": 0.3, "density": 1.0,
              "loads": [NodalLoad(0, (0, 0, 1), TimeFunction((0, 1), (1, 0)))]}
    return Model(**{**values, **changes})


def key(settings=None, case=None, **changes):
    return Run(plate(**changes), settings or Settings(dt=0.01, end_time=0.1), case).key


@pytest.mark.parametrize("owner, name", [(owner, field.name) for owner in SETTINGS
                                         for field in fields(owner)])
def test_every_setting_changes_the_hash(owner, name):
    scheme = Scheme("exact", dissipation=0.1) if name.startswith("dissipat") else Scheme()
    settings = Settings(dt=0.01, end_time=0.1, scheme=scheme)
    change = {name: SETTINGS[owner][name]}
    if owner is not Settings:
        part = owner.__name__.lower()
        change = {part: replace(getattr(settings, part), **change)}
    assert key(replace(settings, **change)) != key(settings)


@pytest.mark.parametrize("name", [field.name for field in fields(Model) if field.name not in
                                  ("fold_angle", "patches", "directors", "pairs", "cyclic",
                                                 "bodies")])
def test_every_part_of_the_model_changes_the_hash(name):
    assert key(**{name: MODEL[name]}) != key()


def test_a_sector_has_another_hash():
    sector = {"nodes": [(1, 0, 0), (2, 0, 0), (0, 2, 0), (0, 1, 0)]}
    assert key(**sector, cyclic=Cyclic(4)) != key(**sector)


def test_a_body_changes_the_hash():
    nodes = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1)]
    assert len({key(nodes=nodes, bodies=[RigidBody("a", mass, (1, 1, 1), (0, 0, 1))])
                for mass in (1.0, 2.0)}) == 2


def test_where_plates_meet_changes_the_hash():
    corner = {"nodes": [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (-0.8, 0, 0.6), (-0.8, 1, 0.6)],
              "quads": [(0, 1, 2, 3), (0, 3, 5, 4)]}
    assert len({key(**corner), key(**corner, fold_angle=30.0)}) == 2
    assert key(**corner, fold_angle=30.0) == key(**corner, patches=(1, 2))


def test_load_history_and_case_change_the_hash():
    later = [NodalLoad(0, (0, 0, 1), TimeFunction((0, 2), (1, 0)))]
    assert len({key(), key(loads=later), key(case="l-plate"), key(case="ruler")}) == 4


def test_code_changes_the_hash(monkeypatch):
    before = key()
    monkeypatch.setattr(run, "code_version", lambda: "0.1.0+edited")
    assert key() != before


def test_code_version_sees_every_source(monkeypatch, tmp_path):
    """An edit, a new file and a new name of a file are new versions; other files are not."""
    package = tmp_path / "solver" / "kernels"
    package.mkdir(parents=True)
    main, kernel = package.parent / "__init__.py", package / "element.py"
    main.write_text("")
    kernel.write_text("x = 1\n")
    monkeypatch.setattr(run.solver, "__file__", str(main))
    version = run.code_version.__wrapped__
    seen = [version()]
    kernel.write_text("x = 2\n")
    seen.append(version())
    kernel.rename(package / "elements.py")
    seen.append(version())
    (package / "new.py").write_text("")
    seen.append(version())
    assert len(set(seen)) == 4
    (package / "data.toml").write_text("not code")
    assert version() == seen[-1]
    assert version(endings=(".py", ".toml")) != seen[-1]


def test_equal_runs_have_equal_hashes_in_every_process():
    """Neither the object, nor the way numbers are given, nor the process matters."""
    settings = Settings(dt=0.01, end_time=0.1)
    assert key() == key(settings, thickness=[0.1], velocity=np.zeros((4, 3)), supports=())
    mesh = load_case("l-plate").model(30)
    script = ("from corovec import Settings; from corovec.benchmarks import load_case;"
              "from corovec.convergence import Run;"
              "print(Run(load_case('l-plate').model(30), Settings(dt=0.01, end_time=0.1)).key)")
    other = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True,
                           check=True, env={**os.environ, "PYTHONPATH": ":".join(sys.path)})
    assert other.stdout.strip() == Run(mesh, settings).key


def test_as_run():
    settings = Settings(dt=0.01, end_time=0.1)
    named = run.as_run("item", ("l-plate", settings))
    assert named.case == "l-plate" and named.elements == 120
    assert run.as_run("item", named) is named
    assert run.as_run("item", (named.model, settings)).case is None


@pytest.mark.parametrize("item, message", [
    ("l-plate", "must be a Run or a pair"),
    (7, "must be a Run or a pair"),
    (("plate", Settings(dt=0.1, end_time=1.0)), "case 'plate' is unknown"),
    (("l-plate", 0.1), "a pair of Model and float"),
    ((None, Settings(dt=0.1, end_time=1.0)), "a pair of NoneType and Settings"),
])
def test_as_run_refuses_what_is_no_run(item, message):
    with pytest.raises(InputError, match=message):
        run.as_run("item", item)
