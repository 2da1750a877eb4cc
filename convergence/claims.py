"""What the paper claims with its figures, of runs as they are recorded.

The curves themselves are lost, and so are those of other authors; what the text says of a figure
can be checked: that something stays constant, agrees between meshes, or swings equally far.  Which
of these a figure claims stands in ``printed.toml``.  The energy at which its curves run on is the
table's, and judged there.
"""

import datetime

import numpy as np

from corovec import InputError, read, total_energy
from corovec.benchmarks import load_case
from corovec.solver.dynamics.result import drift, unloaded_row
from corovec.solver.model.mesh import node_at
from corovec.solver.runtime.provenance import commit, machine, versions
from corovec.verification.case import Row, at_least, small

from .study import printed_results
from .verdicts import ROUNDING, rests_on

LINE = 1e-3
"""Change that a curve of a figure does not show: about a line's width over the figure's height."""

ANGULAR = 1e-6
"""Angular momentum, relative: second order in dt, far below what a figure shows."""

OSCILLATES = 1e-4
"""Angular momentum as printed, relative, must change at least so much to count as oscillating."""

MESHES = 0.05
"""Largest distance between a point's paths on two meshes, relative to the size of the shell."""


def claims(case, runs):
    """Rows of everything that the paper claims with the figures of a case.

    Args:
        case: its name.
        runs: ``{elements: contents}`` of ``read``, perhaps none.

    Returns:
        ``{figure: rows}``, without rows where they need runs and there are none.
    """
    claimed = (printed_results(case) or {}).get("claims", {})
    return {figure: [row for name in names for row in _CLAIMS[name](case, runs)]
            for figure, names in claimed.items()}


def open_runs(case, paths):
    """``{elements: contents}`` of the result files of finished runs of a case.

    Raises:
        ResultFileError: a file is missing or damaged.
        InputError: a file is of another case or not finished, or two are of one mesh.
    """
    runs = {}
    for path in paths:
        contents = read(path)
        description = contents["description"]
        if description["case"] != case or "time" not in contents["history"].dtype.names:
            raise InputError(f"{path} is no run of {case}")
        if contents["step"] != contents["n_steps"]:
            raise InputError(f"{path} is not finished")
        if description["elements"] in runs:
            raise InputError(f"{path} is a second run of {description['elements']} elements")
        runs[description["elements"]] = contents
    return runs


def as_json(case, runs, found):
    """What ``claims`` ``found``, with where it comes from, as one object of plain values."""
    return {"case": case, "date": datetime.datetime.now().isoformat(timespec="seconds"),
            "commit": commit(), "versions": versions(), "machine": machine(),
            "runs": [{name: contents["description"][name] for name in
                      ("elements", "settings", "versions", "machine")}
                     for _, contents in sorted(runs.items())],
            "figures": {figure: [row.as_dict() for row in rows]
                        for figure, rows in found.items()}}


def _finest(check):
    """The maker of the row of ``check(case, contents)`` for the finest of the runs, if any."""
    return lambda case, runs: check(case, runs[max(runs)]) if runs else ()


def _nodes(case, runs):
    """The numbers of nodes that the paper's text prints for meshes of a case."""
    definition, printed = load_case(case), printed_results(case)
    for elements, nodes in printed.get("nodes", {}).items():
        yield Row(f"{elements} elements: nodes", float(len(definition.mesh(int(elements)).nodes)),
                  float(nodes), "published", 0.0, "a count",
                  rests_on="selected" if printed.get("layout_by_nodes") else "")


def _energy(case, contents):
    _, when = _changes(contents)
    history = contents["history"]
    energy = total_energy(history)[unloaded_row(history, contents["description"]["unloaded_at"]):]
    yield small(f"energy drift, {when}", np.abs(energy / energy[0] - 1.0).max(), LINE,
                "a line's width in a figure")


def _linear(case, contents):
    changes, when = _changes(contents)
    yield small(f"linear momentum drift, {when}", changes.linear_momentum, ROUNDING, "rounding")


def _angular(case, contents):
    """The angular momentum of the consistent mass, and as printed."""
    changes, when = _changes(contents)
    yield small(f"angular momentum drift, {when}", changes.angular_momentum, ANGULAR,
                "of second order in dt")
    yield at_least(f"angular momentum as printed (one sum over nodes): change, {when}",
                   changes.angular_momentum_printed, OSCILLATES,
                   "it is not what the equations of motion conserve")


def _changes(contents):
    """Drifts since unloading, and in words from when to when."""
    description, history = contents["description"], contents["history"]
    when = (f"{description['elements']} elements, {description['unloaded_at']:g} to "
            f"{history['time'][-1]:g} s, dt = {description['settings']['dt']:g} s")
    return drift(history, description["unloaded_at"], description["supported"]), when


def _paths(case, runs):
    """The distance between the paths of each point of a case on the meshes and on the finest."""
    for point in load_case(case).points if runs else ():
        finest = max(runs)
        reference = _path(case, runs[finest], point)
        extent = np.linalg.norm(np.ptp(runs[finest]["nodes"], axis=0))
        for elements in sorted(runs)[:-1]:
            path = _path(case, runs[elements], point)
            apart = np.linalg.norm(path - reference, axis=1).max() / extent
            yield Row(f"{point}, {elements} elements: farthest from {finest} elements, relative to "
                      "the shell", apart, 0.0, "statement", MESHES, "what a figure shows as "
                      "agreement", scale=1.0, rests_on=rests_on(load_case(case)))


def _path(case, contents, point):
    """Displacements of a point of a case in all frames (n, 3) [m]."""
    node = node_at(contents["nodes"], load_case(case).points[point].value)
    return contents["displacement"][:, node]


_CLAIMS = {"nodes": _nodes, "energy": _finest(_energy),
           "linear momentum": _finest(_linear), "angular momentum": _finest(_angular),
           "paths": _paths}
