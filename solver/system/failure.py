"""How the solver says within that something failed; users see ``errors``."""


class NotConverged(ArithmeticError):
    """An iterate, an iteration or a factorization failed, with the reason; a step may be halved."""


class SingularMatrix(NotConverged):
    """A pivot is zero or not finite."""
