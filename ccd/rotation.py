"""Unit quaternions (w, x, y, z), scalar first, turning body into lab; rotation at a constant rate."""

from math import pi

from ccd.compiling import kernel
from ccd.lanes import cos, greater, most, sin, sqrt, where_less
from ccd.vectors import add, add_scaled, cross, scale

SERIES_BELOW = 0.25      # squared half-angle up to which eight terms of the series are exact to the last bit
TURN_HIGH, TURN_LOW = 2 * pi, 2.4492935982947064e-16     # a whole turn, and what float64 leaves of it
ROUNDS = 1.5 * 2.0**52   # added and taken away, it leaves the nearest whole number


@kernel
def load_quaternion(row, start):
    """Four consecutive entries of a one-dimensional array."""
    return (row[start], row[start + 1], row[start + 2], row[start + 3])


@kernel
def multiply(p, q):
    return (p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
            p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
            p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
            p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0])


@kernel
def to_body(q, vector):
    """A vector given in the lab, in the frame of the body."""
    return to_lab((q[0], -q[1], -q[2], -q[3]), vector)


@kernel
def to_lab(q, vector):
    """A vector given in the frame of the body, in the lab."""
    u = (q[1], q[2], q[3])
    twice = scale(2.0, cross(u, vector))
    return add(add_scaled(vector, q[0], twice), cross(u, twice))


@kernel
def _series(z):
    """cos x and sin x / x from z, x squared, below SERIES_BELOW. In pairs, and pairs of pairs, that the processor adds side by side."""
    zz = z * z
    c = (((1 - z * (1 / 2)) + zz * (1 / 24 - z * (1 / 720)))
         + zz * zz * ((1 / 40320 - z * (1 / 3628800)) + zz * (1 / 479001600 - z * (1 / 87178291200))))
    s = (((1 - z * (1 / 6)) + zz * (1 / 120 - z * (1 / 5040)))
         + zz * zz * ((1 / 362880 - z * (1 / 39916800)) + zz * (1 / 6227020800 - z * (1 / 1307674368000))))
    return c, s


@kernel
def cos_and_sinc(square):
    """cos x and sin x / x from x squared. Flights between events turn a body by little: the series saves two library calls."""
    c, s = _series(square)
    if most(square) < SERIES_BELOW:
        return c, s
    x = sqrt(greater(square, SERIES_BELOW))
    return where_less(square, SERIES_BELOW, c, cos(x)), where_less(square, SERIES_BELOW, s, sin(x) / x)


@kernel
def _cos_and_sin(x):
    """Of any angle and without a branch, so that loops become vector instructions: less whole turns, an eighth of it, doubled thrice."""
    turns = (x * (1 / TURN_HIGH) + ROUNDS) - ROUNDS
    x = (x - turns * TURN_HIGH) - turns * TURN_LOW
    eighth = 0.125 * min(max(x, -4.0), 4.0)
    c, s = _series(eighth * eighth)
    s *= eighth
    for _ in range(3):
        c, s = 1 - 2 * s * s, 2 * s * c
    return c, s


@kernel
def turn(q, angular_velocity, time):
    """The orientation q after turning at a constant angular velocity (lab frame) for some time, made unit again."""
    half = 0.5 * time
    x, y, z = half * angular_velocity[0], half * angular_velocity[1], half * angular_velocity[2]
    c, s = cos_and_sinc(x * x + y * y + z * z)
    return _turned(q, (c, s * x, s * y, s * z))


@kernel
def turn_about(q, axis, angle):
    """`turn` by an angle about a unit axis (lab frame), without a branch."""
    c, s = _cos_and_sin(0.5 * angle)
    return _turned(q, (c, s * axis[0], s * axis[1], s * axis[2]))


@kernel
def _turned(q, by):
    w, x, y, z = multiply(by, q)
    unit = 1.5 - 0.5 * (w * w + x * x + y * y + z * z)        # one Newton step for 1 / |q| from 1
    return (unit * w, unit * x, unit * y, unit * z)


@kernel
def body_axes(q):
    """The three body axes in the lab frame: columns of the rotation matrix, as three vectors."""
    w, x, y, z = q
    return ((1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)),
            (2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)),
            (2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)))


@kernel
def unit(q):
    """A quaternion made unit."""
    over = 1.0 / sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    return (over * q[0], over * q[1], over * q[2], over * q[3])


@kernel
def axes_of_any(q):
    """`body_axes` of a quaternion of any length: a division, which is sooner done than a root and another one."""
    w, x, y, z = q
    twice = 2.0 / (w * w + x * x + y * y + z * z)
    a, b, c = twice * x, twice * y, twice * z
    return ((1 - (y * b + z * c), x * b + w * c, x * c - w * b),
            (x * b - w * c, 1 - (x * a + z * c), y * c + w * a),
            (x * c + w * b, y * c - w * a, 1 - (x * a + y * b)))
