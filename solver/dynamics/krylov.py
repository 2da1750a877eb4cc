"""Corrections of Newton's iteration by products with the derivative alone (GMRES in the form of
conjugate residuals, Eisenstat, Elman and Schultz 1983)."""

import numpy as np


def minimal_residual(product, c, weights, part, most):
    """x (n,) of ``A x = c`` with ``|w (c - A x)| <= part |w c|``, as near as ``most`` products get.

    Each direction is what is left, and its product is made orthogonal to the earlier ones: with A
    near 1 few are needed.

    Args:
        product: function of x that returns ``A x``.
        c: (n,).
        weights: (n,) w of the norm, positive.
        part: see above.
        most: products at most.

    Returns:
        x, and how many products it took.
    """
    left, x = weights * c, np.zeros_like(c)
    wanted = part * np.linalg.norm(left)
    directions, images = np.empty((2, most, len(c)))
    for k in range(most):
        direction = left / weights
        image = weights * product(direction)
        shares = images[:k] @ image
        image -= shares @ images[:k]
        direction -= shares @ directions[:k]
        size = np.linalg.norm(image)
        if not size > 0.0:
            return x, k + 1
        images[k], directions[k] = image / size, direction / size
        share = images[k] @ left
        left -= share * images[k]
        x += share * directions[k]
        if np.linalg.norm(left) <= wanted:
            break
    return x, k + 1
