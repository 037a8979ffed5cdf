"""What a moving ellipsoid puts into the CCD equation: its shape matrix, the adjugate and the determinant of that, as polynomials of time.

With X(t) the shape matrix of docs/theory.md and c(t) the centre, eq. (22):

    X = q / mu,  adj X = p / mu,  det X = det / (mu v^2),  c = path / v.

The denominators mu and v carry no factor that cancels for the motion's kind. Polynomials are weighted Bernstein coefficients
(bernstein.py), one row for each; the columns of symmetric matrices are xx, yy, zz, xy, xz, yz, those of others run row by row.
"""

from typing import NamedTuple

import numpy as np

from ccd.bernstein import from_powers, keeps_sign, set_product
from ccd.compiling import kernel

MOVES, TURN_VANISHES, DENOMINATOR_VANISHES, FLAT = 0, 1, 2, 3


class Tensors(NamedTuple):
    q: np.ndarray           # (n + 1, 6)
    p: np.ndarray           # (n + 1, 6)
    det: np.ndarray         # (n + 1,)
    mu: np.ndarray          # (n + 1,)
    v: np.ndarray           # (n + 1,)
    path: np.ndarray        # (n + 1, 3)


def empty_tensors(q, p, det, mu, v, path):
    """Space for tensors of the given degrees."""
    return Tensors(np.empty((q + 1, 6)), np.empty((p + 1, 6)), np.empty(det + 1), np.empty(mu + 1), np.empty(v + 1),
                   np.empty((path + 1, 3)))


@kernel
def six(rows, i):
    """A coefficient of a symmetric matrix."""
    return (rows[i, 0], rows[i, 1], rows[i, 2], rows[i, 3], rows[i, 4], rows[i, 5])


@kernel
def add_row(rows, i, values):
    for k in range(len(values)):
        rows[i, k] += values[k]


@kernel
def clear(rows):
    for i in range(rows.shape[0]):
        for k in range(rows.shape[1]):
            rows[i, k] = 0.0


@kernel
def _nine(rows, i):
    return (rows[i, 0], rows[i, 1], rows[i, 2], rows[i, 3], rows[i, 4], rows[i, 5], rows[i, 6], rows[i, 7], rows[i, 8])


@kernel
def _outer(s, t, weights):
    """The sum over columns k of weights[k] s_k t_k^T, of 3x3 matrices given row by row, as it adds to a symmetric matrix."""
    a, b, c = weights
    return (a * s[0] * t[0] + b * s[1] * t[1] + c * s[2] * t[2],
            a * s[3] * t[3] + b * s[4] * t[4] + c * s[5] * t[5],
            a * s[6] * t[6] + b * s[7] * t[7] + c * s[8] * t[8],
            a * s[0] * t[3] + b * s[1] * t[4] + c * s[2] * t[5],
            a * s[0] * t[6] + b * s[1] * t[7] + c * s[2] * t[8],
            a * s[3] * t[6] + b * s[4] * t[7] + c * s[5] * t[8])


@kernel
def _minors(s, t):
    """The cofactors of a 3x3 matrix, row by row, bilinear in s and t."""
    return (s[4] * t[8] - s[5] * t[7], s[5] * t[6] - s[3] * t[8], s[3] * t[7] - s[4] * t[6],
            s[7] * t[2] - s[8] * t[1], s[8] * t[0] - s[6] * t[2], s[6] * t[1] - s[7] * t[0],
            s[1] * t[5] - s[2] * t[4], s[2] * t[3] - s[0] * t[5], s[0] * t[4] - s[1] * t[3])


@kernel
def adjugate(m, k):
    """The adjugate of a symmetric matrix, bilinear in m and k: for m = k it is the adjugate, m k plus k m makes what is mixed."""
    return (m[1] * k[2] - m[5] * k[5], m[0] * k[2] - m[4] * k[4], m[0] * k[1] - m[3] * k[3],
            m[4] * k[5] - m[3] * k[2], m[3] * k[5] - m[4] * k[1], m[3] * k[4] - m[5] * k[0])


