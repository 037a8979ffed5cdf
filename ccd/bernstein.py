"""Polynomials in Bernstein form on [0, 1]: products, restriction to a part, convex hulls and roots (paper, Secs. 3.1 and 3.2).

Products are taken of *weighted* coefficients, binomial(n, i) c_i, because these multiply by plain convolution; the convex hull property is
that of the control points c_i themselves. Polynomials are one-dimensional arrays of length degree + 1, filled in by their caller.
"""

from functools import cache
from math import comb, inf

import numpy as np

from ccd.compiling import kernel
from ccd.tolerances import CLIPPING_STEPS, CLIPS_WELL, LOST, ROOT, VANISHING

MOST = 512                      # highest degree
RECIPROCAL = np.array([0.0] + [1 / k for k in range(1, MOST + 1)])


@cache
def binomials(n):
    """binomial(n, i) for i = 0 ... n as floats: exact up to n = 56, to the last bit beyond."""
    row = np.array([comb(n, i) for i in range(n + 1)], dtype=np.float64)
    row.flags.writeable = False
    return row


@kernel
def add_product(out, factor, p, q):
    """out += factor p q, weighted coefficients; the degree of out is the sum of the degrees."""
    for i in range(len(p)):
        weight = factor * p[i]
        for j in range(len(q)):
            out[i + j] += weight * q[j]


@kernel
def set_product(out, factor, p, q):
    """out = factor p q, weighted coefficients."""
    for i in range(len(out)):
        out[i] = 0.0
    add_product(out, factor, p, q)


@kernel
def elevate(p, degree, to):
    """Raise the degree of p in place, weighted coefficients: p ((1 - s) + s)^(to - degree)."""
    for n in range(degree, to):
        p[n + 1] = p[n]
        for i in range(n, 0, -1):
            p[i] += p[i - 1]


@kernel
def from_powers(out, powers, start, width):
    """Weighted coefficients on [start, start + width] of the polynomial sum of powers[i] t^i."""
    n = len(powers) - 1
    for i in range(n + 1):
        out[i] = powers[i]
    for i in range(n):                          # Taylor shift to `start`
        for j in range(n - 1, i - 1, -1):
            out[j] += start * out[j + 1]
    factor = 1.0
    for i in range(n + 1):
        out[i] *= factor
        factor *= width
    for i in range(n - 1, -1, -1):              # s^i is s^i ((1 - s) + s)^(n - i)
        choose = 1.0
        for j in range(1, n - i + 1):
            choose = choose * (n - i - j + 1) / j
            out[i + j] += choose * out[i]


@kernel
def value(p, s):
    """p(s) of weighted coefficients, by Horner's rule in s / (1 - s) or its inverse, whichever is not above 1."""
    n = len(p) - 1
    total, power = 0.0, 1.0
    if s <= 0.5:
        for i in range(n, -1, -1):
            total = total * (s / (1 - s)) + p[i]
        for _ in range(n):
            power *= 1 - s
    else:
        for i in range(n + 1):
            total = total * ((1 - s) / s) + p[i]
        for _ in range(n):
            power *= s
    return total * power


@kernel
def keep_right(c, s):
    """Restrict control points to [s, 1] by de Casteljau's rule."""
    n = len(c) - 1
    for k in range(n):
        for i in range(n - k):
            c[i] += s * (c[i + 1] - c[i])


@kernel
def keep_left(c, s):
    """Restrict control points to [0, s]."""
    n = len(c) - 1
    for k in range(n):
        for i in range(n, k, -1):
            c[i] = c[i - 1] + s * (c[i] - c[i - 1])


@kernel
def restrict(c, low, high):
    """Restrict control points to [low, high], in place."""
    if low > 0.0:
        keep_right(c, low)
    if high < 1.0:
        keep_left(c, (high - low) / (1 - low))


@kernel
def _part(p, low, high, c):
    """c: the control points of p restricted to [low, high]."""
    for i in range(len(c)):
        c[i] = p[i]
    restrict(c, low, high)


