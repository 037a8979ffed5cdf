"""What a moving ellipsoid puts into the CCD equation: its shape matrix, the adjugate and the determinant of that, as polynomials of time.

With X(t) the shape matrix of docs/theory.md and c(t) the centre, eq. (22):

    X = q / mu,  adj X = p / mu,  det X = det / (mu v^2),  c = path / v.

The denominators mu and v carry no factor that cancels for the motion's kind. Every polynomial is an array of weighted Bernstein
coefficients (bernstein.py); symmetric matrices are six of them: xx, yy, zz, xy, xz, yz.
"""

from typing import NamedTuple

import numpy as np

from ccd.bernstein import add_product, from_powers, keeps_sign, set_product
from ccd.compiling import kernel

MOVES, TURN_VANISHES, DENOMINATOR_VANISHES, FLAT = 0, 1, 2, 3


class Tensors(NamedTuple):
    q: np.ndarray           # (6, ...)
    p: np.ndarray           # (6, ...)
    det: np.ndarray
    mu: np.ndarray
    v: np.ndarray
    path: np.ndarray        # (3, ...)


def empty_tensors(q, p, det, mu, v, path):
    """Space for tensors of the given degrees."""
    return Tensors(np.empty((6, q + 1)), np.empty((6, p + 1)), np.empty(det + 1), np.empty(mu + 1), np.empty(v + 1),
                   np.empty((3, path + 1)))


@kernel
def entry(k):
    """Row and column of the k-th entry of a symmetric matrix."""
    return (k, k) if k < 3 else (0, k - 2) if k < 5 else (1, 2)


@kernel
def _clear(rows):
    for k in range(rows.shape[0]):
        for i in range(rows.shape[1]):
            rows[k, i] = 0.0


@kernel
def _largest(rows):
    largest = 0.0
    for row in rows:
        for x in row:
            largest = max(largest, abs(x))
    return largest if largest > 0 else 1.0


@kernel
def _translation(tensors, translation, denominator, span):
    """-> the factor that was taken out of numerator and denominator."""
    start, width = span
    from_powers(tensors.v, denominator, start, width)
    scale = 0.0
    for x in tensors.v:
        scale = max(scale, abs(x))
    for i in range(len(tensors.v)):
        tensors.v[i] /= scale
    for k in range(3):
        from_powers(tensors.path[k], translation[k], start, width)
        for i in range(tensors.path.shape[1]):
            tensors.path[k, i] /= scale
    return scale


@kernel
def _add_square(out, factor, columns, k):
    """out += factor times the outer square of the k-th column."""
    for e in range(6):
        i, j = entry(e)
        add_product(out[e], factor, columns[3 * i + k], columns[3 * j + k])


@kernel
def rigid_tensors(tensors, semi_axes, motion, span, work):
    """Fill in the tensors of a rational Euclidean motion (paper, Appendix B): X = U diag(a^2) U^T / E^2 and R = U / E.

    motion: rotation (4, k + 1), translation (3, m + 1), denominator, in powers of t. work: (16, at least the larger of 2 k + 1 and
    2 d + 1). -> MOVES, or TURN_VANISHES or DENOMINATOR_VANISHES when E or the denominator has a root within the span.
    """
    rotation, translation, denominator = motion
    start, width = span
    _translation(tensors, translation, denominator, span)
    degree = rotation.shape[1] - 1
    e, norm, turn = work[:4, :degree + 1], work[4, :2 * degree + 1], work[5:14, :2 * degree + 1]
    for k in range(4):
        from_powers(e[k], rotation[k], start, width)
    largest = _largest(e)
    for k in range(4):
        for i in range(degree + 1):
            e[k, i] /= largest
    for k in range(9):                                      # U = E R, from the Euler parameters e0 ... e3
        i, j = k // 3, k % 3
        if i == j:
            set_product(turn[k], 1.0, e[0], e[0])
            for other in range(1, 4):
                add_product(turn[k], 1.0 if other == i + 1 else -1.0, e[other], e[other])
        else:
            set_product(turn[k], 2.0, e[i + 1], e[j + 1])
            add_product(turn[k], 2.0 if (i - j) % 3 == 1 else -2.0, e[0], e[6 - (i + 1) - (j + 1)])
    set_product(norm, 1.0, e[0], e[0])
    for k in range(1, 4):
        add_product(norm, 1.0, e[k], e[k])
    set_product(tensors.mu, 1.0, norm, norm)
    a, b, c = semi_axes[0]**2, semi_axes[1]**2, semi_axes[2]**2
    _clear(tensors.q)
    _clear(tensors.p)
    for k in range(3):
        _add_square(tensors.q, semi_axes[k]**2, turn, k)
        _add_square(tensors.p, (b * c, a * c, a * b)[k], turn, k)
    squared = work[0, :2 * len(tensors.v) - 1]
    set_product(squared, 1.0, tensors.v, tensors.v)
    set_product(tensors.det, a * b * c, tensors.mu, squared)
    if not keeps_sign(norm, work[14:]):
        return TURN_VANISHES
    return MOVES if keeps_sign(tensors.v, work[14:]) else DENOMINATOR_VANISHES


