"""Free plates that joints of every kind connect, directly or through rigid bodies: the exact scheme
gets to the end, energy is work, momenta are impulses, whatever their size, stiffness and step."""

import numpy as np

from corovec import (
    Ball,
    Cylindrical,
    Hinge,
    InputError,
    Mesh,
    Model,
    NodalLoad,
    Prismatic,
    Revolute,
    RigidBody,
    RigidLink,
    Scheme,
    Settings,
    TimeFunction,
    Universal,
    block,
    cut,
    simulate,
)

from .campaign import Target
from .physics import check_conserved, power, prepare, recorded

GAP = 0.2
"""Between plates that bodies carry, in their lengths."""


def direction(chance):
    """A unit vector."""
    found = np.array([chance.gauss(0, 1) for _ in range(3)])
    return found / np.linalg.norm(found)


def moments(chance, inertia, dt, pulse):
    """Fields of a ``Turning``: nothing, or one or two of what can act.

    Stiffness and damping are up to 1e4 times what the ``inertia`` [kg m^2] has in a step, motors
    turn it by up to 0.05 rad in one.
    """
    k, angle, rate = power(chance, -3, 4) * inertia / dt**2, *(power(chance, -4, -1) for _ in "ar")
    damping = power(chance, -3, 4) * inertia / dt
    kinds = ({"stiffness": k, "rest": chance.uniform(-1e-3, 1e-3)},
             {"damping": damping},
             {"spring_angles": (-angle, 0.0, 0.2 * angle, angle),
              "spring_moments": (-k * angle, 0.0, chance.random() * k * angle, k * angle)},
             {"damper_rates": (-rate / dt, 0.0, rate / dt),
              "damper_moments": (-chance.random() * damping * rate / dt, 0.0, damping * rate / dt)},
             {"stops": (-power(chance, -4, -1), power(chance, -4, -1)), "stop_stiffness": k},
             {"torque": power(chance, -5, -1.3) * inertia / dt**2, "history": pulse})
    return {name: value for kind in chance.sample(kinds, chance.randrange(3))
            for name, value in kind.items()}


def joint(chance, ends, places, moment):
    """A joint of two bodies near the middle of their ``places``."""
    at = np.mean(places, axis=0) + 0.1 * np.ptp(places, axis=0).max() * direction(chance)
    axis = direction(chance)
    side = np.cross(axis, direction(chance))
    made = {Ball: (at,), Revolute: (at, axis), Cylindrical: (at, axis), Prismatic: (at, axis),
            Universal: (at, axis, side / np.linalg.norm(side)), RigidLink: places}
    kind = chance.choice(list(made))
    return kind(*ends, *(tuple(map(float, one)) for one in made[kind]),
                **(moment if kind is Revolute else {}))


def hinged(chance, n, size, width, divisions, moment):
    """Mesh and joints of n plates along x, opened between them, as some are folded by hinges."""
    mesh = block([(0, 0, 0), (n * size, 0, 0), (n * size, width, 0), (0, width, 0)],
                 (n * divisions[0], divisions[1]))
    joints = []
    for k in range(1, n):
        mesh, *sides = cut(mesh, (k * size, 0, 0), (k * size, width, 0))
        joints.append(Hinge(*sides, **moment()))
    return mesh, joints, []


def carried(chance, n, size, width, divisions, moment, mass):
    """Mesh, joints and bodies of n plates along x with a body at each inner edge; ``mass`` [kg]: of
    a plate."""
    plates = [block([(x, 0, 0), (x + size, 0, 0), (x + size, width, 0), (x, width, 0)], divisions)
              for x in size * (1.0 + GAP) * np.arange(n)]
    first = np.cumsum([0, *(len(plate.nodes) for plate in plates)])
    mesh = Mesh(np.concatenate([plate.nodes for plate in plates]),
                np.concatenate([plate.quads + k for plate, k in zip(plates, first)]))
    x, joints, bodies = mesh.nodes[:, 0], [], []
    for k in range(1, n):
        edges = [x_0 + size * (k - 1) * (1.0 + GAP) for x_0 in (size, size * (1.0 + GAP))]
        for name, edge in zip("ab", edges):
            nodes = np.flatnonzero(np.abs(x - edge) < 1e-6 * size)
            centre = mesh.nodes[nodes].mean(axis=0) + 0.05 * size * direction(chance)
            own = mass * power(chance, -2, 2)
            inertia = own * size**2 * np.array([chance.uniform(0.05, 0.1) for _ in range(3)])
            bodies.append(RigidBody(f"{name}{k}", own, inertia.tolist(), centre.tolist(),
                                    nodes.tolist()))
        ends = bodies[-2:]
        joints.append(joint(chance, [body.name for body in ends],
                            [np.array(body.centre) for body in ends], moment()))
    return mesh, joints, bodies


def mechanism(chance):
    """A free model and its settings."""
    size, density, dt = power(chance, -3, 2), power(chance, 0, 4), power(chance, -5, 3)
    n, divisions = chance.randrange(2, 4), (chance.randrange(1, 4), chance.randrange(1, 3))
    width, thickness = size * chance.uniform(0.3, 1.0), size * power(chance, -2.5, -0.8)
    youngs, turn = power(chance, 0, 10) * density * (size / dt)**2, power(chance, -6, -1.3)
    mass, seconds = density * size * width * thickness, dt * 2 * chance.randrange(1, 4)
    pulse = TimeFunction((0.0, seconds / 2, seconds), (0.0, 1.0, 0.0))

    def moment():
        return moments(chance, mass * size**2 / 12.0, dt, pulse)

    if chance.random() < 0.5:
        mesh, joints, bodies = hinged(chance, n, size, width, divisions, moment)
    else:
        mesh, joints, bodies = carried(chance, n, size, width, divisions, moment, mass)
    loads = [NodalLoad(chance.randrange(len(mesh.nodes)),
                       turn * mass * size / dt**2 / 25.0 * direction(chance), pulse)
             for _ in range(chance.randrange(1, 4))]
    model = Model.of(mesh, thickness, youngs, chance.uniform(0, 0.45), density, loads=loads,
                     joints=joints, bodies=bodies)
    scheme = Scheme("exact", dissipation=chance.choice((0.0, 0.0, chance.random())))
    return model, Settings(dt=dt, end_time=12 * dt, scheme=scheme)


def attempt(chance, prepared, folder):
    try:
        model, settings = mechanism(chance)
    except InputError:  # an axis beside its joint's places
        return "refused"
    result, _ = recorded(simulate, model, settings)
    check_conserved(model, result)
    return "halved" if result.history["halvings"].any() else "conserved"


MECHANISMS = Target("joints", "plates and bodies with joints get to the end, energy is work, "
                    "momenta are impulses", prepare, attempt)
