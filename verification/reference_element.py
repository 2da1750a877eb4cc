"""The strain energy of one element, written down once more from the paper, plainly and slowly.

Independent of the solver's decomposition: Eqs. (1)-(15) evaluated at Gauss points with the assumed
fields worked out in place.  Takes floats or ``Jet`` s.
"""

import numpy as np

from .jets import cross, norm

XI = np.array([-1.0, 1.0, 1.0, -1.0])
ETA = np.array([-1.0, -1.0, 1.0, 1.0])


def local_frame(x):
    """Rows e_x, e_y, e_z of Eqs. (3), (4) for vertices ``x`` (4, 3)."""
    c_13, c_24 = x[2] - x[0], x[3] - x[1]
    c_13, c_24 = c_13 / norm(c_13), c_24 / norm(c_24)
    e_x, e_y = c_13 - c_24, c_13 + c_24
    e_x, e_y = e_x / norm(e_x), e_y / norm(e_y)
    return np.array([e_x, e_y, cross(e_x, e_y)])


def local_variables(x, p, X, P):
    """u_L of Eqs. (6)-(10): t (4, 3) and theta - theta_0 (4, 3), node 1 subtracted first.

    Only the first two components of theta enter the printed strains.
    """
    R, R_0 = local_frame(x), local_frame(X)
    t = np.array([R @ (x[i] - x[0]) - R_0 @ (X[i] - X[0]) for i in range(4)])
    rotation = np.array([R @ p[i] - R_0 @ P[i] for i in range(4)])
    return t, rotation


def energy(x, p, X, P, thickness, youngs, poisson, membrane="stress", shear="facet"):
    """Strain energy of the configuration (x, p) with initial configuration (X, P)."""
    t, rotation = local_variables(x, p, X, P)
    R_0 = local_frame(X).astype(float)
    return local_energy(t, rotation, (X - X[0]) @ R_0.T, thickness, youngs, poisson, membrane,
                        shear, P @ R_0.T)


def local_energy(t, rotation, local, thickness, youngs, poisson, membrane="stress",
                 shear="facet", normals=None):
    """Strain energy as a function of the local variables.

    ``local`` (4, 3) holds the initial coordinates, ``normals`` (4, 3) the initial normals, which
    forms of the shear other than the facet's need; see ``_side_shear``.
    """
    u, v, w = t[:, 0], t[:, 1], t[:, 2]
    r_x, r_y = rotation[:, 0], rotation[:, 1]
    x, y, z = local[:, 0], local[:, 1], local[:, 2]
    D = youngs / (1.0 - poisson**2) * np.array(
        [[1.0, poisson, 0.0], [poisson, 1.0, 0.0], [0.0, 0.0, 0.5 * (1.0 - poisson)]])
    shear_modulus = 5.0 / 6.0 * youngs / (2.0 * (1.0 + poisson))
    total = 0.0
    points = [(a / np.sqrt(3.0), b / np.sqrt(3.0)) for a in (-1, 1) for b in (-1, 1)]
    samples = []
    for xi, eta in points:
        d_xi, d_eta = XI * (1.0 + ETA * eta) / 4.0, ETA * (1.0 + XI * xi) / 4.0
        J = np.array([[d_xi @ x, d_xi @ y], [d_eta @ x, d_eta @ y]])
        d_x, d_y = np.linalg.solve(J, np.array([d_xi, d_eta]))
        area = np.linalg.det(J)
        z_x, z_y, w_x, w_y = d_x @ z, d_y @ z, d_x @ w, d_y @ w
        strain = np.array([d_x @ u + z_x * w_x + 0.5 * w_x * w_x,
                           d_y @ v + z_y * w_y + 0.5 * w_y * w_y,
                           d_y @ u + d_x @ v + z_x * w_y + z_y * w_x + w_x * w_y])
        samples.append((xi, eta, area, strain))
        chi = np.array([d_x @ r_x, d_y @ r_y, d_y @ r_x + d_x @ r_y])
        total = total + 0.5 * area * thickness**3 / 12.0 * (chi @ (D @ chi))
        # MITC4: covariant shear w,a + r . x,a, tied at the middles of the sides
        covariant = []
        for derivative, tie in ((0, eta), (1, xi)):
            sides = []
            for side in (-1.0, 1.0):
                a, b = (0.0, side) if derivative == 0 else (side, 0.0)
                N = (1.0 + XI * a) * (1.0 + ETA * b) / 4.0
                dN = XI * (1.0 + ETA * b) / 4.0 if derivative == 0 else ETA * (1.0 + XI * a) / 4.0
                sides.append(_side_shear(shear, N, dN, t, rotation, local, normals))
            covariant.append(0.5 * (1.0 - tie) * sides[0] + 0.5 * (1.0 + tie) * sides[1])
        inverse = np.linalg.inv(J)
        gamma = [inverse[0, 0] * covariant[0] + inverse[0, 1] * covariant[1],
                 inverse[1, 0] * covariant[0] + inverse[1, 1] * covariant[1]]
        total = total + 0.5 * area * thickness * shear_modulus * (
            gamma[0] * gamma[0] + gamma[1] * gamma[1])
    return total + _membrane_energy(samples, local, D, thickness, membrane)


