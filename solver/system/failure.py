"""How the solver says within that something failed; users see ``errors``."""


from contextlib import contextmanager

from ..errors import StepError


@contextmanager
def told():
    """Tell the user what failed within, where nothing can be halved any more."""
    try:
        yield
    except NotConverged as failure:
        raise StepError(str(failure)) from None


class NotConverged(ArithmeticError):
    """An iterate, an iteration or a factorization failed, with the reason; a step may be halved."""


class SingularMatrix(NotConverged):
    """A pivot is zero or not finite."""
