"""Oracle: det((u - 1) A(t) - u B(t)) and the contact function of two ellipsoids under rational motions, to 50 digits. Only mpmath.

A motion here is a function from a time (mpf) to its matrix (4, 4); `rigid` and `affine` make it from coefficients, lowest power first.
"""

import mpmath
from mpmath import mp, mpf

DIGITS = 50


def _at(coefficients, t):
    return mpmath.polyval([mpf(float(c)) for c in reversed(list(coefficients))], t)


def rigid(rotation, translation, denominator=(1.0,)):
    def matrix(t):
        w, x, y, z = (_at(row, t) for row in rotation)
        e, v = w * w + x * x + y * y + z * z, _at(denominator, t)
        turned = [[w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
                  [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
                  [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z]]
        return mpmath.matrix([[*(entry / e for entry in row), _at(shift, t) / v] for row, shift in zip(turned, translation)]
                             + [[0, 0, 0, 1]])
    return matrix


def affine(linear, translation, denominator=(1.0,)):
    def matrix(t):
        d = _at(denominator, t)
        return mpmath.matrix([[*(_at(entry, t) / d for entry in row), _at(shift, t) / d] for row, shift in zip(linear, translation)]
                             + [[0, 0, 0, 1]])
    return matrix


def quadric(semi_axes, matrix):
    inverse = matrix**-1
    return inverse.T * mpmath.diag([1 / mpf(float(a)) ** 2 for a in semi_axes] + [-1]) * inverse


def determinant(axes_a, motion_a, axes_b, motion_b, u, t):
    with mp.workdps(DIGITS):
        u, t = mpf(float(u)), mpf(t)
        return mpmath.det((u - 1) * quadric(axes_a, motion_a(t)) - u * quadric(axes_b, motion_b(t)))


def contact_function(axes_a, motion_a, axes_b, motion_b, t):
    """f = max over x of x (1 - x) r^T ((1 - x) X_A + x X_B)^-1 r. -> f"""
    m_a, m_b = motion_a(t), motion_b(t)
    s_a, s_b = (m[:3, :3] * mpmath.diag([mpf(float(x)) for x in axes]) for m, axes in ((m_a, axes_a), (m_b, axes_b)))
    x_a, x_b, r = s_a * s_a.T, s_b * s_b.T, m_b[:3, 3] - m_a[:3, 3]

    def slope(x):
        n = mpmath.lu_solve((1 - x) * x_a + x * x_b, r)
        return (1 - x) ** 2 * (n.T * x_a * n)[0] - x**2 * (n.T * x_b * n)[0]

    low, high = mpf(0), mpf(1)
    while high - low > mpf(10) ** -8 * min(high, 1 - low):
        x = (low + high) / 2
        low, high = (x, high) if slope(x) > 0 else (low, x)
    x = mpmath.findroot(slope, (low, high), solver="anderson", tol=mpf(10) ** -60, maxsteps=30, verify=False)
    return x * (1 - x) * (r.T * mpmath.lu_solve((1 - x) * x_a + x * x_b, r))[0]


def changes_at(axes_a, motion_a, axes_b, motion_b, time, error):
    """Whether f is on different sides of 1 at time - error and time + error."""
    with mp.workdps(DIGITS):
        before, after = (contact_function(axes_a, motion_a, axes_b, motion_b, mpf(float(time)) + s * mpf(error)) - 1 for s in (-1, 1))
        return before * after < 0