def _side_shear(form, N, dN, t, rotation, local, normals):
    """Covariant transverse shear at the middle of a side, from shape functions ``N``, ``dN``.

    A director shell has ``x,a . p - X,a . P``; with r_0 the initial components of the normal in the
    element's frame its linear part on a plane element is ``w,a r_0z + dr . x,a + u,a . r_0``.

    - ``facet``: the solver's ``w,a + dr . x,a``, that of a normal along e_z.
    - ``in-plane``: the facet's and ``u,a . r_0``, the in-plane displacement on a tilted normal.
    - ``projected``: ``w,a r_0z + dr . x,a``, the deflection projected on the tilted normal.
    - ``director``: complete and nonlinear; the frame drops out of it.
    """
    if form == "director":
        return (dN @ (local + t)) @ (N @ (normals + rotation)) - (dN @ local) @ (N @ normals)
    slope = dN @ t
    turned = (N @ rotation)[:2] @ (dN @ local)[:2]
    if form == "facet":
        return slope[2] + turned
    tilted = N @ normals
    if form == "in-plane":
        return slope[2] + turned + slope[:2] @ tilted[:2]
    return slope[2] * tilted[2] + turned


def _membrane_energy(samples, local, D, thickness, membrane):
    """Hellinger-Reissner (five stress modes) or five strain modes fitted in the mean."""
    g_1 = XI @ local[:, :2] / 4.0
    g_2 = ETA @ local[:, :2] / 4.0
    if membrane == "strain":
        g_1, g_2 = np.linalg.inv(np.array([g_1, g_2])).T
    factor = 2.0 if membrane == "strain" else 1.0
    modes = [np.array([
        [1.0, 0.0, 0.0, g_1[0]**2 * eta, g_2[0]**2 * xi],
        [0.0, 1.0, 0.0, g_1[1]**2 * eta, g_2[1]**2 * xi],
        [0.0, 0.0, 1.0, factor * g_1[0] * g_1[1] * eta, factor * g_2[0] * g_2[1] * xi]])
        for xi, eta, _, _ in samples]
    weights = [area * thickness for _, _, area, _ in samples]
    moments = sum(w * (m.T @ s[3]) for w, m, s in zip(weights, modes, samples))
    if membrane == "stress":
        flexibility = sum(w * m.T @ np.linalg.solve(D, m) for w, m in zip(weights, modes))
        parameters = np.linalg.inv(flexibility) @ moments
        return 0.5 * (parameters @ moments)
    gram = sum(w * m.T @ m for w, m in zip(weights, modes))
    parameters = np.linalg.inv(gram) @ moments
    stiffness = sum(w * m.T @ D @ m for w, m in zip(weights, modes))
    return 0.5 * (parameters @ (stiffness @ parameters))
