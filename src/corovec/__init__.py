"""Co-rotational four-node shell dynamics with vectorial rotational variables.

A ``Model`` is made of arrays, ``simulate`` runs it with ``Settings`` and returns a
``Result``; ``read`` opens a result file.  ``corovec.benchmarks`` holds the paper's
benchmarks; ``corovec.verification``, ``convergence``, ``timing`` and ``reports`` are the suites.

Names are loaded when they are first asked for, so that the command line can deal with interrupts
before its libraries are there.
"""

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .solver.compilation import warm_up
    from .solver.dynamics.energies import energy_table
    from .solver.dynamics.probes import EnergyProbe, JointProbe, StressProbe
    from .solver.dynamics.result import Drift, Result, drift, total_energy
    from .solver.dynamics.scheme import Scheme
    from .solver.dynamics.settings import Newton, Settings
    from .solver.dynamics.simulation import simulate
    from .solver.errors import (
        AccuracyWarning,
        InputError,
        MeshWarning,
        ResultFileError,
        ResultFileWarning,
        StabilityWarning,
        StepError,
    )
    from .solver.input.files import read_model
    from .solver.input.running import ModelRun, run_model
    from .solver.model.attached import (
        Damping,
        GroundSpring,
        PointMass,
        Spring,
        foundation,
    )
    from .solver.model.bodies import RigidBody
    from .solver.model.cutting import Cut, cut
    from .solver.model.cyclic import Cyclic
    from .solver.model.directors import orient
    from .solver.model.generators import block, cylinder, sphere, sphere_segment
    from .solver.model.histories import (
        Expression,
        Harmonic,
        Steps,
        TimeFunction,
        read_time_function,
    )
    from .solver.model.joints import Hinge, Spherical
    from .solver.model.laminates import Lamina, Laminate, Ply, Section, Strength
    from .solver.model.linkages import (
        Ball,
        Cylindrical,
        Prismatic,
        Revolute,
        RigidLink,
        Tie,
        Universal,
    )
    from .solver.model.loads import (
        Centrifugal,
        Drive,
        Gravity,
        NodalLoad,
        NodalMoment,
        Pressure,
        Support,
        line_load,
        line_moment,
        surface_load,
        symmetry_plane,
    )
    from .solver.model.meshes import Mesh, join
    from .solver.model.model import Model, rigid_velocity
    from .solver.model.nonconservative import Drag, FollowerForce, UserForce
    from .solver.modes.buckling import Buckling, buckling
    from .solver.modes.vibration import Modes, modes
    from .solver.results.frame import data_frame
    from .solver.results.layers import LayerStresses, layer_stresses
    from .solver.results.reading import read
    from .solver.results.stresses import Configuration, Stresses, stresses
    from .solver.statics.arc_length import arc_length
    from .solver.statics.linear import solve_linear
    from .solver.statics.load_control import load_control
    from .solver.statics.result import LinearResult, StaticResult
    from .solver.statics.settings import StaticSettings

_WHERE = {
    "compilation": ("warm_up",),
    "dynamics.energies": ("energy_table",),
    "dynamics.probes": ("EnergyProbe", "JointProbe", "StressProbe"),
    "dynamics.result": ("Drift", "Result", "drift", "total_energy"),
    "dynamics.scheme": ("Scheme",),
    "dynamics.settings": ("Newton", "Settings"),
    "dynamics.simulation": ("simulate",),
    "errors": ("AccuracyWarning", "InputError", "MeshWarning", "ResultFileError",
               "ResultFileWarning", "StabilityWarning", "StepError"),
    "input.files": ("read_model",),
    "input.running": ("ModelRun", "run_model"),
    "model.attached": ("Damping", "GroundSpring", "PointMass", "Spring", "foundation"),
    "model.bodies": ("RigidBody",),
    "model.cutting": ("Cut", "cut"),
    "model.cyclic": ("Cyclic",),
    "model.directors": ("orient",),
    "model.generators": ("block", "cylinder", "sphere", "sphere_segment"),
    "model.histories": ("Expression", "Harmonic", "Steps", "TimeFunction", "read_time_function"),
    "model.joints": ("Hinge", "Spherical"),
    "model.laminates": ("Lamina", "Laminate", "Ply", "Section", "Strength"),
    "model.linkages": ("Ball", "Cylindrical", "Prismatic", "Revolute", "RigidLink", "Tie",
                       "Universal"),
    "model.loads": ("Centrifugal", "Drive", "Gravity", "NodalLoad", "NodalMoment", "Pressure",
                    "Support", "line_load", "line_moment", "surface_load", "symmetry_plane"),
    "model.meshes": ("Mesh", "join"),
    "model.model": ("Model", "rigid_velocity"),
    "model.nonconservative": ("Drag", "FollowerForce", "UserForce"),
    "modes.buckling": ("Buckling", "buckling"),
    "modes.vibration": ("Modes", "modes"),
    "results.frame": ("data_frame",),
    "results.layers": ("LayerStresses", "layer_stresses"),
    "results.reading": ("read",),
    "results.stresses": ("Configuration", "Stresses", "stresses"),
    "statics.arc_length": ("arc_length",),
    "statics.linear": ("solve_linear",),
    "statics.load_control": ("load_control",),
    "statics.result": ("LinearResult", "StaticResult"),
    "statics.settings": ("StaticSettings",),
}
_MODULE = {name: f"corovec.solver.{module}" for module, names in _WHERE.items() for name in names}

__all__ = [
    "AccuracyWarning", "Ball", "Buckling", "Centrifugal", "Configuration", "Cut", "Cyclic",
    "Cylindrical", "Damping", "Drag", "Drift", "Drive", "EnergyProbe", "Expression",
    "FollowerForce", "Gravity", "GroundSpring", "Harmonic", "Hinge", "InputError",
    "JointProbe", "Lamina", "Laminate", "LayerStresses", "LinearResult", "Mesh", "MeshWarning",
    "Model", "ModelRun", "Modes", "Newton", "NodalLoad", "NodalMoment", "Ply", "PointMass",
    "Pressure", "Prismatic", "Result", "ResultFileError", "ResultFileWarning", "Revolute",
    "RigidBody", "RigidLink", "Scheme", "Section", "Settings", "Spherical", "Spring",
    "StabilityWarning", "StaticResult", "StaticSettings", "StepError", "Steps", "Strength",
    "StressProbe", "Stresses", "Support", "Tie", "TimeFunction", "Universal", "UserForce",
    "arc_length", "block", "buckling", "cut", "cylinder", "data_frame", "drift",
    "energy_table", "foundation", "join", "layer_stresses", "line_load", "line_moment",
    "load_control", "modes", "orient", "read", "read_model", "read_time_function",
    "rigid_velocity", "run_model", "simulate", "solve_linear", "sphere", "sphere_segment",
    "stresses", "surface_load", "symmetry_plane", "total_energy", "warm_up",
]

if not (Path(__file__).parent / "solver").is_dir():  # a checkout: its folders stand at the top
    __path__.append(str(Path(__file__).parents[2]))


def __getattr__(name):
    if name not in _MODULE:
        raise AttributeError(f"module 'corovec' has no attribute '{name}'")
    value = globals()[name] = getattr(import_module(_MODULE[name]), name)
    return value


def __dir__():
    return sorted({*globals(), *__all__})
