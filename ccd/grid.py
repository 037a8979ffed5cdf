"""The CCD equation of two moving ellipsoids as numbers (paper, Sec. 3.1): F(u, t) in Bernstein form in u and in t.

F = u (1 - u) N(u, t) - D(u, t), eq. (23): D = det M and N = r^T adj(M) r of M = u X_A + (1 - u) X_B, times their common denominator. D is
cubic in u and N quadratic; kernels hold them as a *grid* (8, n + 1): rows 0 to 6 are the coefficients d0 ... d3 of D and n0 ... n2
of N in u (Bernstein), each a polynomial of time on [0, 1] (weighted coefficients, bernstein.py); row 7 makes control points of these.
"""

from math import sqrt

import numpy as np

from ccd.bernstein import binomials, elevate, set_product, value
from ccd.compiling import kernel
from ccd.motion.tensors import add_row, adjugate, clear, six
from ccd.separation import normal
from ccd.vectors import add_scaled, scale, subtract


def empty_work(n):
    """Working space for `fill_grid` with n + 1 coefficients."""
    return np.empty((n + 1, 15)), np.empty((4, n + 1))


def empty_grid(degree):
    """Space for a grid, with its last row."""
    grid = np.empty((8, degree + 1))
    grid[7] = 1 / binomials(degree)
    return grid


def degrees(a, b):
    """Degrees in t of r's numerator, and of d0 ... d3 and n0 ... n2, for the Tensors of two bodies."""
    qa, pa, deta, mua, va, patha = (x.shape[0] - 1 for x in a)
    qb, pb, detb, mub, vb, pathb = (x.shape[0] - 1 for x in b)
    r = max(pathb + va, patha + vb)
    return r, (detb + mua + 2 * va, qa + pb + 2 * (va + vb), pa + qb + 2 * (va + vb), deta + mub + 2 * vb,
               pb + mua + 2 * r, qa + qb + 2 * r, pa + mub + 2 * r)


@kernel
def _put(row, p, q):
    """A row of the grid: p q, raised to the degree of the grid."""
    set_product(row, 1.0, p, q)
    elevate(row, len(p) + len(q) - 2, len(row) - 1)


@kernel
def _double_dot(m, k):
    return m[0] * k[0] + m[1] * k[1] + m[2] * k[2] + 2 * (m[3] * k[3] + m[4] * k[4] + m[5] * k[5])


@kernel
def _put_trace(row, a, b, factor, work):
    """A row of the grid: the trace of the product of two symmetric matrices, times a factor."""
    trace = work[:a.shape[0] + b.shape[0] - 1]
    for i in range(len(trace)):
        trace[i] = 0.0
    for i in range(a.shape[0]):
        m = six(a, i)
        for j in range(b.shape[0]):
            trace[i + j] += _double_dot(m, six(b, j))
    _put(row, trace, factor)


@kernel
def _distance(r, a, b, term):
    """r: the numerator of the vector from the centre of A to that of B, over v_A v_B. (its degree + 1, 3)"""
    degree = r.shape[0] - 1
    for k in range(3):
        out = r[:, k]
        set_product(out, 1.0, b.path[:, k], a.v)
        elevate(out, b.path.shape[0] + len(a.v) - 2, degree)
        set_product(term, -1.0, a.path[:, k], b.v)
        elevate(term, a.path.shape[0] + len(b.v) - 2, degree)
        for i in range(degree + 1):
            out[i] += term[i]


@kernel
def fill_grid(grid, a, b, degree_r, work):
    """The grid from the Tensors of both bodies, eq. (23). work: two arrays, of (n + 1, 15) and (4, n + 1)."""
    tall, wide = work
    r, squares, mixed = tall[:degree_r + 1, :3], tall[:2 * degree_r + 1, 3:9], tall[:a.q.shape[0] + b.q.shape[0] - 1, 9:15]
    _distance(r, a, b, wide[0])
    clear(squares)
    for i in range(degree_r + 1):
        for j in range(degree_r + 1):
            add_row(squares, i + j, (r[i, 0] * r[j, 0], r[i, 1] * r[j, 1], r[i, 2] * r[j, 2],
                                     r[i, 0] * r[j, 1], r[i, 0] * r[j, 2], r[i, 1] * r[j, 2]))
    clear(mixed)
    for i in range(a.q.shape[0]):
        m = six(a.q, i)
        for j in range(b.q.shape[0]):
            k = six(b.q, j)
            add_row(mixed, i + j, adjugate(m, k))
            add_row(mixed, i + j, adjugate(k, m))
    _put_trace(grid[4], b.p, squares, a.mu, wide[0])
    _put_trace(grid[6], a.p, squares, b.mu, wide[0])
    half = wide[1, :1]
    half[0] = 0.5
    _put_trace(grid[5], mixed, squares, half, wide[0])
    va, vb, both = wide[1, :2 * len(a.v) - 1], wide[2, :2 * len(b.v) - 1], wide[3, :2 * len(a.v) + 2 * len(b.v) - 3]
    set_product(va, 1.0, a.v, a.v)
    set_product(vb, 1.0, b.v, b.v)
    set_product(both, 1.0 / 3.0, va, vb)
    _put_trace(grid[1], a.q, b.p, both, wide[0])
    _put_trace(grid[2], a.p, b.q, both, wide[0])
    scaled = wide[0, :len(va) + len(a.mu) - 1]
    set_product(scaled, 1.0, va, a.mu)
    _put(grid[0], scaled, b.det)
    scaled = wide[0, :len(vb) + len(b.mu) - 1]
    set_product(scaled, 1.0, vb, b.mu)
    _put(grid[3], scaled, a.det)


