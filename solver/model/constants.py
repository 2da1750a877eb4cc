"""Constants of the four-node shell element: everything that does not change while it moves.

Paper section 2 (strains, Eqs. 15-17) and section 3 (mass, Eqs. 38-41).  The kernels in
``kernels.element`` read these arrays; no loop over Gauss points is left at run time.
Entity axis first, ``(n_elem, ...)``, or groups of ``WIDTH`` elements side by side.
"""

from typing import NamedTuple

import numpy as np

from ..kernels.lanes import WIDTH, zeros

GAUSS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) / np.sqrt(3.0)
CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
SHEAR_CORRECTION = 5.0 / 6.0
MEMBRANE_FIELDS = ("stress", "strain", "compatible")
SHEAR_FIELDS = ("mitc4", "compatible")

BLOCK = 2048
"""Elements whose constants are computed at a time: what is needed on the way fits into the cache of
a processor (measured: twice as fast as all 100 000 at once), and takes no memory to speak of."""


def side_by_side(array):
    """``(n_elem, ...)`` as groups of ``WIDTH`` elements, the last one repeated to fill the last
    group: ``(n_groups, ..., WIDTH)``, as ``kernels.lanes`` takes them."""
    missing = -len(array) % WIDTH
    filled = np.concatenate([array, np.repeat(array[-1:], missing, axis=0)])
    grouped = filled.reshape(-1, WIDTH, *array.shape[1:])
    result = zeros((len(grouped), *array.shape[1:]))
    result[:] = np.moveaxis(grouped, 1, -1)
    return result


def apart(groups, n_elem):
    """The opposite of ``side_by_side``: ``(n_elem, ...)``."""
    return np.moveaxis(groups, -1, 1).reshape(-1, *groups.shape[1:-1])[:n_elem]


def shape_functions(point):
    """Bilinear ``N`` (4,) and their natural derivatives (2, 4) at ``point`` = (xi, eta)."""
    xi, eta = point
    n_xi = 1.0 + CORNERS[:, 0] * xi
    n_eta = 1.0 + CORNERS[:, 1] * eta
    derivatives = np.array([CORNERS[:, 0] * n_eta, n_xi * CORNERS[:, 1]])
    return 0.25 * n_xi * n_eta, 0.25 * derivatives


def local_frames(corners):
    """Local frames R of Eq. (1), rows e_x, e_y, e_z; ``corners`` (n_elem, 4, 3).  Analytic, so that
    complex steps go through."""
    c_13 = _unit(corners[:, 2] - corners[:, 0])
    c_24 = _unit(corners[:, 3] - corners[:, 1])
    e_x, e_y = _unit(c_13 - c_24), _unit(c_13 + c_24)
    return np.stack([e_x, e_y, np.cross(e_x, e_y)], axis=1)


STEEP = 0.02
"""Sine of the angle (1 degree) to the normal below which a direction gives an element no axis."""


def in_surface(corners, directions):
    """Directions (n_elem, 3) in the initial axes x, y of each element: unit vectors (n_elem, 2),
    and which of them are none, (n_elem,), as they stand on it or are zero."""
    seen = np.einsum("eac,ec->ea", local_frames(corners)[:, :2], directions)
    size = np.linalg.norm(seen, axis=1)
    steep = size <= STEEP * np.linalg.norm(directions, axis=1)
    return seen / np.where(steep, 1.0, size)[:, None], steep


class Law(NamedTuple):
    """Elasticity of sections, in the local axes of their elements.

    ``n = A eps + B chi - n_T``, ``m = B eps + D chi - m_T``, ``q = S gamma``, with A^-1 taken out:
    ``eps = A^-1 n - K chi + A^-1 n_T``, ``m = K^T n + D' (chi - chi_T)``, where
    ``K = A^-1 B``, ``D' = D - B A^-1 B``.  Moduli are those of the homogeneous section that is as
    stiff: plates of one material have their own, bit for bit.

    Attributes:
        thickness: (n,) h [m].
        membrane: (n, 3, 3) A/h [Pa].
        bending: (n, 3, 3) 12 D'/h^3 [Pa].
        modulus: (n,) of transverse shear [N/m].
        shear: (n, 2, 2) S over the modulus.
        gyration: (n,) rotary inertia over mass [m^2].
        coupling: (n, 3, 3) K [m]; None where B = 0.
        strain: (n, 3) A^-1 n_T, free of forces without curvature; None without heat.
        curvature: (n, 3) chi_T [1/m]; None without heat.
        arm: (n,) height of the mass centre above the surface of the nodes [m]; None where it lies
            there.
    """

    thickness: np.ndarray
    membrane: np.ndarray
    bending: np.ndarray
    modulus: np.ndarray
    shear: np.ndarray
    gyration: np.ndarray
    coupling: np.ndarray = None
    strain: np.ndarray = None
    curvature: np.ndarray = None
    arm: np.ndarray = None

    def of(self, part):
        """The law of some elements."""
        return Law(*(None if values is None else values[part] for values in self))


