"""What a result file holds, ready to be drawn."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from corovec.solver.errors import InputError, ResultFileError
from corovec.solver.model.mesh import node_at, vector_areas
from corovec.solver.names import printable
from corovec.solver.results.reading import read

from .symbols import symbols_of


@dataclass(frozen=True, eq=False)
class Recording:
    """A run or a static path, finished or not.

    Attributes:
        name: what its figures are called.
        contents: of its file, see ``read``.
    """

    name: str
    contents: dict

    @classmethod
    def open(cls, path):
        """The recording in the file ``path``, named by its stem.

        Raises:
            ResultFileError: no such file, not a corovec file, damaged, or only the start of a run.
        """
        contents = read(path)
        if len(contents["displacement"]) < 2:
            raise ResultFileError(f"{path} holds the start of a run and no frame after it: nothing "
                                  "to draw")
        return cls(printable(Path(path).stem), contents)

    @property
    def mechanism(self):
        """Its joints and rigid bodies, see ``model.mechanism``."""
        return {kind: self.contents["description"].get(kind, []) for kind in ("joints", "bodies")}

    @cached_property
    def symbols(self):
        """``Symbols`` of them."""
        return symbols_of(self)

    def symbol_places(self, frames, scale=1.0):
        """(n_frames, n_points, 3) places of the points of ``symbols`` in some frames, with the
        displacements times ``scale`` [m]."""
        return self.symbols.places(self.positions(scale)[frames], self.contents["director"][frames])

    @property
    def case(self):
        """Name of the benchmark, or None."""
        return self.contents["description"]["case"]

    @property
    def elements(self):
        """Number of elements of its mesh."""
        return len(self.quads)

    @property
    def nodes(self):
        """(n_nodes, 3) initial coordinates [m]."""
        return self.contents["nodes"]

    @property
    def quads(self):
        """(n_elem, 4) node numbers."""
        return self.contents["quads"]

    @property
    def history(self):
        """Structured array of rows, see ``DYNAMICS`` and ``STATICS`` of ``results.layout``."""
        return self.contents["history"]

    @property
    def displacement(self):
        """(n_frames, n_nodes, 3) [m]."""
        return self.contents["displacement"]

    @property
    def unloaded_at(self):
        """Time from which no load acts [s]; infinity in statics."""
        return np.inf if self.static else self.contents["description"]["unloaded_at"]

    @property
    def static(self):
        """Whether it is a path of equilibria over the load factor instead of a motion."""
        return "factor" in self.history.dtype.names

    @cached_property
    def frame_rows(self):
        """(n_frames,) the row of the history that belongs to each frame."""
        return self.contents["frame_steps"]

    @cached_property
    def times(self):
        """(n_frames,) time [s], in statics the load factor, of the frames."""
        return self.history["factor" if self.static else "time"][self.frame_rows]

    @cached_property
    def areas(self):
        """(n_elem,) initial areas of the elements [m^2]."""
        return np.linalg.norm(vector_areas(self.nodes[self.quads]), axis=1)

    @cached_property
    def energy_density(self):
        """(n_frames, n_elem) strain energy of each element over its initial area [J/m^2]."""
        return self.contents["strain_energy"] / self.areas

    def positions(self, scale=1.0):
        """(n_frames, n_nodes, 3) with the displacements times ``scale`` [m]."""
        return self.nodes + scale * self.displacement

    def at(self, point):
        """(n_frames, 3) displacements of the node at ``point`` [m].

        Raises:
            InputError: no node there.
        """
        try:
            return self.displacement[:, node_at(self.nodes, point)]
        except InputError as error:
            raise InputError(f"{self.name} ({self.elements} elements): {error}") from None

    def frames_at(self, times):
        """Numbers of the frames nearest to ``times``, each once.

        Raises:
            InputError: a time outside the recorded ones.
        """
        what, unit = ("load factor", "") if self.static else ("time", " s")
        first, last = self.times.min(), self.times.max()
        margin = 1e-9 * (last - first)
        for time in times:
            if not first - margin <= time <= last + margin:
                raise InputError(f"{what} {time:g}{unit} is not in {self.name}, which is recorded "
                                 f"from {first:g} to {last:g}{unit}")
        return list(dict.fromkeys(int(np.argmin(np.abs(self.times - time))) for time in times))
