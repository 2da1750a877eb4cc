"""One table of junk against every argument of every public function: always one short line."""

import inspect
import warnings

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

import corovec
from corovec import (
    InputError,
    convergence,
)
from corovec.reports import figures
from corovec.reports.recording import Recording
from corovec.verification.fuzz import api
from corovec.verification.fuzz.junk import Unshowable


class Nothings:
    """Items that are nothing."""

    def __iter__(self):
        return iter([object()])


JUNK = {
    "object": object(), "unshowable": Unshowable(), "ragged": [[1.0], [1.0, 2.0]],
    "record": np.zeros(3, dtype=[("a", "f8"), ("b", "i4")]), "digits": 10**5000,
    "interval": np.timedelta64(1), "date": np.datetime64("2020-01-01"),
    "flags": np.array([True, False, True]), "mask": np.ma.masked, "nan": float("nan"),
    "complex": 1j, "bytes": b"\xff\x00", "dict": {"a": 1}, "set": {1, 2}, "type": int,
    "objects": np.array([None, 1, "a"], dtype=object), "empty": np.zeros((0, 3)),
    "infinite": [np.inf, 0.0, 0.0], "nested": [[[1.0, 2.0]]], "texts": ["a\n$x" * 500] * 3,
    "function": lambda *_: True, "iterable": Nothings(), "none": None, "text": "a\n$x{" * 1000,
    "flag": True, "float": 0.1, "negative": -7,
}


def good(folder):
    """``{function: its good arguments}`` of all public ones; a dict of keywords each."""
    table = api.table(folder)
    recording = Recording.open(folder / "run.h5")
    seen = {"history": table[corovec.drift]["history"], "unloaded_at": 0.0}
    followed = corovec.simulate(api.PLATE, api.RUN, probes={"tip": 0}).history
    return {
        **table,
        figures.energies: {**seen, "end": None},
        figures.momenta: {**seen, "end": None},
        figures.energies_by_item: {"run": table[corovec.energy_table]["run"], "unloaded_at": 0.0},
        figures.probes: {**seen, "history": followed, "end": None},
        figures.total_energies: {"recordings": [recording]},
        figures.displacements: {"recordings": [recording], "points": {"a": (0.0, 0.0, 0.0)},
                                "components": None},
        figures.convergence: {"curves": [figures.Curve("a", (1, 4), (0.1, 0.02), -2.0)]},
        figures.mesh_and_loads: {"model": api.PLATE, "case": None, "view": None},
        figures.sequence: {"recording": recording, "times": None, "scale": 1.0, "view": None,
                            "color": "strain_energy_density"},
        figures.save: {"figure": Figure(), "data": pd.DataFrame({"a": [1]}), "folder": folder,
                       "name": "figure", "formats": ("svg",), "overwrite": True},
        convergence.dask_workers: {"address": "tcp://none"},
        convergence.Campaign: {"folder": folder, "workers": convergence.processes(1),
                               "notify": warnings.warn},
        convergence.Run: {"model": api.PLATE, "settings": api.RUN, "case": None,
                          "most_halvings": None},
        convergence.processes: {"jobs": 1},
        convergence.run_many: {"items": [], "executor": None, "jobs": 1, "probes": None,
                               "start": None},
    }


OUTCOMES = {"Drift", "Outcome", "Result", "StaticResult", "LinearResult", "LayerStresses", "Cut",
            "ModelRun", "Stresses",
            "Configuration", "AccuracyWarning", "InputError", "MeshWarning", "ResultFileError",
            "ResultFileWarning", "StabilityWarning", "StepError", "Curve", "Modes", "Buckling",
            "warm_up"}
"""What is handed out and not made by users, is checked where it is used, or takes nothing."""

FITS = {
    *((name, "empty") for name in ("loads", "supports", "sections", "attached", "items",
                                   "joints", "bodies")),
    ("progress", "function"), ("until", "function"), ("function", "function"),
    ("notify", "function"),
    *((flag, "flag") for flag in ("overwrite", "supported", "stresses", "merge", "reduce",
                                  "all_quads", "apart", "rising", "switch")), ("probes", "dict"),
    ("merge", "float"), ("default", "float"), ("default", "negative"), ("angle", "float"),
    ("angle", "negative"),
    *((name, kind) for kind in ("float", "negative")
      for name in ("pressure", "displacement", "offset", "temperature", "gradient", "alpha",
                   "alpha1", "alpha2", "unloaded_at", "scale", "load_factor", "amplitude",
                   "phase", "mean", "factor", "rest", "lock", "torque")),
    *((name, "float") for name in (
        "thickness", "youngs", "poisson", "density", "fold_angle", "tolerance", "rho_inf", "error",
        "dt", "end_time", "length", "radius", "end", "frequency", "mass", "inertia", "stiffness",
        "turning", "damping", "stop_stiffness", "lock_stiffness", "lock_damping", "coefficient",
        "E1", "E2", "nu12", "G12", "G13", "G23",
        *("Xt", "Xc", "Yt", "Yc", "S"))),
    *((name, "negative") for name in ("node", "one", "other", "at")),  # only a mesh knows them
}
"""Parameters to which something of the table is no junk."""

OWN = {*((corovec.FollowerForce, "force", kind) for kind in ("float", "negative")),
       (corovec.RigidBody, "nodes", "empty"), (corovec.energy_table, "row", "negative")}
"""The same of one function, whose namesakes elsewhere are vectors, or not empty."""


def public():
    """Names of all public functions and classes."""
    return {getattr(module, name) for module in (corovec, figures, convergence)
            for name in set(module.__all__) - OUTCOMES}


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    return good(tmp_path_factory.mktemp("junk"))


def test_the_table_has_everything(table):
    """All public functions and all of their parameters; they take the good arguments."""
    assert public() <= set(table)
    for function, arguments in table.items():
        parameters = inspect.signature(function).parameters.values()
        assert set(arguments) == {p.name for p in parameters if p.kind is not p.VAR_KEYWORD}
        function(**arguments)


@pytest.mark.parametrize("kind", JUNK)
def test_junk_is_one_line(table, kind):
    """An ``InputError`` for whatever is no argument."""
    for function, arguments in table.items():
        for name in arguments:
            if fits(function, name, kind):
                continue
            said = told(function, {**arguments, name: JUNK[kind]})
            assert isinstance(said, InputError), (function.__name__, name, said)
            assert len(str(said)) < 300 and str(said).isprintable(), (function.__name__, name)


def told(function, arguments):
    """The error that a call ends with, or what it returns."""
    try:
        return function(**arguments)
    except Exception as error:
        return error


def fits(function, name, kind):
    """Whether something of the table is no junk to a parameter."""
    if kind == "none":
        return inspect.signature(function).parameters[name].default is None
    return (name, kind) in FITS or (function, name, kind) in OWN
