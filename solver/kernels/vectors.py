"""Vectors of three numbers, or of three lanes."""

import math

from .jit import internal, kernel


@kernel
def dot(a, b):
    """a . b"""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def cross(a, b, c):
    """c = a x b"""
    c[0] = a[1] * b[2] - a[2] * b[1]
    c[1] = a[2] * b[0] - a[0] * b[2]
    c[2] = a[0] * b[1] - a[1] * b[0]


@internal
def adjugate(matrix, result):
    """Inverse of a symmetric (3, 3) matrix times its determinant, which is returned."""
    for a in range(3):
        cross(matrix[(a + 1) % 3], matrix[(a + 2) % 3], result[a])
    return dot(matrix[0], result[0])


@internal
def copy(a, b):
    """b = a; an assignment of slices would take a second to compile."""
    for c in range(3):
        b[c] = a[c]


@internal
def copy_frame(a, b):
    """b = a, (3, 3) each."""
    for row in range(3):
        for c in range(3):
            b[row, c] = a[row, c]


@internal
def largest(v):
    """Index of the largest component by magnitude, the first of equals."""
    best = 0
    for c in range(1, 3):
        if abs(v[c]) > abs(v[best]):
            best = c
    return best


@kernel
def along(p, triad, k):
    """p . t_k; a slice ``triad[k]`` would be counted as a reference, which takes longer."""
    return p[0] * triad[k, 0] + p[1] * triad[k, 1] + p[2] * triad[k, 2]


@internal
def rotate(angle, axis, v):
    """Rotate ``v`` by ``angle`` about the unit vector ``axis`` (Rodrigues)."""
    side_x = axis[1] * v[2] - axis[2] * v[1]
    side_y = axis[2] * v[0] - axis[0] * v[2]
    side_z = axis[0] * v[1] - axis[1] * v[0]
    cosine, sine, share = math.cos(angle), math.sin(angle), dot(axis, v)
    v[0] = cosine * v[0] + sine * side_x + (1.0 - cosine) * share * axis[0]
    v[1] = cosine * v[1] + sine * side_y + (1.0 - cosine) * share * axis[1]
    v[2] = cosine * v[2] + sine * side_z + (1.0 - cosine) * share * axis[2]


@kernel
def orthonormal(e):
    """Make rows e_y, e_z of a frame orthonormal again and complete it."""
    size = math.sqrt(dot(e[1], e[1]))
    for c in range(3):
        e[1, c] /= size
    share = dot(e[1], e[2])
    for c in range(3):
        e[2, c] -= share * e[1, c]
    size = math.sqrt(dot(e[2], e[2]))
    for c in range(3):
        e[2, c] /= size
    cross(e[1], e[2], e[0])
