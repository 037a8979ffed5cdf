"""How a free rigid body with any principal moments turns, exactly: eqs. (12b) to (12e) of docs/theory.md.

The angular momentum stays as it is in the lab; in the body's frame it runs along a curve of elliptic functions. The turn from one moment to
another is an algebraic function of where it is on that curve, of Weierstrass's function of half the time, and of one angle. Nothing is
solved step by step, and no case is special: equal moments, the separatrix and the principal axes are limits that the same formulas reach.

q: unit quaternion, body to lab; momentum: angular momentum, lab frame; inverse_moments: one over each principal moment.
"""

from math import copysign, inf, sqrt

from ccd.compiling import kernel
from ccd.rotation import cos_and_sinc, multiply, to_body, to_lab, turn
from ccd.tolerances import DOUBLINGS, PERIOD, SHORT_TURN, STEADY
from ccd.vectors import add_scaled, cross, dot, scale


@kernel
def angular_velocity(q, momentum, inverse_moments):
    """In the lab frame."""
    return to_lab(q, _each(inverse_moments, to_body(q, momentum)))


@kernel
def angular_momentum(q, angular_velocity, inverse_moments):
    """In the lab frame, as the angular velocity: the inverse of `angular_velocity`."""
    w = to_body(q, angular_velocity)
    return to_lab(q, (w[0] / inverse_moments[0], w[1] / inverse_moments[1], w[2] / inverse_moments[2]))


@kernel
def turning_of(axes, momentum, inverse_moments):
    """Angular velocity and its rate, by Euler's equations, of a body with these axes (`body_axes`); all in the lab frame."""
    x = dot(axes[0], momentum), dot(axes[1], momentum), dot(axes[2], momentum)
    w = _each(inverse_moments, x)
    return _combined(axes, w), _combined(axes, _each(inverse_moments, cross(x, w)))


@kernel
def _combined(axes, x):
    return add_scaled(add_scaled(scale(x[0], axes[0]), x[1], axes[1]), x[2], axes[2])


@kernel
def turn_freely(q, momentum, inverse_moments, time):
    """The orientation q after turning freely for some time, of either sign, made unit again, eqs. (12b) and (12c)."""
    square = dot(momentum, momentum)
    if square == 0.0:
        return q
    half = 0.5 * time
    x = to_body(q, momentum)
    rates = scale(half, _differences(inverse_moments))
    drift = _each(rates, _others(x))
    shift = _each(_others(rates), _each(x, x))
    wobble = dot(drift, drift) / square
    spin = dot(inverse_moments, _each(x, x)) / square
    swerve = spin * wobble - dot(inverse_moments, _each(drift, drift)) / square
    extent = abs(shift[0]) + abs(shift[1]) + abs(shift[2]) + wobble
    doublings = 0
    if extent > SHORT_TURN:
        if wobble < STEADY * extent:
            return turn(q, scale(spin, momentum), time)
        part = 1.0
        while extent > SHORT_TURN and doublings < DOUBLINGS:
            extent, part, doublings = 0.25 * extent, 0.5 * part, doublings + 1
        half, drift = part * half, scale(part, drift)
        shift, wobble, swerve = scale(part * part, shift), part * part * wobble, part * part * swerve
    curve = (shift, wobble, spin, swerve)
    place = _short(curve, half * half * square)
    if doublings > 0:
        place = _doubled(place, curve, half * sqrt(square), doublings)
    y, w, f, z, c, s = place
    a, b = _each(x, _others(y)), _each(drift, y)
    r0 = c * f * z
    r1 = half * (c * (inverse_moments[0] - spin) * (x[0] * w + b[0]) + s * (a[0] + drift[0] * w))
    r2 = half * (c * (inverse_moments[1] - spin) * (x[1] * w + b[1]) + s * (a[1] + drift[1] * w))
    r3 = half * (c * (inverse_moments[2] - spin) * (x[2] * w + b[2]) + s * (a[2] + drift[2] * w))
    unit = (1.5 - 0.5 * (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])) / sqrt(r0 * r0 + r1 * r1 + r2 * r2 + r3 * r3)
    t0, t1, t2, t3 = multiply(q, (r0, r1, r2, r3))
    return (unit * t0, unit * t1, unit * t2, unit * t3)


