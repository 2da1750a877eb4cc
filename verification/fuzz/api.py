"""Junk at every argument of the public functions: an error of one short line, or success."""

import numpy as np

import corovec
from corovec import (
    Centrifugal,
    Gravity,
    InputError,
    Mesh,
    Model,
    Newton,
    NodalLoad,
    NodalMoment,
    Pressure,
    ResultFileError,
    Scheme,
    Settings,
    StaticSettings,
    StepError,
    Support,
    TimeFunction,
    simulate,
    solve_linear,
)
from corovec.benchmarks import load_case
from corovec.solver.input.reference import START
from corovec.solver.model import mesh
from corovec.solver.model.histories import CONSTANT, FunctionOfTime
from corovec.verification.models import MATERIAL, rectangle

from .campaign import Fault, Target
from .junk import spoiled

LONGEST = 300
"""Characters of a message."""

CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0))
CLAMP = Support((0, 3), ("x", "y", "z", "px", "py", "pz"))
PLATE = rectangle(2.0, 1.0, (2, 1))
RUN = Settings(dt=0.1, end_time=0.2)
PUSH = TimeFunction((0.0, 1.0), (0.0, 1.0))
UP = (0.0, 0.0, 1e-3)
METAL = corovec.Lamina.isotropic(1e6, 0.3, 1.0)
LAYER = corovec.Laminate([corovec.Ply(METAL, 0.1)])
LAYERED = Model(PLATE.nodes, PLATE.quads, sections=[corovec.Section(LAYER)])
NAMED = Mesh(PLATE.nodes, PLATE.quads, groups={"all": [0, 1]}, node_sets={"start": [0, 3]},
             lines={"start": [(0, 3)]})


