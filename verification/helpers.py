"""What several tests use: systems with a chosen solver, their matrices, and the command line."""

import io
import subprocess
import sys
import warnings
from contextlib import redirect_stderr, redirect_stdout
from itertools import product
from pathlib import Path
from warnings import catch_warnings, simplefilter

import h5py
import numpy as np

from corovec import ResultFileWarning, read
from corovec.solver.cli import main
from corovec.solver.kernels.arguments import STATIC
from corovec.solver.system.linear import SparseLDL, SuperLU
from corovec.solver.system.system import System

COMMAND = Path(sys.executable).with_name("corovec")

THIN = "rounding errors, amplified by the ratio of membrane to bending stiffness (L/h)^2 = 6e4"
"""Why the patch tests, 0.24 long and 0.001 thick, are not exact to the last digit."""

SOLVERS = ("skyline", "dense", "auto", "superlu", "rslab")


def make_system(model, solver="skyline"):
    """``System`` with the given solver."""
    own = {"superlu": SuperLU, "rslab": SparseLDL}.get(solver)
    system = System(model, "auto" if own else solver)
    if own:
        system.solver = own(system.numbering)
    return system


def full_matrix(system):
    """The lower triangle in the solver's storage as a full symmetric matrix (n_dof, n_dof).

    Every solver has an entry at ``base[row] + offset[e, a, b] + stride * k``, see
    ``arguments.Storage``.
    """
    solver, numbering = system.solver, system.numbering
    base, offset, _, stride = solver.storage
    lower = np.zeros((numbering.n_dof, numbering.n_dof))
    dofs = [start + np.arange(3 + n) for start, n in zip(numbering.start, numbering.n_rot)]
    for e, quad in enumerate(numbering.cells[0]):
        for a, b in product(range(4), repeat=2):
            rows, columns = dofs[quad[a]], dofs[quad[b]]
            if columns[0] <= rows[0]:
                places = base[rows][:, None] + offset[e, a, b] + stride * np.arange(len(columns))
                lower[np.ix_(rows, columns)] = solver.values.take(places, mode="clip")
    lower = np.tril(lower)
    return lower + np.tril(lower, -1).T


def stiffness(system, state, factors=STATIC):
    """The static tangent (n_dof, n_dof) at a state, or with other step ``factors``; no loads."""
    assemble(system, state, factors, np.zeros(system.numbering.n_dof))
    return full_matrix(system)


def free_part(K, values, free):
    """``values`` (n_dof,) with those that are ``free`` in equilibrium with the others."""
    found = values.copy()
    found[free] = np.linalg.solve(K[np.ix_(free, free)], -K[np.ix_(free, ~free)] @ values[~free])
    return found


def assemble(system, state, factors, delta, time=None, tangent=True):
    """Residual (n_dof,) of an iterate of a step from ``state``; the system has the tangent.

    Args:
        factors: ``arguments.Factors`` of the step.
        delta: (n_dof,) increment.
        time: of the loads [s]; None for none.
        tangent: whether the matrix is wanted.
    """
    none = system.loads_by(lambda history: 0.0)
    system.assemble(state, system.observe(state), factors, delta,
                    none if time is None else system.loads(time), tangent=tangent)
    return system.residual.balance.copy()


def static_system(system, state, delta, tangent=True):
    """Residual (n_dof,) of f(x + delta) without loads or inertia; the system has the tangent."""
    return assemble(system, state, STATIC, delta, tangent=tangent)


def central_differences(function, at, step):
    """Derivative of a vector function at ``at`` by central differences, a column a variable."""
    return np.column_stack([(function(at + shift) - function(at - shift)) / (2.0 * step)
                            for shift in step * np.eye(len(at))])


def relative(ours, reference):
    """Largest difference of two arrays over the largest entry of the reference."""
    return np.abs(ours - reference).max() / np.abs(reference).max()


def read_killed(path):
    """``read`` of the file of a killed run: a kill between a frame and its checkpoint leaves the
    checkpoint before, with a warning."""
    with catch_warnings():
        simplefilter("ignore", ResultFileWarning)
        return read(path)


def corovec(*arguments, **options):
    """Run the installed command; text of both streams and the exit status."""
    return subprocess.run([COMMAND, *arguments], text=True, capture_output=True, check=False,
                          **options)


def in_process(*arguments):
    """The same without a process of its own: for what ends before anything is computed."""
    streams, argv, shown = (io.StringIO(), io.StringIO()), sys.argv, warnings.formatwarning
    sys.argv = ["corovec", *arguments]
    try:
        with redirect_stdout(streams[0]), redirect_stderr(streams[1]):
            main()
        status = 0
    except SystemExit as ended:
        status = ended.code or 0
    finally:
        sys.argv, warnings.formatwarning = argv, shown
    return subprocess.CompletedProcess(arguments, status, *(s.getvalue() for s in streams))


def vtk_frames(path, times):
    """What VTK's own reader (ParaView's) shows at ``times``: (time, points, {name: values})."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonDataModel import vtkDataObject
    from vtkmodules.vtkIOHDF import vtkHDFReader
    with h5py.File(path) as file:
        steps = file["VTKHDF/Steps"]
        assert len(steps["Values"]) == steps.attrs["NSteps"], "VTK would overrun its memory"
    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    assert reader.GetNumberOfSteps() == len(read(path)["displacement"])
    for time_ in times:
        reader.UpdateTimeStep(time_)
        grid = reader.GetOutputDataObject(0)
        assert grid.GetNumberOfCells() == len(read(path)["quads"])
        arrays = {data.GetArrayName(k): vtk_to_numpy(data.GetArray(k))
                  for data in (grid.GetPointData(), grid.GetCellData())
                  for k in range(data.GetNumberOfArrays())}
        yield (grid.GetInformation().Get(vtkDataObject.DATA_TIME_STEP()),
               vtk_to_numpy(grid.GetPoints().GetData()), arrays)