def isotropic(thickness, youngs, poisson):
    """``Law`` of plates of one material; h [m], E [Pa] and nu are (n,)."""
    D = _plane_stress(youngs, poisson)
    modulus = SHEAR_CORRECTION * 0.5 * youngs / (1.0 + poisson) * thickness
    return Law(thickness, D, D, modulus, np.broadcast_to(np.eye(2), (len(D), 2, 2)),
               thickness**2 / 12.0)


def element_constants(corners, normals, law, density, *, membrane, shear):
    """Arrays of ``arguments.Elements`` (without connectivity) from the initial configuration.

    Args:
        corners: (n_elem, 4, 3) initial vertex positions [m].
        normals: (n_elem, 4, 3) initial unit normals at the vertices, Eq. (14).
        law: ``Law``; one with a coupling or heat takes the membrane field ``stress``.
        density: (n_elem,) rho [kg/m^3].
        membrane: assumed membrane field, one of ``MEMBRANE_FIELDS``.
        shear: transverse shear field, one of ``SHEAR_FIELDS``.

    Returns:
        dict of y0, r0, l, Q, k_b, mass, rotary; ``coupling`` and ``eccentric`` of a law that has
        them.
    """
    found = {}
    for first in range(0, len(corners), BLOCK):
        part = slice(first, first + BLOCK)
        block = _block_constants(corners[part], normals[part], law.of(part), density[part],
                                 membrane, shear)
        for name, values in block.items():
            if first == 0:
                found[name] = np.empty((len(corners), *values.shape[1:]))
            found[name][part] = values
    return found


def _block_constants(corners, normals, law, density, membrane, shear):
    """``element_constants`` of a few elements."""
    rotation = local_frames(corners)
    local = np.einsum("eab,eib->eia", rotation, corners - corners[:, :1])
    directors = np.einsum("eab,eib->eia", rotation, normals)
    points = [_gauss_point(local, point) for point in GAUSS]
    measures = _membrane_measures(local, points, law, membrane)
    mass = _mass(corners, law.thickness, density)
    found = {
        "y0": local[:, 1:],
        "r0": directors[:, :, :2],
        "l": measures.linear[:, :, 1:],
        "Q": measures.quadratic[:, :, 1:, 1:],
        "k_b": _bending_and_shear(local, points, law, shear),
        "mass": mass,
        "rotary": law.gyration[:, None, None] * mass,
    }
    if law.arm is not None:
        found["eccentric"] = law.arm[:, None, None] * mass
    if law.coupling is not None:
        chi = [_bending_strains(local, *at, shear)[0][:, :, 4:] for at in zip(GAUSS, points)]
        found["coupling"] = _measured(measures, [law.coupling @ values for values in chi])
    if law.strain is not None:
        found |= _heated(law, local, measures, found)
    return found


def _measured(measures, strains):
    """Measures (n_elem, n_s, ...) of strains (n_elem, 3, ...) at the Gauss points."""
    return _combined(measures.scale, sum(map(_combined, measures.tests, strains)))


def _heated(law, local, measures, found):
    """y0, r0 and l of elements whose shape without stress is another than the initial one.

    Curvatures chi_T bend an element without shear by normals ``dr_T = chi_T x`` and the deflection
    ``w_T = -x . chi_T x / 2``; in its plane the nodes move by what the measures say of the strain.
    With variables from there, ``t = t_T + t'``, the energy has its old form:
    ``l . t + 1/2 w Q w = (l + Q w_T) . t' + 1/2 w' Q w' + const``, and the constants cancel.
    """
    x, twist = local[:, :, :2], 0.5 * law.curvature[:, 2]
    chi = np.stack([np.stack([law.curvature[:, 0], twist], axis=1),
                    np.stack([twist, law.curvature[:, 1]], axis=1)], axis=1)
    tilt = x @ chi
    w = -0.5 * np.sum(x * tilt, axis=2)[:, 1:]
    l, bent = found["l"], np.einsum("eskj,ej->esk", found["Q"], w)
    left = _measured(measures, [law.strain[:, :, None]] * len(GAUSS))[:, :, 0]
    left -= np.einsum("esk,ek->es", l[..., 2] + 0.5 * bent, w)
    if "coupling" in found:
        left -= np.einsum("esk,ek->es", found["coupling"], tilt.reshape(-1, 8))
    flat = l[..., :2].reshape(*l.shape[:2], 6)
    moved = (np.linalg.pinv(flat) @ left[:, :, None]).reshape(-1, 3, 2)
    return {"y0": found["y0"] + np.concatenate([moved, w[:, :, None]], axis=2),
            "r0": found["r0"] + tilt,
            "l": np.concatenate([l[..., :2], (l[..., 2] + bent)[..., None]], axis=3)}


