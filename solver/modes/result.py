"""What vibrations and buckling have in common: shapes of a shell about a state; their files."""

from dataclasses import dataclass

import meshio
import numpy as np

from ..errors import InputError
from ..kernels import updates
from ..model.constants import apart
from ..model.model import Model
from ..results.files import replacing, writable_path


@dataclass(frozen=True, eq=False, repr=False)
class Shapes:
    """Displacements and changes of normals about a state.

    Attributes:
        model: ``Model``.
        base: (n_nodes, 3) displacements of the state itself [m].
        displacement: (n, n_nodes, 3) of each shape.
        directors: (n, n_directors, 3) changes of all normals.
        strain_energy: (n, n_elem) energy of the strains that are linear in the shape.
    """

    model: Model
    base: np.ndarray
    displacement: np.ndarray
    directors: np.ndarray
    strain_energy: np.ndarray

    def __len__(self):
        return len(self.displacement)

    def names(self):
        """What each shape is called, its number and its value."""
        raise NotImplementedError

    def write(self, path, overwrite=False):
        """Write the shapes for ParaView, each as displacements of the nodes, about the state.

        Args:
            path: a .vtu file.
            overwrite: replace it if it exists.

        Raises:
            InputError: another ending.
            ResultFileError: it exists, or cannot be written.
        """
        path = shapes_path(path, overwrite)
        fields = {name: np.ascontiguousarray(shape.real)
                  for name, shape in zip(self.names(), self.displacement)}
        mesh = meshio.Mesh(self.model.nodes + self.base, [("quad", self.model.quads)],
                           point_data=fields)
        with replacing(path) as partial:
            mesh.write(partial, file_format="vtu")


def shapes_path(path, overwrite=False):
    """``path`` as that of a file of shapes, see ``Shapes.write``."""
    path = writable_path(path, overwrite)
    if path.suffix != ".vtu":
        raise InputError(f"{path}: must end in .vtu")
    return path


def shape_fields(system, state, place, vectors):
    """``displacement``, ``directors`` and ``strain_energy`` of ``Shapes``, of vectors (n_dof, n).

    ``W = 1/2 (de . de + db^T k_b db)`` with the linear part of the measures, de and db.
    """
    if np.iscomplexobj(vectors):
        (u, p, W), (v, q, T) = (shape_fields(system, state, place, np.ascontiguousarray(part))
                                for part in (vectors.real, vectors.imag))
        return u + 1j * v, p + 1j * q, W + T
    start, coordinates, elements = place.start, system.coordinates, system.elements
    displacement = np.moveaxis(vectors[system.translations], -1, 0)
    vectors = np.ascontiguousarray(vectors.T)
    directors = np.array([coordinates.change_of_directors(start, vector) for vector in vectors])
    still = start._replace(b=np.zeros_like(start.b), e=np.zeros_like(start.e))
    n_elem, energies, strains = len(elements.nodes), [], system.predictions()
    k_b = apart(elements.k_b, n_elem)
    for vector in vectors:
        updates.predict_strains(elements, system.dofs.nodes, state.motion, still, vector, strains)
        energies.append(0.5 * (np.sum(strains.e**2, axis=1)
                               + np.einsum("ei,eij,ej->e", strains.b, k_b, strains.b)))
    return displacement, directors, np.array(energies)
