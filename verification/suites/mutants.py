"""Which case catches which wrong variant."""

from functools import partial

from ..case import Case, at_least
from ..mutants import Mutant, deviating_rows

ELEMENT = (
    Mutant("shear without assumed strains", "model/model.py", 'shear: str = "mitc4"',
           'shear: str = "compatible"', ("patch", "straight-beam")),
    Mutant("membrane without assumed strains", "model/model.py", 'membrane: str = "stress"',
           'membrane: str = "compatible"', ("aspect-ratio",)),
    Mutant("five strain modes instead of stress modes", "model/model.py",
           'membrane: str = "stress"', 'membrane: str = "strain"', ("aspect-ratio",)),
    Mutant("shear correction 1 instead of 5/6", "model/constants.py",
           "SHEAR_CORRECTION = 5.0 / 6.0", "SHEAR_CORRECTION = 1.0", ("thick-beam",)),
    Mutant("coupled measures without their couples", "kernels/element.py",
           "g[k // 2, k % 2] += coupling[s, k] * e[s]", "g[k // 2, k % 2] += 0.0 * e[s]",
           ("section-derivatives",)),
    Mutant("a coupling that is not taken out of the bending", "model/laminates.py",
           "bending = D - B @ coupling", "bending = D", ("section-states",)),
    Mutant("lumped mass", "model/constants.py", "    return mass * (density * thickness)",
           "    mass = np.eye(4) * mass.sum(axis=2)[:, :, None]\n"
           "    return mass * (density * thickness)", ("rigid-body",)),
)

SCHEME = (
    Mutant("angular momentum by one sum over nodes, Eq. (50) as printed", "dynamics/simulation.py",
           'OBSERVED = {"kinetic"', 'OBSERVED = {"angular_momentum_printed": "angular_momentum", '
           '"angular_momentum": "angular_momentum_printed", "kinetic"', ("conservation",)),
    Mutant("T at the end of the step: not symmetric about its middle",
           "kernels/assembly.py",
           "move(y_0, dy, weight, y)\n        gather_vertices(p_mid,",
           "move(y_0, dy, 1.0, y)\n        gather_vertices(p_end,",
           ("conservation",)),
    Mutant("trapezoidal rule instead of the quasi scheme", "dynamics/scheme.py",
           '"quasi", choices=SCHEMES', '"newmark", choices=SCHEMES', ("conservation",)),
    Mutant("junction's tangent without the derivative of its spins", "kernels/nodes.py",
           "                value += 0.5 * dot(rate, total)\n", "                pass\n",
           ("junction-tangent",)),
    Mutant("variables in global axes", "dynamics/scheme.py", '"nodal", choices=AXES',
           '"global", choices=AXES', ("spin",)),
)

FORCE = ("        move(y_0, dy, 0.5, y)\n"
         "        discrete.force(before, after, y, dy, p, f, g, jacobian, f_x, f_p)")
"""Where the exact scheme takes local forces to the nodes."""

EXACT = (
    Mutant("T at the end of the step", "kernels/exact.py", FORCE,
           "        discrete.force(after, after, y, dy, p_1, f, g, jacobian, f_x, f_p)\n"
           "        move(y_0, dy, 0.5, y)", ("exact-conservation",)),
    Mutant("T at the mean configuration, no discrete Jacobian", "kernels/exact.py", FORCE,
           "        move(y_0, dy, 0.5, y)\n        discrete.measure(y, p, after)\n"
           "        discrete.force(after, after, y, dy, p, f, g, jacobian, f_x, f_p)",
           ("exact-conservation",)),
    Mutant("a triple product without its cubic part", "kernels/discrete.py",
           "dy[0], 0.25 * on_tau", "dy[0], 0.0 * on_tau",
           ("discrete-jacobian", "exact-conservation")),
    Mutant("strains of the end instead of their mean", "kernels/assembly.py",
           "end, start = step.strain_end + lag, step.strain_start - lag",
           "end, start = 1.0 + 0.0 * lag, 0.0 * lag", ("exact-order",)),
    Mutant("corrections by the symmetric matrix alone", "dynamics/exact.py",
           "            if slow:\n                correction, work, products",
           "            if k < 0:\n                correction, work, products",
           ("exact-conservation",)),
    Mutant("iterations that end above rounding", "dynamics/exact.py",
           "FLOOR = 1.0 / 64.0", "FLOOR = 1e18", ("exact-conservation",)),
    Mutant("lags of the dissipation of the wrong sign", "kernels/assembly.py",
           "end, start = step.strain_end + lag, step.strain_start - lag",
           "end, start = step.strain_end - lag, step.strain_start + lag", ("exact-dissipation",)),
)

JOINTS = (
    Mutant("a hinge's triple product without its cubic part", "kernels/hinges.py",
           "dp[1], 0.25 * on_tau", "dp[1], 0.0 * on_tau", ("hinge-work", "joint-conservation")),
    Mutant("a hinge's angle as its sine", "kernels/hinges.py",
           "ratio = math.atan2(sine, cosine) / sine", "ratio = 1.0", ("hinge-work",)),
    Mutant("a stop's moment from the middle of the step", "kernels/hinges.py",
           "return 0.5 * stiffness * (a * a - b * b) / (after - before)",
           "return 0.5 * stiffness * side * (a + b)", ("joint-conservation",)),
    Mutant("constraints without impulses at both ends of a step", "kernels/multipliers.py",
           "work.n[i] = _times(links.spans, work.G_1, i, rates)", "work.n[i] = 0.0",
           ("linked-conservation",)),
    Mutant("constraints' gradients at the end of the step", "kernels/multipliers.py",
           "mean[k, c] = 0.5 * (before[k, c] + after[k, c])", "mean[k, c] = after[k, c]",
           ("linked-conservation",)),
)

MODES = (
    Mutant("Coriolis forces of half their size", "modes/matrices.py", "G = 2.0 * J.T",
           "G = 1.0 * J.T", ("whirling",)),
    Mutant("centrifugal forces without their stiffness", "kernels/centrifugal.py",
           "k[i, c, j, d] = -step.stiffness", "k[i, c, j, d] = 0.0 * step.stiffness",
           ("whirling",)),
)


def run(mutants):
    rows = []
    for mutant in mutants:
        for case in mutant.killers:
            rows.append(at_least(f"{mutant.name}: rows of {case} that deviate",
                                 deviating_rows(mutant, case), 1, "the mutant must be caught"))
    return rows


CASES = (
    Case("mutants-element", "mutants", "wrong elements are caught", "own",
         "the source with one piece of text replaced", partial(run, ELEMENT), slow=True),
    Case("mutants-scheme", "mutants", "wrong schemes are caught", "own",
         "the source with one piece of text replaced", partial(run, SCHEME), slow=True),
    Case("mutants-exact", "mutants", "wrong exact schemes are caught", "own",
         "the source with one piece of text replaced", partial(run, EXACT), slow=True),
    Case("mutants-joints", "mutants", "wrong joints are caught", "own",
         "the source with one piece of text replaced", partial(run, JOINTS), slow=True),
    Case("mutants-modes", "mutants", "wrong modes are caught", "own",
         "the source with one piece of text replaced", partial(run, MODES), slow=True),
)
