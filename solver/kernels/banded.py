"""Solutions with a banded Cholesky factor for several right-hand sides side by side.

LAPACK takes them one after the other and reads the factor anew for each.
"""

from .jit import kernel
from .lanes import WIDTH, load, store, zeros


@kernel
def solve(band, rows):
    """Overwrite ``rows`` (m, n) with the solutions of ``L L^T x = b``.

    ``band`` (n, width + 1): columns of L from the diagonal down.
    """
    n, width = band.shape
    x = zeros((n,))
    for first in range(0, rows.shape[0], WIDTH):
        count = min(WIDTH, rows.shape[0] - first)
        for k in range(count):
            for j in range(n):
                x[j, k] = rows[first + k, j]
        for j in range(n):
            value = load(x, WIDTH * j) * (1.0 / band[j, 0])
            store(x, WIDTH * j, value)
            for i in range(1, min(width, n - j)):
                at = WIDTH * (j + i)
                store(x, at, load(x, at) - value * band[j, i])
        for j in range(n - 1, -1, -1):
            value, reach = load(x, WIDTH * j), min(width, n - j)
            odd = 0.0 * value  # two sums: each waits for its last product
            for i in range(1, reach - 1, 2):
                value -= load(x, WIDTH * (j + i)) * band[j, i]
                odd -= load(x, WIDTH * (j + i + 1)) * band[j, i + 1]
            if reach % 2 == 0:
                value -= load(x, WIDTH * (j + reach - 1)) * band[j, reach - 1]
            store(x, WIDTH * j, (value + odd) * (1.0 / band[j, 0]))
        for k in range(count):
            for j in range(n):
                rows[first + k, j] = x[j, k]
