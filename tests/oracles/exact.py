"""Oracle: the contact function of two ellipsoids at rest to 50 digits, straight from its definition. Only mpmath."""

from typing import NamedTuple

import mpmath
from mpmath import mp, mpf


class Exact(NamedTuple):
    contact_function: mpf
    gap: mpf
    normal: list
    pencil_parameter: mpf


def _matrix(quaternion):
    w, x, y, z = (mpf(float(c)) for c in quaternion)
    norm = mpmath.sqrt(w * w + x * x + y * y + z * z)
    w, x, y, z = w / norm, x / norm, y / norm, z / norm
    return mpmath.matrix([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                          [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                          [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def _shape(semi_axes, quaternion):
    rotation = _matrix(quaternion)
    return rotation * mpmath.diag([mpf(float(a)) ** 2 for a in semi_axes]) * rotation.T


def _form(matrix, v):
    return (v.T * matrix * v)[0]


def separation(axes_a, center_a, quaternion_a, axes_b, center_b, quaternion_b, digits=50):
    """f = max of x (1 - x) r^T Y^-1 r, Y = (1 - x) A + x B, by bisection of f'; n = Y^-1 r; gap = n.r - h_A(n) - h_B(n) for unit n."""
    with mp.workdps(digits + 10):
        a, b = _shape(axes_a, quaternion_a), _shape(axes_b, quaternion_b)
        r = mpmath.matrix([mpf(float(q)) - mpf(float(p)) for p, q in zip(center_a, center_b)])

        def direction(x):
            return mpmath.lu_solve((1 - x) * a + x * b, r)

        def slope(x):
            n = direction(x)
            return (1 - x) ** 2 * _form(a, n) - x**2 * _form(b, n)

        low, high = mpf(0), mpf(1)
        while high - low > mpf(10) ** -20 * min(high, 1 - low):
            x = (low + high) / 2
            low, high = (x, high) if slope(x) > 0 else (low, x)
        x = mpmath.findroot(slope, (low, high), solver="illinois", tol=mpf(10) ** (-2 * digits), maxsteps=60, verify=False)
        n = direction(x)
        f = x * (1 - x) * (r.T * n)[0]
        unit = n / mpmath.norm(n)
        gap = (unit.T * r)[0] - mpmath.sqrt(_form(a, unit)) - mpmath.sqrt(_form(b, unit))
        return Exact(f, gap, list(unit), x)
