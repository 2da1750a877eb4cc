"""What the paper claims with its figures, of runs as they are recorded.

The curves themselves are lost, and so are those of other authors; what the text says of a figure
can be checked: that something stays constant, agrees between meshes, or swings equally far.
"""

import numpy as np

from corovec.benchmarks import load_case
from corovec.solver.dynamics.simulation import drift, total_energy, unloaded_row
from corovec.solver.model.mesh import node_at
from corovec.verification.case import Row, at_least, small

from .study import printed_results
from .verdicts import ASSUMED, ROUNDING, assumptions

LINE = 1e-3
"""Change that a curve of a figure does not show: about a line's width over the figure's height."""

ANGULAR = 1e-6
"""Angular momentum, relative: second order in dt, far below what a figure shows."""

OSCILLATES = 1e-4
"""Angular momentum as printed, relative, must change at least so much to count as oscillating."""

MESHES = 0.05
"""Largest distance between a point's paths on two meshes, relative to the size of the shell."""


def claims(case, runs):
    """``{figure: rows}`` of a case.

    Args:
        case: its name.
        runs: ``{elements: contents}`` of ``read``.
    """
    finest = runs[max(runs)]
    energy, linear, angular, printed = _conserved(finest)
    level = [*_level(case, finest)]
    energy = [*level, energy]
    if case == "l-plate":
        return {"Figure 3": [*energy, linear, angular, printed],
                "Figure 4": _paths(case, runs, "S"), "Figure 6": energy}
    if case == "ruler":
        return {"Figure 8": [*energy, linear, angular, printed], "Figure 9": energy}
    if case == "hemisphere":
        return {"Figure 11": energy, "Figure 13": energy}
    return {"Figure 15": energy, "Figure 16a": [*level, linear],
            "Figure 16b": [*level, angular, printed], "Figure 17": energy}


def mesh_claims(case):
    """Rows of the numbers of nodes that the paper's text prints for meshes of a case."""
    definition = load_case(case)
    for elements, nodes in printed_results(case).get("nodes", {}).items():
        yield Row(f"{elements} elements: nodes", float(len(definition.mesh(int(elements))[0])),
                  float(nodes), "published", 0.0, "a count")


def _level(case, contents):
    """The row of the energy at which curves run on, and with which motions go on, if printed."""
    printed, description = printed_results(case), contents["description"]
    elements = description["elements"]
    if elements in printed["elements"]:
        history = contents["history"]
        row = unloaded_row(history, description["unloaded_at"])
        yield Row(f"{elements} elements: energy after unloading, of this run [J]",
                  float(total_energy(history)[row]),
                  float(printed["energy"][printed["elements"].index(elements)]), "published", LINE,
                  "a line's width in a figure", explanation=assumptions(load_case(case)),
                  covers=ASSUMED, fitted=load_case(case).calibration is not None)


def _conserved(contents):
    """Rows of energy and momenta since unloading, and of the angular momentum as printed."""
    description, history = contents["description"], contents["history"]
    changes = drift(history, description["unloaded_at"], description["supported"])
    when = (f"{description['elements']} elements, {description['unloaded_at']:g} to "
            f"{history['time'][-1]:g} s, dt = {description['settings']['dt']:g} s")
    return (small(f"energy drift, {when}", changes.energy, LINE, "a line's width in a figure"),
            small(f"linear momentum drift, {when}", changes.linear_momentum, ROUNDING, "rounding"),
            small(f"angular momentum drift, {when}", changes.angular_momentum, ANGULAR,
                  "of second order in dt"),
            at_least(f"angular momentum as printed (one sum over nodes): change, {when}",
                     changes.angular_momentum_printed, OSCILLATES,
                     "it is not what the equations of motion conserve"))


def _paths(case, runs, point):
    """Rows of the distance between a point's paths on the meshes and on the finest."""
    finest = max(runs)
    reference = _path(case, runs[finest], point)
    extent = np.linalg.norm(np.ptp(runs[finest]["nodes"], axis=0))
    for elements in sorted(runs)[:-1]:
        path = _path(case, runs[elements], point)
        apart = np.linalg.norm(path - reference, axis=1).max() / extent
        yield Row(f"{point}, {elements} elements: farthest from {finest} elements, relative to the "
                  "shell", apart, 0.0, "converged", MESHES, "what a figure shows as agreement",
                  scale=1.0, explanation="energies that differ by the mesh make phases that differ "
                  "by ever more: half of the shell is where a comparison ends", covers=0.5)


def _path(case, contents, point):
    """Displacements of a point of a case in all frames (n, 3) [m]."""
    node = node_at(contents["nodes"], load_case(case).points[point].value)
    return contents["displacement"][:, node]