@kernel
def coefficients(grid, t):
    """The Bernstein coefficients in u of D and of N at one time in [0, 1], up to a common positive factor: what `maximise` takes."""
    d0 = d1 = d2 = d3 = n0 = n1 = n2 = 0.0
    n = grid.shape[1] - 1
    forward = t <= 0.5
    ratio = t / (1 - t) if forward else (1 - t) / t
    for k in range(n + 1):                                  # Horner's rule
        i = n - k if forward else k
        d0, d1, d2, d3 = d0 * ratio + grid[0, i], d1 * ratio + grid[1, i], d2 * ratio + grid[2, i], d3 * ratio + grid[3, i]
        n0, n1, n2 = n0 * ratio + grid[4, i], n1 * ratio + grid[5, i], n2 * ratio + grid[6, i]
    return (d0, d1, d2, d3), (n0, n1, n2)


@kernel
def held(grid, u, level, out):
    """out: F(u, t) for one u as a polynomial of time, control points; with D times `level`."""
    w = 1 - u
    under = u * w
    n0, n1, n2 = under * w * w, 2 * under * under, under * u * u
    d0, d1, d2, d3 = level * w * w * w, level * 3 * under * w, level * 3 * under * u, level * u * u * u
    for i in range(len(out)):
        out[i] = (n0 * grid[4, i] + n1 * grid[5, i] + n2 * grid[6, i]
                  - (d0 * grid[0, i] + d1 * grid[1, i] + d2 * grid[2, i] + d3 * grid[3, i])) * grid[7, i]


@kernel
def quartic(grid, level, out):
    """out (5, n + 1): the control points of F in u and t; with D times `level`."""
    for i in range(grid.shape[1]):
        w = grid[7, i]
        out[0, i] = -level * w * grid[0, i]
        out[1, i] = 0.25 * w * (grid[4, i] - level * (grid[0, i] + 3 * grid[1, i]))
        out[2, i] = w * (2 * grid[5, i] - level * 3 * (grid[1, i] + grid[2, i])) / 6.0
        out[3, i] = 0.25 * w * (grid[6, i] - level * (3 * grid[2, i] + grid[3, i]))
        out[4, i] = -level * w * grid[3, i]


@kernel
def condition(grid, work):
    """How many times larger than itself D + N, at u = 1/2, is when every term of its sum counts as positive: the largest over time.

    Times the rounding of one operation it bounds the relative error of f. work: (2, n + 1).
    """
    n = grid.shape[1] - 1
    plain, absolute = work[0, :n + 1], work[1, :n + 1]
    for i in range(n + 1):
        plain[i] = 0.125 * (grid[0, i] + 3 * grid[1, i] + 3 * grid[2, i] + grid[3, i]) + 0.0625 * (grid[4, i] + 2 * grid[5, i] + grid[6, i])
        absolute[i] = (0.125 * (abs(grid[0, i]) + 3 * abs(grid[1, i]) + 3 * abs(grid[2, i]) + abs(grid[3, i]))
                       + 0.0625 * (abs(grid[4, i]) + 2 * abs(grid[5, i]) + abs(grid[6, i])))
    worst = 1.0
    for i in range(1, n):
        t = i / n
        worst = max(worst, value(absolute, t) / abs(value(plain, t)))
    return worst


@kernel
def _matrix_at(rows, mu, t):
    return (value(rows[:, 0], t) / mu, value(rows[:, 1], t) / mu, value(rows[:, 2], t) / mu,
            value(rows[:, 3], t) / mu, value(rows[:, 4], t) / mu, value(rows[:, 5], t) / mu)


@kernel
def _point_at(rows, v, t):
    return (value(rows[:, 0], t) / v, value(rows[:, 1], t) / v, value(rows[:, 2], t) / v)


@kernel
def _support_point(x, n):
    """The point of the surface, relative to the centre, whose outward normal is n, from the shape matrix."""
    along = (x[0] * n[0] + x[3] * n[1] + x[4] * n[2], x[3] * n[0] + x[1] * n[1] + x[5] * n[2], x[4] * n[0] + x[5] * n[1] + x[2] * n[2])
    return scale(1.0 / sqrt(along[0] * n[0] + along[1] * n[1] + along[2] * n[2]), along)


@kernel
def touch(a, b, t, u):
    """Contact point and unit normal, from A to B, of bodies that touch at one time in [0, 1], from their Tensors."""
    x_a, x_b = _matrix_at(a.q, value(a.mu, t), t), _matrix_at(b.q, value(b.mu, t), t)
    c_a, c_b = _point_at(a.path, value(a.v, t), t), _point_at(b.path, value(b.v, t), t)
    n = normal(x_a, x_b, subtract(c_b, c_a), 1 - u)
    middle = add_scaled(c_a, 0.5, subtract(c_b, c_a))
    return add_scaled(middle, 0.5, subtract(_support_point(x_a, n), _support_point(x_b, n))), n