class Recovery(NamedTuple):
    """Stress resultants at the centres of elements: ``n = N e``, ``m = M b + C e``, ``q = S b``.

    Attributes:
        N: (n_elem, 3, n_s) of the membrane measures e [N/m / sqrt(J)].
        M: (n_elem, 3, 11) of the variables b of bending and shear [N, N/m].
        S: (n_elem, 2, 11) of the same [N/m, N/m^2].
        C: (n_elem, 3, n_s) K^T N of a ``Law`` with a coupling [N / sqrt(J)], else None.
    """

    N: np.ndarray
    M: np.ndarray
    S: np.ndarray
    C: np.ndarray = None


def recovery(corners, law, *, membrane, shear):
    """``Recovery`` by the fields that the strain energy is made of; arguments as above.

    ``m = h^3/12 D chi``, ``q = k G h gamma``, both at the centre.
    """
    rotation = local_frames(corners)
    local = np.einsum("eab,eib->eia", rotation, corners - corners[:, :1])
    points = [_gauss_point(local, point) for point in GAUSS]
    N = _membrane_measures(local, points, law, membrane).forces
    chi, gamma = _bending_strains(local, (0.0, 0.0), _gauss_point(local, (0.0, 0.0)), shear)
    D = law.bending * (law.thickness**3 / 12.0)[:, None, None]
    S = law.modulus[:, None, None] * (law.shear @ gamma)
    C = None if law.coupling is None else law.coupling.transpose(0, 2, 1) @ N
    return Recovery(N, (D @ chi)[:, :, 1:], S[:, :, 1:], C)


def jacobians(corners):
    """Determinants of Eq. (38) at the four vertices, (n_elem, 4): positive in a convex element."""
    rotation = local_frames(corners)
    local = np.einsum("eab,eib->eia", rotation, corners - corners[:, :1])
    return np.stack([np.linalg.det(_jacobian(local, shape_functions(vertex)[1]))
                     for vertex in CORNERS], axis=1)


def _unit(vectors):
    return vectors / np.sqrt(np.sum(vectors * vectors, axis=-1, keepdims=True))


def _jacobian(local, natural):
    """``d(x, y)/d(xi, eta)`` (n_elem, 2, 2) from natural derivatives (2, 4)."""
    return np.einsum("ai,eib->eab", natural, local[:, :, :2])


def _gauss_point(local, point):
    """``(N (4,), dN/d(x, y) (n_elem, 2, 4), det J (n_elem,))`` at one natural point."""
    shape, natural = shape_functions(point)
    jacobian = _jacobian(local, natural)
    cartesian = np.linalg.solve(jacobian, np.broadcast_to(natural, (len(local), 2, 4)))
    return shape, cartesian, np.linalg.det(jacobian)


def _plane_stress(youngs, poisson):
    """Plane-stress elasticity D_1 / h (n_elem, 3, 3) of Eq. (15)."""
    D = np.zeros((len(youngs), 3, 3))
    factor = youngs / (1.0 - poisson**2)
    D[:, 0, 0] = D[:, 1, 1] = factor
    D[:, 0, 1] = D[:, 1, 0] = factor * poisson
    D[:, 2, 2] = 0.5 * factor * (1.0 - poisson)
    return D


