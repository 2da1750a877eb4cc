"""Curves of Exudyn for two examples: `four_bar.csv` and `double_pendulum.csv`.

Exudyn (https://github.com/jgerstmayr/EXUDYN) has multibody systems with geometrically exact planar
beams.  `tox -e exudyn` installs it apart from everything else and runs this script, which needs
nothing of corovec:

    python exudyn_curves.py [FOLDER] [--study]

It writes both files, and with `--study` prints how the curves change with its mesh and step.
"""

import math
import sys
from importlib import metadata
from pathlib import Path

import exudyn as exu
import numpy as np
from exudyn import beams
from exudyn import utilities as items

FRAMES = 201
"""Instants of each file, the first one 0 s."""


def beam(mbs, start, end, elements, youngs, density, width, thickness, weight=(0, 0, 0)):
    """Nodes of a straight beam of quadratic elements with Timoshenko's 5/6 and no lateral strain,
    as a strip with nu = 0."""
    area, second = width * thickness, width * thickness**3 / 12.0
    template = items.ObjectBeamGeometricallyExact2D(
        nodeNumbers=[0, 0, 0], massPerLength=density * area, crossSectionInertia=density * second,
        bendingStiffness=youngs * second, axialStiffness=youngs * area,
        shearStiffness=5.0 / 6.0 * 0.5 * youngs * area)
    return beams.GenerateBeamElementsAlongLine(mbs, [*start, 0], [*end, 0], elements, template,
                                               gravity=list(weight))["nodes"]


def solved(mbs, sensors, end, dt):
    """Rows of sensors at equal instants, by the generalized alpha method."""
    mbs.Assemble()
    given = exu.SimulationSettings()
    given.timeIntegration.numberOfSteps = round(end / dt)
    given.timeIntegration.endTime = end
    given.timeIntegration.generalizedAlpha.spectralRadius = 0.6
    given.timeIntegration.newton.relativeTolerance = 1e-8
    given.timeIntegration.newton.absoluteTolerance = 1e-6
    given.timeIntegration.verboseMode = 0
    given.solution.file.write = False
    given.solution.sensors.writePeriod = end / (FRAMES - 1)
    mbs.SolveDynamic(given)
    columns = [mbs.GetSensorStoredData(sensor) for sensor in sensors]
    return columns[0][:, 0], [rows[:, 1:] for rows in columns]


def place_of(mbs, node):
    return mbs.AddSensor(items.SensorNode(nodeNumber=node, storeInternal=True,
                                          outputVariableType=exu.OutputVariableType.Position))