def table(folder):
    """``{function: its good arguments}`` of what this suite may import; a dict of keywords each."""
    path, csv = folder / "run.h5", folder / "table.csv"
    csv.write_text("t,f\n0,0\n1,1\n")
    result = simulate(PLATE, RUN, output=path)
    history = result.history
    NAMED.write(folder / "plate.inp", overwrite=True)
    held = rectangle(2.0, 1.0, (2, 1), loads=[NodalLoad(2, UP)], supports=[CLAMP])
    line = {"nodes": PLATE.nodes, "line": [0, 1, 2], "history": PUSH}
    joint = {"one": "hub", "other": 0, "at": UP, "name": "neck"}
    tables = {"spring_angles": (-1.0, 1.0), "spring_moments": (-1.0, 2.0),
              "damper_rates": (-1.0, 1.0), "damper_moments": (-1.0, 1.0)}
    files = {"output": None, "overwrite": False, "resume": False}
    return {
        Model: {"nodes": PLATE.nodes, "quads": PLATE.quads, **MATERIAL,
                 "loads": [NodalLoad(2, UP)], "supports": [CLAMP], "normals": PLATE.normals,
                 "velocity": np.zeros((6, 3)), "normal_velocity": np.zeros((6, 3)),
                 "membrane": "stress", "shear": "mitc4", "fold_angle": 45.0, "patches": [0, 0],
                 "attached": [corovec.PointMass(0, 1.0)], "damping": corovec.Damping(1.0),
                 "sections": (), "cyclic": None, "joints": (), "bodies": ()},
        corovec.PointMass: {"node": 0, "mass": 1.0, "inertia": 0.1},
        corovec.Spring: {"node": 0, "other": 1, "stiffness": 1.0, "length": 1.0, "damping": 1.0,
                          "spring_extensions": (-1.0, 1.0), "spring_forces": (-1.0, 2.0),
                          "damper_rates": (-1.0, 1.0), "damper_forces": (-1.0, 1.0)},
        corovec.GroundSpring: {"node": 0, "stiffness": (1.0, 1.0, 1.0), "turning": 1.0},
        corovec.foundation: {"nodes": PLATE.nodes, "quads": PLATE.quads,
                              "stiffness": (1.0, 1.0, 1.0)},
        corovec.Damping: {"mass": 1.0, "stiffness": 0.01},
        corovec.Drive: {"nodes": (0, 3), "translation": UP, "rotation": UP, "about": UP,
                         "history": PUSH, "turning": PUSH},
        corovec.StressProbe: {"at": 0, "axes": (1.0, 0.0, 0.0)},
        corovec.EnergyProbe: {"elements": [0, 1]},
        corovec.JointProbe: {"joint": "root"},
        corovec.Hinge: {"nodes": (0, 3), "others": (6, 7), "stiffness": 1.0, "rest": 0.1,
                         "turning": PUSH, "damping": 0.1, **tables, "stops": (-1.0, 1.0),
                         "stop_stiffness": 1.0, "lock": 0.5, "lock_stiffness": 1.0,
                         "lock_damping": 0.1, "torque": 1.0, "history": PUSH, "name": "root"},
        corovec.Spherical: {"nodes": (0, 6), "name": "corner"},
        corovec.RigidBody: {"name": "hub", "mass": 1.0, "inertia": (1.0, 1.0, 1.0), "centre": UP,
                            "nodes": (0, 3), "axes": np.eye(3)},
        corovec.Ball: joint,
        corovec.Revolute: {**joint, "axis": UP, "angle": None, "driving": CONSTANT,
                           "stiffness": 1.0, "rest": 0.1, "turning": PUSH, "damping": 0.1, **tables,
                           "stops": (-1.0, 1.0), "stop_stiffness": 1.0, "lock": 0.5,
                           "lock_stiffness": 1.0, "lock_damping": 0.1, "torque": 1.0,
                           "history": PUSH},
        corovec.Cylindrical: {**joint, "axis": UP},
        corovec.Prismatic: {**joint, "axis": UP},
        corovec.Universal: {**joint, "axis": UP, "other_axis": (1.0, 0.0, 0.0)},
        corovec.RigidLink: {**joint, "to": (1.0, 0.0, 0.0)},
        corovec.Tie: {"nodes": (0, 3), "line": (6, 7), "name": "seam"},
        corovec.cut: {"mesh": NAMED, "start": (1.0, 0.0, 0.0), "end": (1.0, 1.0, 0.0)},
        corovec.Cyclic: {"sectors": 4, "axis": (0.0, 0.0, 1.0), "about": UP},
        corovec.symmetry_plane: {"nodes": (0, 3), "normal": (1.0, 0.0, 0.0)},
        corovec.Strength: dict.fromkeys(("Xt", "Xc", "Yt", "Yc", "S"), 1.0),
        corovec.Lamina: {"E1": 2.0, "E2": 1.0, "nu12": 0.2, "G12": 1.0, "G13": 1.0, "G23": 1.0,
                         "density": 1.0, "alpha1": 0.0, "alpha2": 0.0, "strength": None},
        corovec.Lamina.isotropic: {"youngs": 1e6, "poisson": 0.3, "density": 1.0, "alpha": 0.0,
                                   "strength": None},
        corovec.Ply: {"lamina": METAL, "thickness": 0.1, "angle": 0.0},
        corovec.Laminate: {"plies": [corovec.Ply(METAL, 0.1)], "offset": 0.0},
        corovec.Section: {"laminate": LAYER, "elements": [0, 1], "direction": (1.0, 0.0, 0.0),
                          "temperature": 1e-3, "gradient": 1e-3},
        corovec.layer_stresses: {"model": LAYERED, "section": 0, "state": corovec.Configuration(
            np.zeros((6, 3)), PLATE.normals)},
        Newton: {"kind": "full", "tolerance": 1e-6, "min_iterations": 3, "max_iterations": 20},
        Scheme: {"name": "quasi", "rho_inf": 1.0, "transformation": "midpoint", "axes": "nodal",
                 "dissipation": 0.0, "dissipates": "selective", "order": 2},
        Settings: {"dt": 0.1, "end_time": 0.2, "scheme": Scheme(), "newton": Newton(),
                    "solver": "auto", "frame_every": 0, "stresses": False, "error": 0.0},
        StaticSettings: {"solver": "skyline", "tolerance": 1e-16, "max_iterations": 16,
                          "fast_iterations": 6, "max_divisions": 12, "stresses": False},
        NodalLoad: {"node": 0, "force": UP, "history": PUSH},
        NodalMoment: {"node": 0, "moment": UP, "history": PUSH},
        Pressure: {"pressure": 1e-3, "elements": [0, 1], "history": PUSH},
        Support: {"nodes": (0, 3), "components": ("x", "y", "z"), "displacement": 1e-3,
                   "history": PUSH, "axes": None},
        Gravity: {"acceleration": UP, "history": PUSH},
        Centrifugal: {"omega": UP, "about": UP, "history": PUSH},
        corovec.FollowerForce: {"node": 0, "force": 1e-3, "history": PUSH},
        corovec.Drag: {"coefficient": 1.0, "density": 1.0, "elements": [0, 1], "velocity": UP,
                       "history": PUSH},
        corovec.UserForce: {"function": (lambda t, x, v, p: -1e-3 * v), "history": PUSH},
        TimeFunction: {"times": (0.0, 1.0, 2.0), "values": (0.0, 1.0, 0.0)},
        corovec.Steps: {"times": (0.0, 1.0), "values": (1.0, 0.0)},
        corovec.Harmonic: {"frequency": 0.5, "amplitude": 1.0, "phase": 0.0, "mean": 0.0},
        corovec.Expression: {"text": "sin(t)"},
        corovec.read_time_function: {"file": csv, "columns": (0, 1)},
        corovec.line_load: {**line, "force": UP, "quads": None},
        corovec.line_moment: {**line, "moment": UP, "quads": None},
        corovec.surface_load: {"nodes": PLATE.nodes, "quads": PLATE.quads, "force": UP,
                                "history": PUSH},
        corovec.rigid_velocity: {"model": PLATE, "velocity": UP, "omega": UP, "about": UP},
        simulate: {"model": PLATE, "settings": RUN, **files, "progress": None, "case": None,
                    "probes": {"tip": 2}, "start": None, "threads": 1},
        corovec.load_control: {"model": held, "factors": [0.5, 1.0], **files, "progress": None,
                                "settings": StaticSettings()},
        corovec.arc_length: {"model": held, "length": 1e-3, "until": (lambda factor, u: True),
                              "settings": StaticSettings(), "max_steps": 5, "wanted": 5,
                              "switch": False, **files},
        solve_linear: {"model": held, "solver": "skyline"},
        corovec.modes: {"model": held, "n": 3, "factor": 0.0, "state": corovec.Configuration(
            np.zeros((6, 3)), PLATE.normals)},
        corovec.buckling: {"model": held, "n": 2, "factor": 0.0, "state": corovec.Configuration(
            np.zeros((6, 3)), PLATE.normals)},
        corovec.stresses: {"model": PLATE, "axes": UP[::-1], "state": corovec.Configuration(
            np.zeros((6, 3)), PLATE.normals)},
        corovec.total_energy: {"history": history},
        corovec.energy_table: {"run": result, "row": -1},
        corovec.drift: {"history": history, "unloaded_at": 0.0, "supported": False},
        corovec.read: {"path": path},
        corovec.read_model: {"path": START},
        corovec.run_model: {"definition": load_case("l-plate"), "elements": 30, "settings": RUN,
                            "progress": None, "membrane": "stress", "threads": 1, **files},
        Mesh: {"nodes": PLATE.nodes, "quads": PLATE.quads, "groups": {"all": [0, 1]},
               "node_sets": {"start": [0, 3]}, "lines": {"start": [(0, 3)]}, "normals": None},
        NAMED.write: {"path": folder / "plate.msh", "overwrite": True},
        Mesh.read: {"path": folder / "plate.inp", "merge": True, "reduce": True,
                    "all_quads": True, "apart": True},
        NAMED.named: {"name": "a"},
        NAMED.nodes_at: {"x": 0.0, "y": (0.0, 1.0), "z": 0.0, "tolerance": 1e-6},
        NAMED.elements_at: {"x": (0.0, 2.0), "y": (0.0, 1.0), "z": 0.0, "tolerance": 1e-6},
        NAMED.line: {"start": (0.0, 0.0, 0.0), "end": (2.0, 0.0, 0.0)},
        NAMED.chain: {"name": "start"},
        NAMED.per_element: {"values": {"all": 0.1}, "default": 1.0},
        Model.of: {"mesh": NAMED, **MATERIAL, "sections": ()},
        corovec.block: {"corners": CORNERS, "divisions": (2, 2)},
        corovec.cylinder: {"radius": 1.0, "length": 1.0, "divisions": (9, 2), "angle": 360.0},
        corovec.sphere: {"radius": 1.0, "divisions": 3},
        corovec.sphere_segment: {"radius": 1.0, "polar_angles": (30.0, 90.0), "divisions": (9, 2),
                                 "angle": 360.0},
        corovec.join: {"meshes": [NAMED], "tolerance": 1e-6, "apart": False},
        mesh.node_at: {"nodes": PLATE.nodes, "point": (0.0, 0.0, 0.0)},
        mesh.line_nodes: {"nodes": PLATE.nodes, "quads": PLATE.quads, "start": (0.0, 0.0, 0.0),
                           "end": (2.0, 0.0, 0.0)},
        load_case: {"name": "l-plate"},
        load_case("l-plate").model: {"elements": 30, "load_factor": 1.0, "loads": ["P1"],
                                    "rising": False},
        corovec.data_frame: {"history": history},
        corovec.orient: {"nodes": PLATE.nodes, "quads": PLATE.quads}}



