"""A plane that turns with the motion, and for how long it certainly keeps two flying bodies apart: eqs. (7b) to (8c) of docs/theory.md.

The direction n(t) = n + t m is not kept unit: whatever its length, the bodies are disjoint while n(t).r(t) is more than the sum of their
supports. With the m of eq. (8b) it follows the best direction to first order, so that a grazing pair is passed in few steps. A support is
bounded to third order in time, with what is left bounded by the fourth derivative of the shape matrix, which is small when the shape
hardly moves: spin about the symmetry axis of a body of revolution, for one, costs nothing.

Nothing here branches, so that a loop over columns of pairs (flight_blocks.py) becomes vector instructions.
"""

from math import inf

from ccd.compiling import kernel
from ccd.lanes import sqrt
from ccd.separation import shape_matrix
from ccd.tolerances import CANCELLING
from ccd.vectors import add, add_scaled, cross, dot, root_and_inverse, scale, subtract


@kernel
def times(m, v):
    """A symmetric matrix, as its six different entries, times a vector."""
    return (m[0] * v[0] + m[3] * v[1] + m[4] * v[2], m[3] * v[0] + m[1] * v[1] + m[5] * v[2], m[4] * v[0] + m[5] * v[1] + m[2] * v[2])


@kernel
def swing(s, axis, rate):
    """Bounds on the norms of the second, third and fourth time derivative of a shape matrix that turns at a rate about an axis, eq. (7b).

    s: its semi-axis vectors at any time. The part of X that couples the spin axis to the plane across it turns once a turn, the traceless
    part in that plane twice, the rest not at all.
    """
    x = shape_matrix(s)
    along = times(x, axis)
    axial = dot(along, axis)
    once = dot(along, along) - axial * axial
    across = x[0] + x[1] + x[2] - axial
    whole = x[0] * x[0] + x[1] * x[1] + x[2] * x[2] + 2 * (x[3] * x[3] + x[4] * x[4] + x[5] * x[5])
    twice = sqrt(max(0.5 * (whole - axial * axial - 0.5 * across * across) - once, 0.0) + CANCELLING * whole)
    once = sqrt(max(once, 0.0) + CANCELLING * whole)
    square = rate * rate
    return square * (once + 4 * twice), square * rate * (once + 8 * twice), square * square * (once + 16 * twice)


@kernel
def facing(s, flight, n):
    """A body as it stands to the unit direction n. -> h, the supporting point c of the body without its size, curvature, drift and 1 / h.

    s: its semi-axis vectors at size 1; flight: (size, spin, growth).
    curvature: H, the second derivative of size * h by n, eq. (8b). drift: what the body's flight adds to the right side of eq. (8b).
    """
    p, q, w = dot(s[0], n), dot(s[1], n), dot(s[2], n)
    h, over = root_and_inverse(p * p + q * q + w * w)
    c = scale(over, add_scaled(add_scaled(scale(p, s[0]), q, s[1]), w, s[2]))
    return face(h, c, over, shape_matrix(s), flight, n)


@kernel
def face(h, c, over, x, flight, n):
    """What `facing` returns, from h, c, 1 / h and the shape matrix."""
    size, spin, growth = flight
    k = size * over
    curvature = (k * (x[0] - c[0] * c[0]), k * (x[1] - c[1] * c[1]), k * (x[2] - c[2] * c[2]),
                 k * (x[3] - c[0] * c[1]), k * (x[4] - c[0] * c[2]), k * (x[5] - c[1] * c[2]))
    drift = subtract(scale(size, cross(c, spin)), add_scaled(times(curvature, cross(n, spin)), growth, c))
    return h, c, curvature, drift, over


@kernel
def following(face_a, face_b, gap, n, pull):
    """How far the best direction lies from n towards `pull`, to first order: the tangential m of (H + gap) m = pull, eq. (8b).

    -> m, solved; m is 0 where float64 cannot solve for it.
    """
    a, b = face_a[2], face_b[2]
    return leaning((a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3], a[4] + b[4], a[5] + b[5]), gap, n, pull)


@kernel
def leaning(k, gap, n, pull):
    """`following` with H, the sum of the curvatures."""
    w = add_scaled(pull, -dot(pull, n), n)
    trace = k[0] + k[1] + k[2] + gap
    minors = k[0] * k[1] - k[3] * k[3] + k[0] * k[2] - k[4] * k[4] + k[1] * k[2] - k[5] * k[5] + gap * trace
    solved = minors > 0.0
    return scale(1.0 / minors if solved else 0.0, subtract(scale(trace, w), times(k, w))), solved


@kernel
def support_series(face, flight, n, m):
    """How size * h moves in the direction n + t m, eq. (7c): (rate, second, third, steady, shrinking, growing, over h).

    face, flight: as for `facing`.
    """
    h, c, curvature, _, over_h = face
    size, spin, growth = flight
    d0, e1 = cross(n, spin), cross(m, spin)
    d, e = add(d0, m), add_scaled(cross(d0, spin), 2.0, e1)
    f = add_scaled(scale(3.0, cross(e1, spin)), -dot(spin, spin), d0)
    rate, bend, over = dot(c, d), dot(c, e), size * over_h
    turned = times(curvature, d)
    second = dot(turned, d) + size * bend
    third = dot(turned, e) + over * rate * bend + size * (1 / 3) * dot(c, f)
    return size * rate + growth * h, second, third, 2 * growth * rate, rate * over_h, growth / size, over


@kernel
def support_bend(series, swing, turning, reach):
    """A bound on the curvature of size * h up to the time `reach`, eq. (7c): it stays below its tangent + bend t^2 / 2. turning: |m|."""
    _, second, third, steady, shrinking, growing, over = series
    length = 1 + 0.5 * (turning * reach) * (turning * reach)
    fourth = over * (1 / 24) * (length * length * swing[2] + turning * (8 * length * swing[1] + 12 * turning * swing[0]))
    bend = second + max(reach * (third + reach * fourth), 0.0)
    return steady + max(bend, bend * (1 + growing * reach) / (1 + shrinking * reach))


@kernel
def first_root(gap, rate, bend):
    """The first time at which gap + rate t - bend t^2 / 2 is no longer positive; inf for never. gap >= 0."""
    square = rate * rate + 2 * bend * gap
    root = sqrt(max(square, 0.0))
    over, under = (2 * gap, root - rate) if rate < 0 else (rate + root, bend)
    return inf if (square < 0) | (under <= 0) else over / under


@kernel
def holding_span(plane, body_a, body_b, left, guess):
    """How long a turning plane keeps the bodies apart at least, eq. (8c); inf when it does for all the time that is left.

    plane: (gap, rate, twice m.v, |m|); body: (series, swing). guess: how far to look. The bend grows with the reach that it must hold for;
    every reach gives a time on the safe side, and a look at a second one costs more than the steps that it saves. No look goes further
    than where the tangent of h has fallen to half its value.
    """
    gap, rate, helping, turning = plane
    (series_a, swing_a), (series_b, swing_b) = body_a, body_b
    reach = min(left, 0.5 / max(-series_a[4], -series_b[4], 1e-300), guess if guess > 0.0 else left)
    bend = support_bend(series_a, swing_a, turning, reach) + support_bend(series_b, swing_b, turning, reach) - helping
    root = first_root(gap, rate, bend)
    return (inf if reach == left else reach) if root > reach else root
