"""How a free rigid body with any principal moments turns, exactly: eqs. (12b) to (12e) of docs/theory.md.

The angular momentum stays as it is in the lab; in the body's frame it runs along a curve of elliptic functions. The turn from one moment to
another is an algebraic function of where it is on that curve, of Weierstrass's function of half the time, and of one angle. Nothing is
solved step by step, and no case is special: equal moments, the separatrix and the principal axes are limits that the same formulas reach.

q: unit quaternion, body to lab; momentum: angular momentum, lab frame; inverse_moments: one over each principal moment.
"""

from math import copysign, inf
from typing import NamedTuple

from ccd.compiling import kernel
from ccd.lanes import absolute, greater, lesser, most, sqrt, where_less
from ccd.rotation import cos_and_sinc, multiply, to_body, to_lab, turn, unit
from ccd.tolerances import DOUBLINGS, PERIOD, SHORT_TURN, STEADY
from ccd.vectors import add_scaled, cross, dot, norm, scale


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


class Top(NamedTuple):
    """All that tells how a free top turns from here, but the time, eq. (12b): for a momentum of length 1 and inverse moments times L."""

    length: float           # L, of the angular momentum
    x: tuple                # the direction of the momentum in the body's frame
    drift: tuple            # x'
    shift: tuple            # the d_i
    spin: float             # 2 E / L
    wobble: float           # |x'|^2
    swerve: float           # chi L
    square: float           # the sum of the squares of the e_i over 10: the k^4 term of k^2 times Weierstrass's function, over k^4
    cube: float             # the product of the e_i over 7: the k^6 term, over k^6


@kernel
def top_of(q, momentum, inverse_moments):
    """The `Top` of a body that stands and turns like this."""
    length = norm(momentum)
    x = scale(1.0 / where_less(0.0, length, length, inf), to_body(q, momentum))
    rates = scale(length, inverse_moments)
    drift, shift, wobble, e = _curve(rates, x)
    spin = dot(rates, _each(x, x))
    return Top(length, x, drift, shift, spin, wobble, spin * wobble - dot(rates, _each(drift, drift)), dot(e, e) * (1 / 10),
               e[0] * e[1] * e[2] * (1 / 7))


@kernel
def top_from(length, x, spin, swerve, square, inverse_moments):
    """The same from those of its numbers that take longest to compute."""
    drift, shift, wobble, e = _curve(scale(length, inverse_moments), x)
    return Top(length, x, drift, shift, spin, wobble, swerve, square, e[0] * e[1] * e[2] * (1 / 7))


@kernel
def _curve(rates, x):
    """Of a `Top`: drift, shift, wobble, and the e_i. rates: inverse moments times L."""
    slopes = _differences(rates)
    drift, shift = _each(slopes, _others(x)), _each(_others(slopes), _each(x, x))
    mean = (shift[0] + shift[1] + shift[2]) * (1 / 3)
    return drift, shift, dot(drift, drift), (mean - shift[0], mean - shift[1], mean - shift[2])


@kernel
def turn_freely(q, momentum, inverse_moments, time):
    """The orientation q after turning freely for some time, of either sign, made unit again, eqs. (12b) and (12c)."""
    top = top_of(q, momentum, inverse_moments)
    return unit(turn_top(top, q, momentum, inverse_moments, time)) if top.length > 0.0 else q


@kernel
def turn_top(top, q, momentum, inverse_moments, time):
    """`turn_freely` of a body whose `Top` is known, not made unit again."""
    half, doublings = 0.5 * time, 0
    if is_short(top, half):
        return turn_shortly(top, q, inverse_moments, half)
    swerving = _swerving(top)
    if top.wobble < STEADY * swerving:
        return turn(q, scale(top.spin / top.length, momentum), time)
    extent = half * half * swerving
    while extent > SHORT_TURN and doublings < DOUBLINGS:
        extent, half, doublings = 0.25 * extent, 0.5 * half, doublings + 1
    curve, terms, square = _curve_of(top, half)
    return _turned_to(_doubled(_short(curve, terms, square), curve, terms, half, doublings), top, q, inverse_moments, half)


@kernel
def is_short(top, half):
    """Whether `turn_shortly` turns it as far as `turn_top`; of two bodies side by side, both."""
    return most(half * half * _swerving(top)) <= SHORT_TURN


@kernel
def _swerving(top):
    return absolute(top.shift[0]) + absolute(top.shift[1]) + absolute(top.shift[2]) + top.wobble


@kernel
def turn_shortly(top, q, inverse_moments, half):
    """`turn_top` for a short time, by its half, where a series tells all; also of two bodies side by side."""
    curve, terms, square = _curve_of(top, half)
    return _turned_to(_short(curve, terms, square), top, q, inverse_moments, half)


@kernel
def _curve_of(top, half):
    """What `_short` takes."""
    square = half * half
    curve = (scale(square, top.shift), square * top.wobble, top.spin, square * top.swerve)
    return curve, (square * square * top.square, square * square * square * top.cube), square