@kernel
def _is_positive(c):
    smallest = inf
    for x in c:
        smallest = min(smallest, x)
    return smallest > 0.0


@kernel
def hull_crossing(c, sign, from_right):
    """How far from one end, in (0, 1], the convex hull of the control points sign * c stays positive. 0: nowhere, inf: everywhere."""
    n = len(c) - 1
    first, step = (n, -1) if from_right else (0, 1)
    here, at = sign * c[first], 0
    if here <= 0.0:
        return 0.0
    while at < n:                                   # from vertex to vertex along the lower hull
        steepest, vertex = inf, n
        for i in range(at + 1, n + 1):
            slope = (sign * c[first + step * i] - here) * RECIPROCAL[i - at]
            if slope <= steepest:
                steepest, vertex = slope, i
        there = sign * c[first + step * vertex]
        if there <= 0.0:
            return (at - here / steepest) / n
        here, at = there, vertex
    return inf


@kernel
def first_root(p, c):
    """The first root in [0, 1] of a polynomial given by its control points p, by Bézier clipping. c: space for as many numbers.

    -> a bound below the root, as near as rounding lets it; inf when there is none. (After CLIPPING_STEPS: the bound reached so far.)
    The control polygon's convex hull meets zero only where a root can be, so both ends of the interval are cut off. Where that cuts
    little, because there are several roots, the left half is searched first and what lies right of it later.
    """
    low, width, fresh, largest = 0.0, 1.0, True, 0.0
    for x in p:
        largest = max(largest, abs(x))
    for _ in range(CLIPPING_STEPS):
        if fresh:
            _part(p, low, low + width, c)
            fresh = False
        left = inf if _is_positive(c) else hull_crossing(c, 1.0, False)
        if left == 0.0 or (left < inf and width <= ROOT):
            return low
        if left == inf:
            if width <= LOST and c[0] <= LOST * largest:
                return low
            low += width
            if low >= 1.0:
                return inf
            width, fresh = 1.0 - low, True
            continue
        right = 1 - hull_crossing(c, 1.0 if c[len(c) - 1] > 0 else -1.0, True)
        if right - left > CLIPS_WELL:
            right = 0.5 * (left + right)
        restrict(c, left, right)
        low = min(low + left * width, 1.0)                              # rounding could take it past the end
        width *= right - left
    return low


@kernel
def without_root_at_start(c):
    """The control points of p(s) / s, one fewer, in place; c[0], which should be 0, is taken to be."""
    n = len(c) - 1
    for i in range(n):
        c[i] = c[i + 1] * n / (i + 1)


@kernel
def control_points(p, c):
    """c: the control points of weighted coefficients p."""
    n, choose = len(p) - 1, 1.0
    for i in range(n + 1):
        c[i] = p[i] / choose
        choose = choose * (n - i) / (i + 1)


@kernel
def keeps_sign(p, work):
    """Whether a polynomial, given by weighted coefficients p, is nowhere zero in [0, 1]. work: (2, at least len(p)).

    Zero means: not above VANISHING of its largest control point.
    """
    sign = 1.0 if p[0] > 0 else -1.0
    least = most = sign * p[0]
    for x in p:
        least, most = min(least, sign * x), max(most, sign * x)
    if least > VANISHING * most:                    # weights are positive: these have the signs of the control points
        return True
    points, c = work[0, :len(p)], work[1, :len(p)]
    control_points(p, points)
    largest = 0.0
    for x in points:
        largest = max(largest, abs(x))
    low, width = 0.0, 1.0
    for _ in range(CLIPPING_STEPS):
        _part(points, low, min(low + width, 1.0), c)
        smallest = inf
        for x in c:
            smallest = min(smallest, sign * x)
        if smallest > VANISHING * largest:
            low += width
            if low >= 1.0:
                return True
            width *= 2
        elif sign * c[0] <= VANISHING * largest or width < ROOT:
            return False
        else:
            width *= 0.5
    return False
