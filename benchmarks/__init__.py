"""The paper's benchmarks: one model file each, with the provenance of every parameter.

Provenance is ``printed`` (the paper's text or tables), ``derived`` (follows from printed numbers),
``assumed`` (our reconstruction of a lost figure), ``selected`` (chosen among candidates by a
printed result) or ``calibrated`` (fitted to a printed energy).
"""

from functools import cache
from pathlib import Path

from corovec.solver.checks import choice

FOLDER = Path(__file__).parent


def case_names():
    """Names of the benchmarks."""
    return tuple(sorted(path.stem for path in FOLDER.glob("*.toml")))


def load_case(name):
    """The ``ModelFile`` of the benchmark ``name``.

    Raises:
        InputError: unknown name, or a file with errors (all of them, each with its path in the
            file).
    """
    return read_case(choice("case", name, case_names()))


@cache
def read_case(name):
    """The same, of a name that is known."""
    from corovec.solver.input.files import read_model
    return read_model(FOLDER / f"{name}.toml")