def _shallow_strain(local, cartesian):
    """Compatible membrane strain (xx, yy, xy) at a point: linear (e,3,4,3), quadratic (e,3,4,4).

    ``eps_xx = u,x + z0,x w,x + w,x^2/2`` and so on: Green-Lagrange strain of a shallow shell.
    """
    d_x, d_y = cartesian[:, 0], cartesian[:, 1]
    slope = np.einsum("eai,ei->ea", cartesian, local[:, :, 2])
    s_x, s_y = slope[:, :1], slope[:, 1:]
    linear = np.zeros((len(local), 3, 4, 3))
    linear[:, 0, :, 0] = d_x
    linear[:, 1, :, 1] = d_y
    linear[:, 2, :, 0], linear[:, 2, :, 1] = d_y, d_x
    linear[:, 0, :, 2] = s_x * d_x
    linear[:, 1, :, 2] = s_y * d_y
    linear[:, 2, :, 2] = s_x * d_y + s_y * d_x
    quadratic = np.zeros((len(local), 3, 4, 4))
    quadratic[:, 0] = d_x[:, :, None] * d_x[:, None, :]
    quadratic[:, 1] = d_y[:, :, None] * d_y[:, None, :]
    cross = d_x[:, :, None] * d_y[:, None, :]
    quadratic[:, 2] = cross + cross.transpose(0, 2, 1)
    return linear, quadratic


class _Measures(NamedTuple):
    """Membrane measures: ``linear`` (n_elem, n_s, 4, 3) and ``quadratic`` (n_elem, n_s, 4, 4) part;
    ``forces`` N (n_elem, 3, n_s) of ``n = N e`` at the centre, of ``compatible`` the mean of the
    Gauss points.  Of modes, ``tests`` at the Gauss points (n_elem, 3, 5) and ``scale``
    (n_elem, 5, 5) make measures of strains."""

    linear: np.ndarray
    quadratic: np.ndarray
    forces: np.ndarray
    tests: list = None
    scale: np.ndarray = None


def _membrane_measures(local, points, law, field):
    """Scaled membrane measures: W_membrane = 1/2 sum_s e_s^2.

    - ``stress``: five stress modes P (Pian-Sumihara); ``int h P^T eps dA`` and the flexibility
      ``int h P^T D^-1 P dA`` give W in Hellinger-Reissner form.
    - ``strain``: five strain modes E fitted to eps in the mean; on a rectangle that is sampling at
      the points (0, +-1/sqrt 3), (+-1/sqrt 3, 0) and the centre.
    - ``compatible``: eps itself at the four Gauss points (locks; kept as a wrong variant).

    Returns:
        ``_Measures``.
    """
    thickness, D = law.thickness, law.membrane
    n = len(local)
    weights = [thickness * det for _, _, det in points]
    strains = [_shallow_strain(local, cartesian) for _, cartesian, _ in points]
    if field == "compatible":
        factors = [np.linalg.cholesky(D * w[:, None, None]) for w in weights]
        linear = [_combined(c, s[0]) for c, s in zip(factors, strains)]
        quadratic = [_combined(c, s[1]) for c, s in zip(factors, strains)]
        forces = [c * (thickness / (4.0 * w))[:, None, None] for c, w in zip(factors, weights)]
        return _Measures(np.concatenate(linear, axis=1), np.concatenate(quadratic, axis=1),
                         np.concatenate(forces, axis=2))
    modes = [_five_modes(local, point, field) for point in GAUSS]
    linear, quadratic, gram = np.zeros((n, 5, 4, 3)), np.zeros((n, 5, 4, 4)), np.zeros((n, 5, 5))
    stiffness = np.zeros((n, 5, 5))
    metric = np.linalg.inv(D) if field == "stress" else np.broadcast_to(np.eye(3), D.shape)
    tests = [mode * weight[:, None, None] for mode, weight in zip(modes, weights)]
    for weighted, mode, (eps_l, eps_q) in zip(tests, modes, strains):
        linear += _combined(weighted, eps_l)
        quadratic += _combined(weighted, eps_q)
        gram += _combined(weighted, metric @ mode)
        stiffness += _combined(weighted, D @ mode)
    inverse = np.linalg.inv(gram)
    elasticity = inverse if field == "stress" else inverse @ stiffness @ inverse
    scale = np.linalg.cholesky(0.5 * (elasticity + elasticity.transpose(0, 2, 1)))
    # three modes are constant, the other two zero at the centre
    stress = (scale[:, :3] if field == "stress" else
              D @ (inverse @ np.linalg.inv(scale).transpose(0, 2, 1))[:, :3])
    return _Measures(_combined(scale, linear), _combined(scale, quadratic),
                     thickness[:, None, None] * stress, tests, scale)


def _combined(factors, values):
    """``sum_a factors[a, s] values[a, ...]``: (n_elem, s, ...) of (n_elem, a, s), (n_elem, a, ...).
    """
    n, a, *rest = values.shape
    product = factors.transpose(0, 2, 1) @ values.reshape(n, a, -1)
    return product.reshape(n, factors.shape[2], *rest)