@kernel
def affine_tensors(tensors, semi_axes, motion, span, work):
    """Fill in the tensors of a rational affine motion (paper, Appendix B): semi-axis vectors s_k = a_k L e_k / d, X = sum s_k s_k^T.

    motion: linear (9, k + 1) row by row, translation (3, m + 1), denominator d, in powers of t. work: (20, at least the larger of
    3 k + 1 and 2 d + 1). -> MOVES, or DENOMINATOR_VANISHES or FLAT when d or det L has a root within the span.
    """
    linear, translation, denominator = motion
    start, width = span
    scale = _translation(tensors, translation, denominator, span)
    degree = linear.shape[1] - 1
    s, cofactor, volume = work[:9, :degree + 1], work[9:18, :2 * degree + 1], work[18, :3 * degree + 1]
    for k in range(9):
        from_powers(s[k], linear[k], start, width)
        for i in range(degree + 1):
            s[k, i] *= semi_axes[k % 3] / scale
    for k in range(9):
        i, j = k // 3, k % 3
        set_product(cofactor[k], 1.0, s[3 * ((i + 1) % 3) + (j + 1) % 3], s[3 * ((i + 2) % 3) + (j + 2) % 3])
        add_product(cofactor[k], -1.0, s[3 * ((i + 1) % 3) + (j + 2) % 3], s[3 * ((i + 2) % 3) + (j + 1) % 3])
    set_product(volume, 1.0, s[0], cofactor[0])
    add_product(volume, 1.0, s[1], cofactor[1])
    add_product(volume, 1.0, s[2], cofactor[2])
    set_product(tensors.det, 1.0, volume, volume)
    _clear(tensors.p)
    for k in range(3):
        _add_square(tensors.p, 1.0, cofactor, k)
    squared = work[19, :2 * len(tensors.v) - 1]             # X = S / d^2, adj X = P / d^4, det X = det / d^6: all over d^4, or d^6
    set_product(squared, 1.0, tensors.v, tensors.v)
    set_product(tensors.mu, 1.0, squared, squared)
    square = work[9, :2 * degree + 1]
    for e in range(6):
        i, j = entry(e)
        set_product(square, 1.0, s[3 * i], s[3 * j])
        add_product(square, 1.0, s[3 * i + 1], s[3 * j + 1])
        add_product(square, 1.0, s[3 * i + 2], s[3 * j + 2])
        set_product(tensors.q[e], 1.0, squared, square)
    if not keeps_sign(volume, work[:2]):
        return FLAT
    return MOVES if keeps_sign(tensors.v, work[:2]) else DENOMINATOR_VANISHES


@kernel
def interpolated_tensors(tensors, inverses, centers, span):
    """Fill in the tensors of the affine interpolant (paper, Appendix D): X^-1 and the centre are linear in t.

    inverses: (2, 6), X^-1 at t = 0 and t = 1; centers (2, 3).
    """
    start, width = span
    for end in range(2):
        t = start + end * width
        for k in range(6):
            tensors.p[k, end] = (1 - t) * inverses[0, k] + t * inverses[1, k]
        for k in range(3):
            tensors.path[k, end] = (1 - t) * centers[0, k] + t * centers[1, k]
    p, q = tensors.p, tensors.q
    for e in range(6):                                      # q = adj p
        i, j = entry(e)
        i1, i2, j1, j2 = (i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3
        set_product(q[e], 1.0, p[index(i1, j1)], p[index(i2, j2)])
        add_product(q[e], -1.0, p[index(i1, j2)], p[index(i2, j1)])
    set_product(tensors.mu, 1.0, p[0], q[0])
    add_product(tensors.mu, 1.0, p[3], q[3])
    add_product(tensors.mu, 1.0, p[4], q[4])
    tensors.v[0] = 1.0
    tensors.det[0] = 1.0


@kernel
def index(i, j):
    """Where the entry (i, j) of a symmetric matrix stands."""
    return i if i == j else i + j + 2
