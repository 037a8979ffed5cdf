"""Unit quaternions (w, x, y, z), scalar first, turning body into lab; rotation at a constant rate."""

from math import cos, sin, sqrt

from ccd.compiling import kernel

SERIES_BELOW = 0.25      # squared half-angle up to which eight terms of the series are exact to the last bit


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
def _cos_and_sinc(square):
    """cos x and sin x / x from x squared. Flights between events turn a body by little: the series saves two library calls."""
    z = square
    if z < SERIES_BELOW:
        c = 1 - z / 2 * (1 - z / 12 * (1 - z / 30 * (1 - z / 56 * (1 - z / 90 * (1 - z / 132 * (1 - z / 182))))))
        s = 1 - z / 6 * (1 - z / 20 * (1 - z / 42 * (1 - z / 72 * (1 - z / 110 * (1 - z / 156 * (1 - z / 210))))))
        return c, s
    x = sqrt(z)
    return cos(x), sin(x) / x


@kernel
def turn(q, angular_velocity, time):
    """The orientation q after turning at a constant angular velocity (lab frame) for some time, made unit again."""
    half = 0.5 * time
    x, y, z = half * angular_velocity[0], half * angular_velocity[1], half * angular_velocity[2]
    c, s = _cos_and_sinc(x * x + y * y + z * z)
    w, x, y, z = multiply((c, s * x, s * y, s * z), q)
    unit = 1.5 - 0.5 * (w * w + x * x + y * y + z * z)        # one Newton step for 1 / |q| from 1
    return (unit * w, unit * x, unit * y, unit * z)


@kernel
def body_axes(q):
    """The three body axes in the lab frame: columns of the rotation matrix, as three vectors."""
    w, x, y, z = q
    return ((1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)),
            (2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)),
            (2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)))
