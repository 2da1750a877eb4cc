"""Calls of kernels from Python, without looking up the types of their arguments every time."""

from numba import typeof


class Call:
    """A kernel that its owner always calls with arguments of the same types and layouts: what is
    called does not look, and would take a strided array for a contiguous one.

    Numba's own call finds out the types of all arguments first, which takes longer than the kernel
    itself on a small model.  Here that is done by the first call.
    """

    def __init__(self, kernel):
        self._kernel, self._compiled = kernel, None

    def __call__(self, *arguments):
        """What the kernel returns."""
        if self._compiled is None:
            types = tuple(typeof(argument) for argument in arguments)
            self._kernel.compile(types)
            self._compiled = self._kernel.get_overload(types)
        return self._compiled(*arguments)
