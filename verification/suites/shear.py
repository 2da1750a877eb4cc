"""Why transverse shear taken along the facet is too stiff on coarse doubly curved meshes.

In the frame of a facet that spans the angle of a curved surface the normals are tilted.  In bending
without stretching a facet can only twist: two opposite sides turn by +-theta about axes in its
plane, and their normals turn with them, by theta r_0z seen in the plane.  The shear of a director
shell, ``w,a r_0z + dr . x,a + u,a . r_0``, is zero then.  The facet's, ``w,a + dr . x,a``, is
theta (1 - r_0z), of the order theta (L/2R)^2 for sides of length L, against bending strains of the
order theta h/L: the ratio of their energies falls with L^6.

The independent element is solved with each form of the shear; the solver has the facet's only.
"""

import numpy as np

from ..case import Case, Row, at_least, small
from ..literature import HEMISPHERE, MACNEAL, MITC4_HEMISPHERE, OTHER, compare
from ..reference_shell import solve_linear
from ..shells import linear_hemisphere

LOST = {4: 0.4, 8: 0.015}


def hemisphere(n, shear):
    """Displacement of the loaded points, from the independent element with a form of the shear."""
    return linear_hemisphere(n, solve=lambda model: solve_linear(model, shear=shear))


def run_hemisphere_shear():
    rows, stiffer = [], []
    for n, lost in LOST.items():
        mitc4 = MITC4_HEMISPHERE[n]
        found = {form: hemisphere(n, form)
                 for form in ("facet", "in-plane", "projected", "director")}
        rows.append(small(f"{n} x {n}, facet shear: independent element against the solver",
                          found["facet"] - linear_hemisphere(n), 1e-9, "rounding, amplified by "
                          "the condition of thin bending", scale=found["facet"]))
        for form, what in (("facet", "facet shear"),
                           ("in-plane", "with u,x r_0 alone, no cure")):
            rows.append(at_least(f"{n} x {n}, {what}: what it lacks of MITC4",
                                 mitc4 - found[form] / HEMISPHERE, lost,
                                 "too stiff; the projected form lacks less than a fifteenth"))
        for form, what in (("projected", "w,x projected on the normal"),
                           ("director", "complete director shear")):
            rows.append(compare(f"{n} x {n}, {what}, MITC4", found[form], HEMISPHERE, mitc4, OTHER))
        stiffer.append(HEMISPHERE / found["facet"] - HEMISPHERE / found["director"])
    rows.append(Row("stiffness that the facet shear adds: order in the mesh size",
                    np.log2(stiffer[0] / stiffer[1]), 6.0, "analytic", 0.5,
                    "an estimate of energies; the coarse mesh is not yet asymptotic", scale=1.0))
    return rows


CASES = (
    Case("hemisphere-shear", "linear", "the facet shear is why coarse hemispheres are too stiff",
         MACNEAL + "; own analysis", "as hemisphere-linear, independent element with four forms of "
         "the shear", run_hemisphere_shear),
)