@kernel
def _short(curve, square):
    """y, w, f, z and the cosine and scaled sine of the angle of eq. (12b), by series in k^2, whose terms are of the size of `shift`.

    curve: (d_i, lambda, spin, chi), all but the spin times k^2; square: |k L|^2.
    """
    shift, wobble, spin, swerve = curve
    mean = (shift[0] + shift[1] + shift[2]) * (1 / 3)
    e = (mean - shift[0], mean - shift[1], mean - shift[2])
    p = mean + wobble
    g, h = dot(e, e) * (1 / 10), e[0] * e[1] * e[2] * (1 / 7)               # the k^4 and k^6 terms of k^2 times Weierstrass's function
    f = 1 + ((g + h) + (g * g * (1 / 3) + g * h * (3 / 11)) - mean)
    w = (1 - (g + 2 * h)) - (g * g + g * h * (12 / 11))
    integral = ((1 / 3 + p * (1 / 5)) + p * p * ((1 / 7 + p * (1 / 9)) + p * p * (1 / 11 + p * (1 / 13)))
                - g * ((1 / 7 + p * (2 / 9)) + p * p * (3 / 11)) - h * (1 / 9 + p * (2 / 11)) + g * g * (2 / 33))
    rate = spin + swerve * integral
    c, s = cos_and_sinc(square * rate * rate)
    return (f + shift[0], f + shift[1], f + shift[2]), w, f, f - wobble, c, s * rate


@kernel
def _doubled(place, curve, length, doublings):
    """What `_short` gives for a time, for 2^doublings times as long a one (in the same units), eq. (12c). length: |k L|."""
    y, w, f, z, c, s = place
    shift, wobble, _, swerve = curve
    mean = (shift[0] + shift[1] + shift[2]) * (1 / 3)
    e = (mean - shift[0], mean - shift[1], mean - shift[2])
    slope = 3 * (mean + wobble) * (mean + wobble) - 0.5 * dot(e, e)
    s, v = s * length, swerve * length
    least = min(shift)
    above = (shift[0] - least, shift[1] - least, shift[2] - least)
    product = max(above[0] * above[1], above[1] * above[2], above[2] * above[0])            # one of them is 0
    lowest = min(y)
    for _ in range(doublings):
        c, s = c * c - s * s, 2 * c * s
        c, s = _along(c, s, z * (z * z - slope) + 2 * v * v, 2 * w * v)
        r = 0.5 * (lowest * lowest - product) / w
        lowest = r * r + PERIOD
        y = (lowest + above[0], lowest + above[1], lowest + above[2])
        w = copysign(sqrt(y[0] * y[1] * y[2]), r)
        f = lowest - least
        z = max(f - wobble, PERIOD)
    return y, w, f, z, c, s / length


@kernel
def _along(c, s, re, im):
    """The direction of the product of two complex numbers."""
    x, y = c * re - s * im, c * im + s * re
    over = 1.0 / sqrt(x * x + y * y)
    return over * x, over * y


@kernel
def fastest_turning(q, momentum, inverse_moments):
    """The largest |w| and |dw/dt| of all time, eq. (12d), to rounding; attained, but for steady turning. w: angular velocity."""
    x = to_body(q, momentum)
    squares, rates = _each(x, x), _differences(inverse_moments)
    w = _each(inverse_moments, x)
    shift = _each(_others(rates), squares)
    speed = dot(w, w) + max(0.0, shift[0], shift[1], shift[2])
    weights = _each(_each(inverse_moments, inverse_moments), _each(rates, rates))
    product = rates[0] * rates[1] * rates[2]
    now = dot(weights, _others(squares))
    slope = (weights[0] * (rates[1] * squares[2] + rates[2] * squares[1]) + weights[1] * (rates[2] * squares[0] + rates[0] * squares[2])
             + weights[2] * (rates[0] * squares[1] + rates[1] * squares[0]))
    bend = product * product
    if bend == 0.0:
        return sqrt(speed), sqrt(now)
    first, last = -inf, inf
    for square, rate in ((squares[0], rates[0]), (squares[1], rates[1]), (squares[2], rates[2])):
        end = -square / rate
        first, last = (max(first, end), last) if rate > 0 else (first, min(last, end))
    along = min(max(0.5 * slope / bend, first), last)
    return sqrt(speed), sqrt(max(now, now + along * (slope - along * bend)))


@kernel
def _each(a, b):
    return (a[0] * b[0], a[1] * b[1], a[2] * b[2])


@kernel
def _others(a):
    """The products of the other two."""
    return (a[1] * a[2], a[2] * a[0], a[0] * a[1])


@kernel
def _differences(a):
    """alpha of eq. (12b) from the inverse moments."""
    return (a[2] - a[1], a[0] - a[2], a[1] - a[0])