@kernel
def _turned_to(place, top, q, inverse_moments, half):
    """The orientation, from where the momentum has come on its curve."""
    y, w, f, z, c, s = place
    a, b = _each(top.x, _others(y)), scale(half, _each(top.drift, y))
    r0 = c * f * z
    r1 = half * (c * (top.length * inverse_moments[0] - top.spin) * (top.x[0] * w + b[0]) + s * (a[0] + half * top.drift[0] * w))
    r2 = half * (c * (top.length * inverse_moments[1] - top.spin) * (top.x[1] * w + b[1]) + s * (a[1] + half * top.drift[1] * w))
    r3 = half * (c * (top.length * inverse_moments[2] - top.spin) * (top.x[2] * w + b[2]) + s * (a[2] + half * top.drift[2] * w))
    return multiply(q, (r0, r1, r2, r3))


@kernel
def _short(curve, terms, square):
    """y, w, f, z and the cosine and scaled sine of the angle of eq. (12b), by series in k^2, whose terms are of the size of `shift`.

    curve: (d_i, lambda, spin, chi), all but the spin times k^2; terms: the next two of k^2 times Weierstrass's function; square: k^2.
    """
    (shift, wobble, spin, swerve), (g, h) = curve, terms
    mean = (shift[0] + shift[1] + shift[2]) * (1 / 3)
    p = mean + wobble
    f = 1 + ((g + h) + (g * g * (1 / 3) + g * h * (3 / 11)) - mean)
    w = (1 - (g + 2 * h)) - (g * g + g * h * (12 / 11))
    integral = ((1 / 3 + p * (1 / 5)) + p * p * ((1 / 7 + p * (1 / 9)) + p * p * (1 / 11 + p * (1 / 13)))
                - g * ((1 / 7 + p * (2 / 9)) + p * p * (3 / 11)) - h * (1 / 9 + p * (2 / 11)) + g * g * (2 / 33))
    rate = spin + swerve * integral
    c, s = cos_and_sinc(square * rate * rate)
    return (f + shift[0], f + shift[1], f + shift[2]), w, f, f - wobble, c, s * rate


@kernel
def _doubled(place, curve, terms, half, doublings):
    """What `_short` gives for a time, for 2^doublings times as long a one (in the same units), eq. (12c). half: k."""
    y, w, f, z, c, s = place
    shift, wobble, _, swerve = curve
    p = (shift[0] + shift[1] + shift[2]) * (1 / 3) + wobble
    slope = 3 * p * p - 5 * terms[0]
    s, v = s * half, swerve * half
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
    return y, w, f, z, c, s / half


@kernel
def _along(c, s, re, im):
    """The direction of the product of two complex numbers."""
    x, y = c * re - s * im, c * im + s * re
    over = 1.0 / sqrt(x * x + y * y)
    return over * x, over * y


@kernel
def fastest_turning(top, inverse_moments):
    """The largest |w| and |dw/dt| of all time, eq. (12d), to rounding; attained, but for steady turning. w: angular velocity."""
    moments = scale(top.length, inverse_moments)
    squares, rates = _each(top.x, top.x), _differences(moments)
    w = _each(moments, top.x)
    speed = dot(w, w) + greater(0.0, greater(top.shift[0], greater(top.shift[1], top.shift[2])))
    weights = _each(_each(moments, moments), _each(rates, rates))
    product = rates[0] * rates[1] * rates[2]
    now = dot(weights, _others(squares))
    slope = (weights[0] * (rates[1] * squares[2] + rates[2] * squares[1]) + weights[1] * (rates[2] * squares[0] + rates[0] * squares[2])
             + weights[2] * (rates[0] * squares[1] + rates[1] * squares[0]))
    bend = product * product
    curved = where_less(0.0, bend, bend, 1.0)               # without a bend the rate is that of now for all time
    along, last = 0.5 * slope / curved, inf
    along, last = _within(squares[0] / where_less(0.0, bend, rates[0], 1.0), rates[0], along, last)
    along, last = _within(squares[1] / where_less(0.0, bend, rates[1], 1.0), rates[1], along, last)
    along, last = _within(squares[2] / where_less(0.0, bend, rates[2], 1.0), rates[2], along, last)
    along = lesser(along, last)
    return sqrt(speed), sqrt(where_less(0.0, bend, greater(now, now + along * (slope - along * curved)), now))


@kernel
def _within(end, rate, along, last):
    """A place on a curve, and the last one there is, no further than where a square that changes at this rate would be 0."""
    return where_less(0.0, rate, greater(along, -end), along), where_less(rate, 0.0, lesser(last, -end), last)


@kernel
def jolts(most, hardest, unequal, spread):
    """Bounds for all time on what `support_course` leaves out of the third derivative of h^2 over 6, and on the fourth over 24, eq. (7d).

    most, hardest: of `fastest_turning`; unequal: the largest difference of two moments over the third; spread: of the squared semi-axes.
    """
    square, jerk = most * most, 2 * unequal * most * hardest
    fourth = 8 * square * (square + 3 * hardest) + 6 * hardest * hardest + 8 * most * jerk + 2 * unequal * (most * jerk + hardest * hardest)
    return spread * ((1 / 2) * most * hardest + (1 / 6) * jerk), (1 / 24) * spread * fourth


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
