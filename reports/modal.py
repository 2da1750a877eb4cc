"""Modes and buckling shapes: figures, films, and what the commands print and write of them."""

from pathlib import Path

import click
import numpy as np
import pandas as pd

from corovec.solver.checks import number
from corovec.solver.cli import show
from corovec.solver.errors import InputError
from corovec.solver.model.mesh import vector_areas
from corovec.solver.modes.result import shapes_path
from corovec.solver.modes.vibration import Modes
from corovec.solver.names import printable
from corovec.solver.results.files import writable_path
from corovec.solver.results.layout import DYNAMICS

from .colours import ENERGY, Coloured
from .film import animate, film_path
from .recording import Recording
from .scenes import side_by_side
from .space import View, best_view
from .style import FORMATS, save, styled
from .symbols import symbols_of

LARGEST = 0.1
"""Largest displacement that is drawn, relative to the size of the mesh."""

ROUNDING = 1e-12
"""Part of the largest number of a table that is printed as zero."""

PERIOD = 24
"""Frames of a period of a film."""


@styled
def shapes(found, scale=1.0, view=None):
    """All shapes side by side, each with a largest displacement of 0.1 of the shell times
    ``scale``, coloured by the energy of its strains.

    Args:
        found: ``Modes`` or ``Buckling``.
        scale: of the displacements.
        view: (elevation, azimuth) [degrees]; default: where most is seen.

    Returns:
        (Figure, DataFrame): columns shape, node, x, y, z, and the displacement u, v, w drawn.
    """
    moved = number("scale", scale) * _drawn(found).real
    positions = found.model.nodes + found.base + moved
    corners, symbols = positions[:, found.model.quads], symbols_of(found.model)
    view = best_view(corners.reshape(-1, 4, 3)) if view is None else View(*view)
    captions = [name.partition(": ")[2] for name in found.names()]
    colours = Coloured(ENERGY, _density(found), "strain energy density, largest of each shape = 1")
    joined = symbols, symbols.places(positions, _normals(found.model, len(positions)))
    figure = side_by_side(corners, colours, captions, view, joined=joined)
    n, n_nodes = moved.shape[:2]
    places = np.tile((found.model.nodes + found.base).T, n)
    return figure, pd.DataFrame({
        "shape": np.repeat(np.arange(1, n + 1), n_nodes), "node": np.tile(np.arange(n_nodes), n),
        **dict(zip("xyz", places)), **dict(zip("uvw", moved.reshape(-1, 3).T))})


def oscillation(found, k, scale=1.0):
    """One period of shape ``k`` (from 0) as a ``Recording``, for ``film.animate``: elements have
    the energy of their strains, the history ``1/2 omega^2 a^2`` of the amplitude, which the stress
    of a state adds to.  A buckling shape has no period; its film takes 1 s.

    Raises:
        InputError: there is no such shape, or it does not oscillate.
    """
    if not 0 <= k < len(found):
        raise InputError(f"shape {k + 1} is not among {len(found)} shapes")
    vibrates = isinstance(found, Modes)
    frequency = float(found.frequencies[k]) if vibrates else 1.0
    if frequency <= 0.0:
        raise InputError(f"{found.names()[k]} does not oscillate")
    phase, shape = 2.0 * np.pi * np.arange(PERIOD) / PERIOD, scale * _drawn(found)[k]
    swing = np.real(np.exp(1j * phase)[:, None, None] * shape)
    size = np.linalg.norm(shape) / np.linalg.norm(found.displacement[k])
    energy = size**2 * found.strain_energy[k]
    history = np.zeros(len(phase), dtype=DYNAMICS)
    history["time"] = phase / (2.0 * np.pi * frequency)
    total = 0.5 * size**2 * found.eigenvalues[k] if vibrates else energy.sum()
    history["strain_energy"] = total * np.cos(phase) ** 2
    history["kinetic_energy"] = vibrates * total * np.sin(phase) ** 2
    return Recording(found.names()[k], {
        "nodes": found.model.nodes, "quads": found.model.quads, "history": history,
        "displacement": found.base + swing, "frame_steps": np.arange(len(phase)),
        "description": found.model.mechanism, "director": _normals(found.model, len(phase)),
        "strain_energy": np.outer(np.cos(phase) ** 2, energy)})


def tell(found, summary, output, picture, film, overwrite, shape, scale, view, as_json):
    """Write what is asked for of ``found``, and print its summary."""
    written = {}
    if output is not None:
        found.write(output, overwrite)
        written["output"] = str(output)
    if picture is not None:
        picture = Path(picture)
        path, _ = save(*shapes(found, scale, view), picture.parent, picture.stem,
                       (picture.suffix[1:],), overwrite)
        written["picture"] = str(path)
    if film is not None:
        written["film"] = str(animate(oscillation(found, shape - 1, scale), film, view=view,
                                      overwrite=overwrite))
    table = found.frame()
    summary = {**summary, **{name: printable(path) for name, path in written.items()}}
    if as_json:
        return show(summary, True)
    show({key: value for key, value in summary.items() if not isinstance(value, dict)}, False)
    table.index += 1
    table = table.mask(table.abs() < ROUNDING * table.abs().to_numpy().max(), 0.0)
    click.echo(table.to_string(float_format=lambda value: f"{value:.5g}"))


def check_paths(output, picture, film, overwrite):
    """Refuse files that cannot be written before anything is computed."""
    if output is not None:
        shapes_path(output, overwrite)
    if film is not None:
        film_path(film, overwrite)
    if picture is not None:
        writable_path(picture, overwrite)
    if picture is not None and Path(picture).suffix[1:] not in FORMATS:
        raise InputError(f"plot {picture}: must end in one of: "
                         f"{', '.join(f'.{name}' for name in FORMATS)}")


def _drawn(found):
    """Displacements (n, n_nodes, 3), each with a largest one of ``LARGEST`` of the shell."""
    sizes = np.linalg.norm(found.displacement, axis=2).max(axis=1)[:, None, None]
    return LARGEST * found.model.size / sizes * found.displacement


def _normals(model, n):
    """(n, n_directors, 3) initial normals: joints of a model that has modes lie at its nodes."""
    return np.broadcast_to(model.normals, (n, *model.normals.shape))


def _density(found):
    """(n, n_elem) strain energy of each element over its area, by the largest of each shape."""
    density = found.strain_energy / np.linalg.norm(
        vector_areas(found.model.nodes[found.model.quads]), axis=1)
    return density / density.max(axis=1, keepdims=True)