def four_bar(elements, dt):
    """Time, middle of the coupler off the line of its ends [m], moment of the drive [N m]."""
    system = exu.SystemContainer()
    mbs = system.AddSystem()
    A, B, D = np.array((0.0, 0.0)), np.array((0.3, 0.0)), np.array((1.0, 0.0))
    C = B + 0.9 * np.array((9.0 / 14.0, math.sqrt(1.0 - (9.0 / 14.0)**2)))
    coupler = beam(mbs, B, C, elements, 3e9, 1200.0, 0.05, 0.006)
    ground = mbs.AddObject(items.ObjectGround())
    bodies = []
    for start, end, mass in ((A, B, 0.5), (D, C, 1.0)):
        length, along = np.linalg.norm(end - start), end - start
        node = mbs.AddNode(items.NodeRigidBody2D(referenceCoordinates=[
            *(0.5 * (start + end)), math.atan2(along[1], along[0])]))
        body = mbs.AddObject(items.RigidBody2D(nodeNumber=node, mass=mass,
                                               inertia=mass * length**2 / 12.0))
        markers = [mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=body, localPosition=[x, 0, 0]))
                   for x in (-0.5 * length, 0.5 * length)]
        fixed = mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=ground,
                                                       localPosition=[*start, 0]))
        mbs.AddObject(items.RevoluteJoint2D(markerNumbers=[fixed, markers[0]]))
        bodies.append((node, markers[1]))
    for (_, marker), node in zip(bodies, (coupler[0], coupler[-1])):
        tip = mbs.AddMarker(items.MarkerNodePosition(nodeNumber=node))
        mbs.AddObject(items.RevoluteJoint2D(markerNumbers=[marker, tip]))

    def angle(mbs, t, item, offset):
        return 2.0 * math.pi * ((t**4 + 0.25**4)**0.25 - 0.25)

    def rate(mbs, t, item, offset):
        return 2.0 * math.pi * t**3 / (t**4 + 0.25**4)**0.75

    rest = mbs.AddMarker(items.MarkerNodeCoordinate(
        nodeNumber=mbs.AddNode(items.NodePointGround()), coordinate=0))
    turned = mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=bodies[0][0], coordinate=2))
    drive = mbs.AddObject(items.CoordinateConstraint(
        markerNumbers=[rest, turned], offset=1.0, offsetUserFunction=angle,
        offsetUserFunction_t=rate))
    sensors = [place_of(mbs, node) for node in (coupler[0], coupler[len(coupler) // 2],
                                                coupler[-1])]
    sensors.append(mbs.AddSensor(items.SensorObject(
        objectNumber=drive, storeInternal=True,
        outputVariableType=exu.OutputVariableType.Force)))
    time, (b, m, c, force) = solved(mbs, sensors, 2.0, dt)
    chord = c - b
    off = (chord[:, 0] * (m - b)[:, 1] - chord[:, 1] * (m - b)[:, 0]) / np.hypot(
        chord[:, 0], chord[:, 1])
    return np.column_stack([time, off, -force[:, 0]])


def double_pendulum(elements, dt):
    """Time, places of the joint and of the tip [m]."""
    system = exu.SystemContainer()
    mbs = system.AddSystem()
    strip = (elements, 2e7, 1000.0, 0.01, 0.002, (0, -9.81, 0))
    one = beam(mbs, (0.0, 0.0), (0.25, 0.0), *strip)
    two = beam(mbs, (0.25, 0.0), (0.5, 0.0), *strip)
    fixed = mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=mbs.AddObject(items.ObjectGround()),
                                                   localPosition=[0, 0, 0]))
    ends = [mbs.AddMarker(items.MarkerNodePosition(nodeNumber=node))
            for node in (one[0], one[-1], two[0])]
    mbs.AddObject(items.RevoluteJoint2D(markerNumbers=[fixed, ends[0]]))
    mbs.AddObject(items.RevoluteJoint2D(markerNumbers=ends[1:]))
    time, places = solved(mbs, [place_of(mbs, node) for node in (one[-1], two[-1])], 1.0, dt)
    return np.column_stack([time, *(rows[:, :2] for rows in places)])


CURVES = {"four_bar": (four_bar, 32, 6.25e-5, "t [s],deflection [m],moment [N m]"),
          "double_pendulum": (double_pendulum, 32, 6.25e-5,
                              "t [s],joint x [m],joint z [m],tip x [m],tip z [m]")}
"""Functions, elements of a beam, steps [s] and the names of the columns."""


def study(name):
    """Print the largest changes of all columns with elements and steps."""
    curve, elements, dt, _ = CURVES[name]
    best = curve(elements, dt)
    for other in ((elements // 2, dt), (elements // 4, dt), (elements, 2.0 * dt),
                  (elements, 4.0 * dt), (elements, 8.0 * dt)):
        off = np.abs(curve(*other) - best).max(axis=0)[1:]
        print(f"{name}: {other[0]} elements, step {other[1]:g} s:",
              " ".join(f"{x:.2e}" for x in off))
    print("largest values:", " ".join(f"{x:.3e}" for x in np.abs(best).max(axis=0)[1:]))


if __name__ == "__main__":
    given = [word for word in sys.argv[1:] if word != "--study"]
    folder = Path(given[0]) if given else Path(__file__).parent.parent
    for name, (curve, elements, dt, columns) in CURVES.items():
        if "--study" in sys.argv:
            study(name)
        head = (f"Exudyn {metadata.version('exudyn')}, {elements} quadratic geometrically exact "
                f"beam elements a beam, step {dt:g} s; examples/peers/exudyn_curves.py\n{columns}")
        np.savetxt(folder / f"{name}.csv", curve(elements, dt), fmt="%.9g", delimiter=",",
                   header=head)