def used(made):
    """Take what was accepted into a short run."""
    if isinstance(made, Model):
        simulate(made, RUN)
    elif isinstance(made, NodalLoad | NodalMoment | Pressure | Gravity | corovec.FollowerForce
                    | corovec.Drag | corovec.UserForce):
        simulate(rectangle(2.0, 1.0, (2, 1), loads=[made]), RUN)
    elif isinstance(made, Centrifugal):
        corovec.load_control(rectangle(2.0, 1.0, (2, 1), loads=[made], supports=[CLAMP]), [1.0])
    elif isinstance(made, Support):
        solve_linear(rectangle(2.0, 1.0, (2, 1), loads=[NodalLoad(2, UP)], supports=[made]))
    elif isinstance(made, FunctionOfTime):
        simulate(rectangle(2.0, 1.0, (2, 1), loads=[NodalLoad(2, UP, made)]), RUN)
    elif isinstance(made, corovec.Section):
        solve_linear(Model(PLATE.nodes, PLATE.quads, 0.1, 1e6, 0.3, 1.0, sections=[made],
                           supports=[CLAMP]))
    elif isinstance(made, Settings) and made.n_steps < 10:
        simulate(PLATE, made)


def attempt(chance, calls, folder):
    function, arguments = chance.choice(list(calls.items()))
    name = chance.choice(list(arguments))
    try:
        used(function(**{**arguments, name: spoiled(chance, arguments[name])}))
    except (InputError, ResultFileError, StepError) as error:
        if len(str(error)) >= LONGEST or not str(error).isprintable():
            raise Fault(f"{function.__name__}({name}): a message of {len(str(error))} characters, "
                        f"or of several lines: {error!r}") from None
        return type(error).__name__
    except Exception as error:
        error.args = (f"{function.__name__}({name}): {error}",)
        raise
    return "success"


TARGET = Target("api", "junk as any argument is one short line", table, attempt)