def _five_modes(local, point, field):
    """Five-parameter membrane field (n_elem, 3, 5) on the basis of the element's centre."""
    _, natural = shape_functions((0.0, 0.0))
    basis = _jacobian(local, natural)
    if field == "strain":
        basis = np.linalg.inv(basis).transpose(0, 2, 1)
    modes = np.zeros((len(local), 3, 5))
    modes[:, 0, 0] = modes[:, 1, 1] = modes[:, 2, 2] = 1.0
    doubled_shear = 2.0 if field == "strain" else 1.0
    for column, vector, coordinate in ((3, basis[:, 0], point[1]), (4, basis[:, 1], point[0])):
        modes[:, 0, column] = vector[:, 0] ** 2 * coordinate
        modes[:, 1, column] = vector[:, 1] ** 2 * coordinate
        modes[:, 2, column] = doubled_shear * vector[:, 0] * vector[:, 1] * coordinate
    return modes


def _bending_and_shear(local, points, law, shear):
    """Constant stiffness (n_elem, 11, 11) on (w_2..w_4, dr_x1, dr_y1, ..., dr_y4)."""
    thickness, D = law.thickness, law.bending
    k = np.zeros((len(local), 12, 12))
    for point, at in zip(GAUSS, points):
        bending, gamma = _bending_strains(local, point, at, shear)
        k += _combined(bending, D @ bending * (at[2] * thickness**3 / 12.0)[:, None, None])
        k += _combined(gamma, law.shear @ gamma * (at[2] * law.modulus)[:, None, None])
    k = 0.5 * (k + k.transpose(0, 2, 1))
    return k[:, 1:, 1:]


def _bending_strains(local, point, at, shear):
    """Curvature (n_elem, 3, 12) and transverse shear (n_elem, 2, 12) of (w_1..w_4, dr_x1, ...).

    ``chi = (dr_x,x; dr_y,y; dr_x,y + dr_y,x)``, ``gamma = (w,x + dr_x; w,y + dr_y)``; shear by
    MITC4 (tying points (0, +-1) and (+-1, 0)) or, as a wrong variant, compatible.  ``at`` is
    ``_gauss_point`` of the natural ``point``.
    """
    shape, cartesian, _ = at
    chi = np.zeros((len(local), 3, 12))
    chi[:, 0, 4::2] = chi[:, 2, 5::2] = cartesian[:, 0]
    chi[:, 1, 5::2] = chi[:, 2, 4::2] = cartesian[:, 1]
    if shear == "mitc4":
        return chi, _mitc4_shear(local, point)
    gamma = np.zeros((len(local), 2, 12))
    gamma[:, :, :4] = cartesian
    gamma[:, 0, 4::2] = gamma[:, 1, 5::2] = shape
    return chi, gamma


def _mitc4_shear(local, point):
    """MITC4 transverse shear (gamma_xz, gamma_yz) at ``point``: (n_elem, 2, 12)."""
    _, natural = shape_functions(point)
    covariant = np.zeros((len(local), 2, 12))
    for axis, (tying, other) in enumerate((((0.0, 1.0), 1), ((1.0, 0.0), 0))):
        for sign in (-1.0, 1.0):
            at = (sign * tying[0], sign * tying[1])
            shape, derivative = shape_functions(at)
            tangent = np.einsum("i,eib->eb", derivative[axis], local[:, :, :2])
            weight = 0.5 * (1.0 + sign * point[other])
            covariant[:, axis, :4] += weight * derivative[axis]
            covariant[:, axis, 4::2] += weight * shape * tangent[:, :1]
            covariant[:, axis, 5::2] += weight * shape * tangent[:, 1:]
    return np.linalg.solve(_jacobian(local, natural), covariant)


def area_factors(corners, point):
    """``|x,xi x x,eta|`` (n_elem,) of the bilinear surfaces at a natural point: the true area, also
    of a warped element, by which mass, weight and surface loads are distributed [m^2]."""
    _, natural = shape_functions(point)
    tangents = np.einsum("ai,eic->aec", natural, corners)
    return np.linalg.norm(np.cross(tangents[0], tangents[1]), axis=1)


def _mass(corners, thickness, density):
    """Consistent translational mass ``rho h int N_i N_j dA``, Eqs. (38), (40a)."""
    mass = np.zeros((len(corners), 4, 4))
    for point in GAUSS:
        shape, _ = shape_functions(point)
        mass += np.einsum("i,j,e->eij", shape, shape, area_factors(corners, point))
    return mass * (density * thickness)[:, None, None]
