"""Von Mises stresses and their limits: a plate with a hole, and the roof under its weight."""

import numpy as np

from corovec import NodalLoad, Support, solve_linear, stresses

from ..case import Case, Row, at_least
from ..geometry import surface
from ..literature import MACNEAL
from ..shells import plate, roof_under_weight

OUTER = 4.0
"""Radius at which the plate is cut, in radii of its hole."""


def kirsch(x, y):
    """Stresses (..., 3) xx, yy, xy around a hole of radius 1 under unit tension along x."""
    r2, angle = x**2 + y**2, np.arctan2(y, x)
    near, nearer = 1.0 / r2, 1.0 / r2**2
    cosine, sine, cosine_4, sine_4 = (of(k * angle) for k in (2, 4) for of in (np.cos, np.sin))
    return np.stack([
        1.0 - near * (1.5 * cosine + cosine_4) + 1.5 * nearer * cosine_4,
        -near * (0.5 * cosine - cosine_4) - 1.5 * nearer * cosine_4,
        -near * (0.5 * sine + sine_4) + 1.5 * nearer * sine_4], axis=-1)


def plate_with_hole(n):
    """Von Mises stresses (n, n) at the centres of a quarter plate, angle first, radius second, and
    the exact ones there; the rim bears the exact tractions, so that no edge is at infinity."""
    mesh = surface(lambda s, t: (OUTER**s * np.cos(t), OUTER**s * np.sin(t), 0.0 * s), (n, n),
                   (0.0, 1.0), (0.0, 0.5 * np.pi), exact_normals=False)
    s, t = mesh.parameters.T
    rim, loads = mesh.where(s == 1.0), []
    for one, other in zip(rim, rim[1:]):
        a, b = mesh.nodes[one], mesh.nodes[other]
        normal = np.array([b[1] - a[1], a[0] - b[0]])  # times the length of the edge
        for part in 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0):  # Gauss points
            xx, yy, xy = kirsch(*(a + part * (b - a))[:2])
            pull = 0.5 * np.array([xx * normal[0] + xy * normal[1],
                                   xy * normal[0] + yy * normal[1], 0.0])
            loads += [NodalLoad(one, tuple((1.0 - part) * pull)),
                      NodalLoad(other, tuple(part * pull))]
    supports = [Support(mesh.where(t == 0.0), ("y",)),
                Support(mesh.where(t == t.max()), ("x",)),
                Support(tuple(range(len(mesh.nodes))), ("z", "px", "py", "pz"))]
    model = plate(mesh, 1.0, 1000.0, 0.3, loads, supports)
    found = stresses(model, solve_linear(model).state).von_mises[:, 1].reshape(n, n)
    xx, yy, xy = kirsch(*mesh.nodes[mesh.quads].mean(axis=1)[:, :2].T).T
    return found, np.sqrt(xx**2 - xx * yy + yy**2 + 3.0 * xy**2).reshape(n, n)


def run_plate_with_hole():
    errors = {}
    for n, tolerance in ((8, 0.06), (16, 0.015), (32, 0.003)):
        found, exact = plate_with_hole(n)
        errors[n] = np.sqrt(np.mean((found - exact) ** 2) / np.mean(exact**2))
        # a parabola through the three elements next to the edge
        peak = np.dot((1.875, -1.25, 0.375), found[-1, :3])
        yield Row(f"{n} x {n}: stress concentration at the hole, along the load", peak, 3.0,
                  "analytic", tolerance, "Kirsch; centres, extrapolated to the edge: second order")
    for n in (8, 16):
        yield at_least(f"{n} x {n} over {2 * n} x {2 * n}: error at all centres, mean square",
                       errors[n] / errors[2 * n], 3.4, "second order, a factor of 4", "analytic")
    yield Row("32 x 32: mean square of the von Mises stress off by", errors[32], 0.0, "analytic",
              0.003, "second order (measured 8e-4)", scale=1.0)


def roof_stress(n):
    """Largest von Mises stress over the thickness at the middle of the free edge, and at the crown;
    centres, extrapolated to the edge, even in the directions across planes of symmetry."""
    model = roof_under_weight(n)
    top = stresses(model, solve_linear(model).state).von_mises.max(axis=1).reshape(n, n)
    near = 1.125 * top[0] - 0.125 * top[1]  # a parabola, even across x = 0
    edge = np.dot((1.875, -1.25, 0.375), near[[-1, -2, -3]])
    return edge, 1.125 * near[0] - 0.125 * near[1]


FINE = 64
"""Elements along an edge of the mesh that stands for the limit."""


def run_roof():
    limit = roof_stress(FINE)
    for n, tolerance in ((8, 0.1), (16, 0.01), (32, 0.003)):
        for where, value, fine in zip(("middle of the free edge", "crown"), roof_stress(n), limit):
            yield Row(f"{n} x {n}: {where}", value, fine, "converged", tolerance,
                      f"{FINE} x {FINE} of our own: no published stress is at hand")


CASES = (
    Case("plate-with-hole", "stresses", "von Mises stresses converge with the mesh, to a stress "
         "concentration of 3", "Kirsch 1898", "a quarter of a plate, hole of radius 1, tension 1 "
         "along x, cut at radius 4 with the exact tractions; t = 1, E = 1000, nu = 0.3",
         run_plate_with_hole),
    Case("roof-stress", "stresses", "von Mises stresses of a roof under its weight converge with "
         "the mesh", MACNEAL + " (displacement); stresses: own", "the Scordelis-Lo roof, case "
         "scordelis-lo", run_roof),
)
