"""Shells of the popular static benchmarks, as models: meshes, supports and loads.

Units are those of each problem; densities are 1.
"""

import numpy as np

from corovec import Model, NodalLoad, Support, solve_linear, surface_load

from .geometry import cylinder, hemisphere_quarter, surface

CLAMPED = ("x", "y", "z", "px", "py", "pz")
SYMMETRY = {"x": ("x", "px"), "y": ("y", "py"), "z": ("z", "pz")}
"""Components that vanish on a clamped edge, and on the plane of symmetry normal to an axis."""


def plate(mesh, thickness, youngs, poisson, loads, supports, **options):
    """Model of a ``Surface`` with unit density."""
    return Model(mesh.nodes, mesh.quads, thickness, youngs, poisson, 1.0, loads=loads,
                 supports=supports, normals=mesh.normals, **options)


def strip(length, elements, loads):
    """Cantilever strip of width 1, h = 0.1, E = 1.2e6, nu = 0; returns (model, tip node)."""
    mesh = surface(lambda x, y: (x, y, 0.0 * x), (elements, 1), (0.0, length), (0.0, 1.0))
    tip = mesh.where(mesh.nodes[:, 0] == length)
    root = mesh.where(mesh.nodes[:, 0] == 0.0)
    return plate(mesh, 0.1, 1.2e6, 0.0, loads(mesh.nodes, tip), [Support(root, CLAMPED)]), tip[0]


def twisted_strip(divisions, thickness, force, degrees=90.0, **options):
    """Cantilever 12 x 1.1 twisted over its length, E = 29e6, nu = 0.22, under a force at the middle
    of its tip; returns (model, tip node)."""
    turn = np.radians(degrees) / 12.0
    mesh = surface(lambda x, s: (x, s * np.cos(turn * x), s * np.sin(turn * x)), divisions,
                   (0.0, 12.0), (-0.55, 0.55))
    root, tip = mesh.where(mesh.nodes[:, 0] == 0.0), mesh.nearest((12.0, 0.0, 0.0))
    return plate(mesh, thickness, 29e6, 0.22, [NodalLoad(tip, force)], [Support(root, CLAMPED)],
                 **options), tip


def quarter_hemisphere(n, thickness, force, **options):
    """Quarter of the pinched hemisphere with an 18 degree hole, n x n elements; R = 10,
    E = 6.825e7, nu = 0.3.

    Returns:
        (model, node A that is pulled along X, node B that is pushed against Y).
    """
    mesh = hemisphere_quarter(10.0, 18.0, n)
    azimuth, elevation = mesh.parameters.T
    quarter = azimuth == azimuth.max()
    a = mesh.where((azimuth == 0.0) & (elevation == 0.0))[0]
    b = mesh.where(quarter & (elevation == 0.0))[0]
    held = mesh.where((elevation == elevation.max()) & (azimuth == 0.0))
    supports = [Support(mesh.where(azimuth == 0.0), SYMMETRY["y"]),
                Support(mesh.where(quarter), SYMMETRY["x"]), Support(held, ("z",))]
    loads = [NodalLoad(a, (force, 0.0, 0.0)), NodalLoad(b, (0.0, -force, 0.0))]
    return plate(mesh, thickness, 6.825e7, 0.3, loads, supports, **options), a, b


def linear_hemisphere(n, thickness=0.04, solve=solve_linear, **options):
    """Displacement of the loaded points of ``quarter_hemisphere`` under a force of thickness^3.

    ``solve`` gives the displacements of a model, as ``solve_linear`` does.
    """
    model, a, b = quarter_hemisphere(n, thickness, (thickness / 0.04) ** 3, **options)
    u, _ = solve(model)
    return 0.5 * (u[a, 0] - u[b, 1])


def eighth_cylinder(radius, half_length, divisions, ends):
    """Eighth of a cylinder about X with the supports of its symmetry planes, crown at +Z.

    Returns:
        (mesh, supports, node at the side in the middle, node at the side of the end); node 0 is the
        crown.
    """
    mesh = cylinder(radius, (0.0, np.pi / 2.0), (0.0, half_length), divisions)
    angle, x = mesh.parameters.T
    supports = [Support(mesh.where(x == 0.0), SYMMETRY["x"]),
                Support(mesh.where(angle == 0.0), SYMMETRY["y"]),
                Support(mesh.where(angle == np.pi / 2.0), SYMMETRY["z"])]
    if ends == "diaphragm":
        supports.append(Support(mesh.where(x == half_length), ("y", "z")))
    b = mesh.where((angle == np.pi / 2.0) & (x == 0.0))[0]
    c = mesh.where((angle == np.pi / 2.0) & (x == half_length))[0]
    return mesh, supports, b, c


def roof(n, thickness):
    """Quarter of the hinged roof under its central force; node 0 is the centre."""
    mesh = cylinder(2540.0, (0.0, 0.1), (0.0, 254.0), (n, n))
    angle, x = mesh.parameters.T
    supports = [Support(mesh.where(x == 0.0), SYMMETRY["x"]),
                Support(mesh.where(angle == 0.0), SYMMETRY["y"]),
                Support(mesh.where(angle == 0.1), ("x", "y", "z"))]
    return plate(mesh, thickness, 3102.75, 0.3, [NodalLoad(0, (0.0, 0.0, -750.0))], supports)


def roof_under_weight(n, thickness=0.25, **options):
    """A quarter of the Scordelis-Lo roof, n x n elements, angle from the crown first."""
    mesh = cylinder(25.0, (0.0, np.radians(40.0)), (0.0, 25.0), (n, n))
    angle, x = mesh.parameters.T
    supports = [Support(mesh.where(x == 25.0), ("y", "z")),
                Support(mesh.where(x == 0.0), SYMMETRY["x"]),
                Support(mesh.where(angle == 0.0), SYMMETRY["y"])]
    loads = surface_load(mesh.nodes, mesh.quads, (0.0, 0.0, -90.0))
    return plate(mesh, thickness, 4.32e8, 0.0, loads, supports, **options)
