"""Oracle: the characteristic polynomial det(lambda A - M_A^T M_B^-T B M_B^-1 M_A) of two ellipsoids, from determinants to 50 digits, and
the number of its negative roots by Sturm's sequence with remainders as in the textbook. Only mpmath.
"""

from itertools import pairwise

import mpmath
from mpmath import mpf

fifty_digits = mpmath.workdps(50)
_POINTS = (-2, -1, 0, 1, 2)
with mpmath.workdps(50):
    _INTERPOLATE = mpmath.matrix([[mpf(p) ** power for power in (4, 3, 2, 1, 0)] for p in _POINTS]) ** -1


def affine_map(linear, translation):
    """(4, 4) from rows of numbers."""
    rows = [[mpf(float(entry)) for entry in (*row, shift)] for row, shift in zip(linear, translation)]
    return mpmath.matrix([*rows, [0, 0, 0, 1]])


@fifty_digits
def rigid_map(quaternion, translation):
    w, x, y, z = (mpf(float(c)) for c in quaternion)
    norm = mpmath.sqrt(w * w + x * x + y * y + z * z)
    w, x, y, z = w / norm, x / norm, y / norm, z / norm
    rotation = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
    return mpmath.matrix([[*row, mpf(float(shift))] for row, shift in zip(rotation, translation)] + [[0, 0, 0, 1]])


@fifty_digits
def characteristic_polynomial(axes_a, map_a, axes_b, map_b):
    """Five coefficients, highest power first."""
    canonical_a, canonical_b = (mpmath.diag([1 / mpf(float(a)) ** 2 for a in axes] + [-1]) for axes in (axes_a, axes_b))
    relative = map_b**-1 * map_a
    b = relative.T * canonical_b * relative
    return list(_INTERPOLATE * mpmath.matrix([mpmath.det(p * canonical_a - b) for p in _POINTS]))


def _remainder(p, q):
    p = list(p)
    while len(p) >= len(q):
        factor = p[0] / q[0]
        p = [x - factor * y for x, y in zip(p, q + [0] * (len(p) - len(q)))][1:]
    return p


@fifty_digits
def distinct_negative_roots(coefficients):
    """Sign changes of Sturm's sequence at minus infinity less those at 0. Coefficients below 1e-30 of the largest count as 0."""
    degree = len(coefficients) - 1
    unit = abs(coefficients[-1] / coefficients[0]) ** (mpf(1) / degree)                     # roots of size about 1
    p = [c * unit ** (degree - k) / (coefficients[0] * unit**degree) for k, c in enumerate(coefficients)]
    sequence = [p, [c * (degree - k) for k, c in enumerate(p[:-1])]]
    while len(sequence[-1]) > 1:
        remainder = [-c for c in _remainder(sequence[-2], sequence[-1])]
        while remainder and abs(remainder[0]) < mpf(10) ** -30:
            remainder = remainder[1:]
        if not remainder:
            break
        largest = max(abs(c) for c in remainder)
        sequence.append([c / largest for c in remainder])

    def changes(signs):
        signs = [s for s in signs if s != 0]
        return sum(s != t for s, t in pairwise(signs))

    return (changes([mpmath.sign(q[0]) * (-1) ** (len(q) - 1) for q in sequence]) - changes([mpmath.sign(q[-1]) for q in sequence]))
