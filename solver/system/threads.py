"""Assembly by several threads, the same to the last bit as by one.

Every node belongs to one thread.  It works on all elements there, in their order, and adds what
they give to its own nodes; elements between the nodes of two threads are worked on by both.
"""

from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ..kernels.arguments import AFTER, BEFORE, DONE, ELEMENTS, Share
from ..kernels.lanes import WIDTH

LEAST_NODES = 1000
"""Nodes of a thread below which it is not worth its while (measured: 0.1 ms to hand out the parts
of an assembly, which takes 1 ms for that many)."""

MOST_TWICE = 1.3
"""Groups of elements that threads work on together, over those there are, beyond which elements are
numbered too much at random for several."""


def whole(model):
    """``Share`` of one thread, which assembles all."""
    n = len(model.nodes)
    return Share(0, n, np.arange(-(-len(model.quads) // WIDTH)), np.zeros(0, dtype=bool))


def shares(model, numbering, threads):
    """A ``Share`` for each of at most so many threads; none where one alone is as fast."""
    n, quads = len(model.nodes), model.quads
    threads = min(threads, n // LEAST_NODES)
    if threads < 2:
        return []
    ranks = np.empty(n, dtype=np.int64)
    ranks[np.argsort(numbering.start)] = np.arange(n)
    owner = ranks * threads // n
    found = []
    for k in range(threads):
        owned = owner == k
        groups = np.unique(np.flatnonzero(owned[quads].any(axis=1)) // WIDTH)
        found.append(Share(k * n // threads, (k + 1) * n // threads, groups, owned))
    twice = sum(len(share.groups) for share in found) / -(-len(quads) // WIDTH)
    return found if twice <= MOST_TWICE else []


class Team:
    """Threads with a ``Share`` each, the one that calls among them."""

    def __init__(self, shares):
        self._shares, self._others = shares, ThreadPoolExecutor(len(shares) - 1)

    def run(self, assemble):
        """Assemble by ``assemble(share, part)``, part after part; what the first that fails in one
        returns."""
        first, *rest = self._shares
        for part in (BEFORE, ELEMENTS, AFTER):
            futures = [self._others.submit(assemble, share, part) for share in rest]
            found = [assemble(first, part), *(future.result() for future in futures)]
            for lost in found:
                if lost != DONE:
                    return lost
        return DONE