@kernel
def _turned(e, f):
    """E R of Appendix B, row by row, bilinear in the Euler parameters e and f."""
    ww, xx, yy, zz = e[0] * f[0], e[1] * f[1], e[2] * f[2], e[3] * f[3]
    xy, xz, yz, wx, wy, wz = e[1] * f[2], e[1] * f[3], e[2] * f[3], e[0] * f[1], e[0] * f[2], e[0] * f[3]
    return (ww + xx - yy - zz, 2 * (xy - wz), 2 * (xz + wy), 2 * (xy + wz), ww - xx + yy - zz, 2 * (yz - wx),
            2 * (xz - wy), 2 * (yz + wx), ww - xx - yy + zz)


@kernel
def _largest(rows):
    largest = 0.0
    for i in range(rows.shape[0]):
        for k in range(rows.shape[1]):
            largest = max(largest, abs(rows[i, k]))
    return largest


@kernel
def _columns(out, powers, span, factor):
    """Polynomials, one a row of `powers`, as columns of weighted coefficients, times a factor."""
    for k in range(out.shape[1]):
        from_powers(out[:, k], powers[k], span[0], span[1])
    for i in range(out.shape[0]):
        for k in range(out.shape[1]):
            out[i, k] *= factor


@kernel
def _translation(tensors, translation, denominator, span):
    """-> the factor that was taken out of numerator and denominator."""
    v = tensors.v
    from_powers(v, denominator, span[0], span[1])
    scale = 0.0
    for x in v:
        scale = max(scale, abs(x))
    for i in range(len(v)):
        v[i] /= scale
    _columns(tensors.path, translation, span, 1 / scale)
    return scale


@kernel
def rigid_tensors(tensors, semi_axes, motion, span, work):
    """Fill in the tensors of a rational Euclidean motion (paper, Appendix B): X = U diag(a^2) U^T / E^2 and R = U / E.

    motion: rotation (4, k + 1), translation (3, m + 1), denominator, in powers of t. work: two arrays, of at least (2 k + 1, 13) and
    (3, the larger of 2 k + 1 and 2 d + 1). -> MOVES, or TURN_VANISHES or DENOMINATOR_VANISHES for a root within the span.
    """
    rotation, translation, denominator = motion
    tall, wide = work
    _translation(tensors, translation, denominator, span)
    size = rotation.shape[1]
    e, turn, norm = tall[:size, :4], tall[:2 * size - 1, 4:], wide[0, :2 * size - 1]
    _columns(e, rotation, span, 1.0)
    _columns(e, rotation, span, 1 / _largest(e))
    clear(turn)
    for i in range(2 * size - 1):
        norm[i] = 0.0
    for i in range(size):
        e_i = (e[i, 0], e[i, 1], e[i, 2], e[i, 3])
        for j in range(size):
            e_j = (e[j, 0], e[j, 1], e[j, 2], e[j, 3])
            add_row(turn, i + j, _turned(e_i, e_j))
            norm[i + j] += e_i[0] * e_j[0] + e_i[1] * e_j[1] + e_i[2] * e_j[2] + e_i[3] * e_j[3]
    set_product(tensors.mu, 1.0, norm, norm)
    a, b, c = semi_axes[0]**2, semi_axes[1]**2, semi_axes[2]**2
    clear(tensors.q)
    clear(tensors.p)
    for i in range(2 * size - 1):
        turn_i = _nine(turn, i)
        for j in range(2 * size - 1):
            turn_j = _nine(turn, j)
            add_row(tensors.q, i + j, _outer(turn_i, turn_j, (a, b, c)))
            add_row(tensors.p, i + j, _outer(turn_i, turn_j, (b * c, a * c, a * b)))
    if not keeps_sign(norm, wide[1:]):
        return TURN_VANISHES
    squared = wide[0, :2 * len(tensors.v) - 1]
    set_product(squared, 1.0, tensors.v, tensors.v)
    set_product(tensors.det, a * b * c, tensors.mu, squared)
    return MOVES if keeps_sign(tensors.v, wide[1:]) else DENOMINATOR_VANISHES


