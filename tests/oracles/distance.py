"""Oracle: distance of two disjoint ellipsoids, by projecting a point from one to the other and back. Only numpy.

Every iterate is the distance between a point of A and a point of B: an upper bound of the distance, whatever the convergence.
"""

import numpy as np


def nearest_point(axes, center, point):
    """The point of an ellipsoid nearest to `point`; axes: semi-axis vectors as columns (3, 3)."""
    lengths = np.linalg.norm(axes, axis=0)
    directions = axes / lengths
    y = directions.T @ (point - center)
    if ((y / lengths) ** 2).sum() <= 1:
        return point
    low, high = 0.0, np.linalg.norm(lengths * y)
    for _ in range(200):                            # x_i = a_i^2 y_i / (a_i^2 + s) lies on the surface for one s > 0
        s = 0.5 * (low + high)
        outside = ((lengths * y / (lengths**2 + s)) ** 2).sum() > 1
        low, high = (s, high) if outside else (low, s)
    return center + directions @ (lengths**2 * y / (lengths**2 + high))


def distance(axes_a, center_a, axes_b, center_b, rounds=400):
    """-> distance from above, point of A, point of B."""
    on_b = np.asarray(center_b, dtype=float)
    for _ in range(rounds):
        on_a = nearest_point(axes_a, center_a, on_b)
        on_b = nearest_point(axes_b, center_b, on_a)
    return np.linalg.norm(on_b - on_a), on_a, on_b
