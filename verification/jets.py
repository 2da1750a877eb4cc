"""Second-order automatic differentiation: an oracle for gradients and Hessians.

A ``Jet`` carries the value of a scalar, its gradient and its Hessian with respect to a fixed
set of variables; arithmetic follows the product and chain rules exactly, so the derivatives are
right to rounding error.  Nothing here is shared with the solver.
"""

import numpy as np


class Jet:
    """Value, gradient (n,) and Hessian (n, n) of a scalar function of n variables."""

    __slots__ = ("value", "gradient", "hessian")

    def __init__(self, value, gradient, hessian):
        self.value, self.gradient, self.hessian = value, gradient, hessian

    @staticmethod
    def variables(values):
        """Object array of independent variables at ``values``."""
        n = len(values)
        return np.array([Jet(float(v), np.eye(n)[i], np.zeros((n, n)))
                         for i, v in enumerate(values)], dtype=object)

    def chain(self, value, first, second):
        """The jet of g(self) from g, g' and g''."""
        outer = np.outer(self.gradient, self.gradient)
        return Jet(value, first * self.gradient, first * self.hessian + second * outer)

    def __add__(self, other):
        if isinstance(other, Jet):
            return Jet(self.value + other.value, self.gradient + other.gradient,
                       self.hessian + other.hessian)
        return Jet(self.value + other, self.gradient, self.hessian)

    def __mul__(self, other):
        if isinstance(other, Jet):
            cross = np.outer(self.gradient, other.gradient)
            return Jet(self.value * other.value,
                       self.value * other.gradient + other.value * self.gradient,
                       self.value * other.hessian + other.value * self.hessian + cross + cross.T)
        return Jet(self.value * other, self.gradient * other, self.hessian * other)

    __radd__, __rmul__ = __add__, __mul__

    def __neg__(self):
        return self * -1.0

    def __sub__(self, other):
        return self + -other

    def __rsub__(self, other):
        return -self + other

    def __truediv__(self, other):
        if isinstance(other, Jet):
            v = other.value
            return self * other.chain(1.0 / v, -1.0 / v**2, 2.0 / v**3)
        return self * (1.0 / other)

    def sqrt(self):
        root = np.sqrt(self.value)
        return self.chain(root, 0.5 / root, -0.25 / root**3)


def norm(vector):
    """Euclidean norm of an object array of jets (or of floats)."""
    square = sum(component * component for component in vector)
    return square.sqrt() if isinstance(square, Jet) else np.sqrt(square)


def cross(a, b):
    """Cross product of object arrays."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                     a[0] * b[1] - a[1] * b[0]], dtype=object)