@kernel
def affine_tensors(tensors, semi_axes, motion, span, work):
    """Fill in the tensors of a rational affine motion (paper, Appendix B): semi-axis vectors s_k = a_k L e_k / d, X = sum s_k s_k^T.

    motion: linear (9, k + 1) row by row, translation (3, m + 1), denominator d, in powers of t. work: two arrays, of at least (2 k + 1, 24)
    and (3, the larger of 3 k + 1 and 2 d + 1). -> MOVES, or DENOMINATOR_VANISHES or FLAT when d or det L has a root within the span.
    """
    linear, translation, denominator = motion
    tall, wide = work
    scale = _translation(tensors, translation, denominator, span)
    size = linear.shape[1]
    s, cofactor, square, volume = tall[:size, :9], tall[:2 * size - 1, 9:18], tall[:2 * size - 1, 18:], wide[0, :3 * size - 2]
    _columns(s, linear, span, 1 / scale)
    clear(cofactor)
    clear(square)
    for i in range(size):
        for k in range(9):
            s[i, k] *= semi_axes[k % 3]
    for i in range(3 * size - 2):
        volume[i] = 0.0
    for i in range(size):
        s_i = _nine(s, i)
        for j in range(size):
            s_j = _nine(s, j)
            add_row(cofactor, i + j, _minors(s_i, s_j))
            add_row(square, i + j, _outer(s_i, s_j, (1.0, 1.0, 1.0)))
    for i in range(size):
        for j in range(2 * size - 1):
            volume[i + j] += s[i, 0] * cofactor[j, 0] + s[i, 1] * cofactor[j, 1] + s[i, 2] * cofactor[j, 2]
    set_product(tensors.det, 1.0, volume, volume)
    clear(tensors.p)
    for i in range(2 * size - 1):
        cofactor_i = _nine(cofactor, i)
        for j in range(2 * size - 1):
            add_row(tensors.p, i + j, _outer(cofactor_i, _nine(cofactor, j), (1.0, 1.0, 1.0)))
    if not keeps_sign(volume, wide[1:]):
        return FLAT
    squared = wide[0, :2 * len(tensors.v) - 1]              # X = S / d^2, adj X = P / d^4, det X = det / d^6: all over d^4, or d^6
    set_product(squared, 1.0, tensors.v, tensors.v)
    set_product(tensors.mu, 1.0, squared, squared)
    clear(tensors.q)
    for i in range(len(squared)):
        for j in range(2 * size - 1):
            for k in range(6):
                tensors.q[i + j, k] += squared[i] * square[j, k]
    return MOVES if keeps_sign(tensors.v, wide[1:]) else DENOMINATOR_VANISHES


@kernel
def interpolated_tensors(tensors, inverses, centers, span):
    """Fill in the tensors of the affine interpolant (paper, Appendix D): X^-1 and the centre are linear in t.

    inverses: (2, 6), X^-1 at t = 0 and t = 1; centers (2, 3).
    """
    q, p = tensors.q, tensors.p
    for end in range(2):
        t = span[0] + end * span[1]
        for k in range(6):
            p[end, k] = (1 - t) * inverses[0, k] + t * inverses[1, k]
        for k in range(3):
            tensors.path[end, k] = (1 - t) * centers[0, k] + t * centers[1, k]
    clear(q)
    for i in range(4):
        tensors.mu[i] = 0.0
    for i in range(2):
        for j in range(2):
            add_row(q, i + j, adjugate(six(p, i), six(p, j)))
    for i in range(2):
        for j in range(3):
            tensors.mu[i + j] += p[i, 0] * q[j, 0] + p[i, 3] * q[j, 3] + p[i, 4] * q[j, 4]
    tensors.v[0] = 1.0
    tensors.det[0] = 1.0
