"""A body of revolution by its axis alone: the supports of first_contact.py and turning_plane.py for a fraction of the arithmetic.

With u the unit axis, p the semi-axis along it and a the one across it, h(n)^2 = a^2 |n - (u.n) u|^2 + p^2 (u.n)^2: a sum of squares, which
keeps full precision for plates. Where the shape turns at a constant angular velocity w, u' = w x u, u'' = w x u' and u''' = -|w|^2 u': the
supports in any direction n follow from u.n, u'.n and u''.n. A sphere is one whose axis is any.
"""

from ccd.compiling import kernel
from ccd.rotation import cos_and_sinc
from ccd.turning_plane import face
from ccd.vectors import add, add_scaled, cross, dot, root_and_inverse, scale


@kernel
def turning_axis(u, spin, square, time):
    """(u, u', u'') of an axis that turns at the constant rate `spin`, so much later. square: |spin|^2."""
    first = cross(spin, u)
    second = cross(spin, first)
    half = 0.5 * time
    c, s = cos_and_sinc(half * half * square)
    s *= half
    sine, less = 2 * s * c, 2 * s * s                       # sin(w t) / w, and (1 - cos(w t)) / w^2
    moved = add(scale(sine, first), scale(less, second))
    return add(u, moved), add_scaled(add_scaled(first, sine, second), -square * less, first), add_scaled(second, -square, moved)


@kernel
def shape_of_axis(u, across, along):
    """The shape matrix, as its six entries (`shape_matrix`). across, along: squares of the semi-axes."""
    d = along - across
    return (across + d * u[0] * u[0], across + d * u[1] * u[1], across + d * u[2] * u[2],
            d * u[0] * u[1], d * u[0] * u[2], d * u[1] * u[2])


@kernel
def course_of_axis(axis, squares, bend, fourth, n):
    """`first_contact.support_course` of a body of revolution that turns at a constant rate.

    axis: (u, u', u''); squares: of the semi-axes across it and along it, and |w|^2.
    """
    across, along, square = squares
    c, first, second = dot(axis[0], n), dot(axis[1], n), dot(axis[2], n)
    beside, d = add_scaled(n, -c, axis[0]), along - across
    h, over = root_and_inverse(across * dot(beside, beside) + along * c * c)
    half_rate = d * c * first
    rate = half_rate * over
    return h, rate, d * (first * first + c * second) - rate * rate, d * first * second - (1 / 3) * square * half_rate, fourth, bend


@kernel
def facing_of_axis(u, across, along, flight, n):
    """`turning_plane.facing` of a body of revolution."""
    c = dot(u, n)
    beside = add_scaled(n, -c, u)
    point = add_scaled(scale(across, beside), along * c, u)
    h, over = root_and_inverse(across * dot(beside, beside) + along * c * c)
    return face(h, scale(over, point), over, shape_of_axis(u, across, along), flight, n)
