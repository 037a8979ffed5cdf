"""Bring a body up to date: straight flight, and rotation of its shape."""

from ccd.compiling import kernel, large_kernel
from ccd.free_top import angular_acceleration, angular_velocity, fastest_turning, turn_freely
from ccd.precession import NO_AXIS
from ccd.rotation import body_axes, load_quaternion, turn
from ccd.separation import semi_axis_vectors
from ccd.vectors import add_scaled, cross, load, norm, scale, store
from edmd.state import (
    ACROSS,
    AXIS,
    BENDING,
    FREE,
    INVERSE_MOMENTS,
    KIND,
    LARGEST,
    MOMENTUM,
    MOTION,
    ORIENTATION,
    POSITION,
    SEMI_AXES,
    SPREAD,
    STILL,
    TIME,
    UNEQUAL,
    VECTORS,
    VELOCITY,
)
from edmd.tolerances import UNSTEADY


@kernel
def load_vectors(row, start):
    """Semi-axis vectors: nine numbers of a row as three vectors."""
    return load(row, start), load(row, start + 3), load(row, start + 6)


@kernel
def store_vectors(row, start, vectors):
    store(row, start, vectors[0])
    store(row, start + 3, vectors[1])
    store(row, start + 6, vectors[2])


@kernel
def kind_of(world, body):
    """Row of its kind in the table."""
    return int(world.bodies[body, KIND])


@kernel
def position_at(row, now):
    return add_scaled(load(row, POSITION), now - row[TIME], load(row, VELOCITY))


@kernel
def turning(row, kind, momentum):
    """The angular velocity at which the shape turns now with this angular momentum, eqs. (12) and (12b)."""
    if kind[MOTION] == FREE:
        return angular_velocity(load_quaternion(row, ORIENTATION), momentum, load(kind, INVERSE_MOMENTS))
    return scale(kind[ACROSS], momentum)


@kernel
def turning_ahead(row, kind):
    """How the shape will turn, as `support_motion` takes it, eqs. (7d) and (7e)."""
    momentum = load(row, MOMENTUM)
    spin, bending = turning(row, kind, momentum), kind[BENDING]
    if kind[MOTION] != FREE:
        rate = norm(spin)
        swing = _swing(row, kind, spin) + UNSTEADY * rate
        return spin, (0.0, 0.0, 0.0), 0.5 * swing * (rate + swing) * bending, 0.0, 1.0
    q, inverse = load_quaternion(row, ORIENTATION), load(kind, INVERSE_MOMENTS)
    most, hardest = fastest_turning(q, momentum, inverse)
    square, jolt = most * most, 2 * kind[UNEQUAL] * most * hardest
    swerve = (1 / 6) * bending * (kind[LARGEST] - kind[SPREAD]) * (4 * square * most + 6 * most * hardest + jolt)
    return spin, angular_acceleration(q, momentum, inverse), (square + 0.5 * hardest) * bending, swerve, 0.0


@kernel
def fastest(row, kind):
    """The largest angular velocity at which the shape will turn; of a body of revolution in steady motion that of its axis."""
    momentum = load(row, MOMENTUM)
    if kind[MOTION] == FREE:
        return fastest_turning(load_quaternion(row, ORIENTATION), momentum, load(kind, INVERSE_MOMENTS))[0]
    return _swing(row, kind, scale(kind[ACROSS], momentum))


@kernel
def _swing(row, kind, spin):
    """How fast the axis of a shape that turns steadily moves, a constant, eq. (7e); without an axis, how fast it turns."""
    axis = int(kind[AXIS])
    return norm(spin if axis >= NO_AXIS else cross(spin, scale(1.0 / kind[SEMI_AXES + axis], load(row, VECTORS + 3 * axis))))


@large_kernel
def advance(row, kind, now):
    """Move the body of this row to the present."""
    time = now - row[TIME]
    if time == 0.0:
        return
    store(row, POSITION, position_at(row, now))
    row[TIME] = now
    if kind[MOTION] == STILL:
        return
    q, momentum = load_quaternion(row, ORIENTATION), load(row, MOMENTUM)
    if kind[MOTION] == FREE:
        q = turn_freely(q, momentum, load(kind, INVERSE_MOMENTS), time)
    else:
        q = turn(q, scale(kind[ACROSS], momentum), time)
    row[ORIENTATION] = q[0]
    store(row, ORIENTATION + 1, (q[1], q[2], q[3]))
    _set_vectors(row, kind)


@kernel
def _set_vectors(row, kind):
    store_vectors(row, VECTORS, semi_axis_vectors(load(kind, SEMI_AXES), body_axes(load_quaternion(row, ORIENTATION))))


@kernel
def advance_all(rows, kinds, now):
    for body in range(len(rows)):
        advance(rows[body], kinds[int(rows[body, KIND])], now)


@kernel
def set_vectors(rows, kinds):
    """The semi-axis vectors of all bodies from their orientations."""
    for body in range(len(rows)):
        _set_vectors(rows[body], kinds[int(rows[body, KIND])])


@kernel
def turn_still(rows, kinds, time):
    """The orientations, after this time, of bodies whose turning does not move their shapes."""
    for body in range(len(rows)):
        row, kind = rows[body], kinds[int(rows[body, KIND])]
        if kind[MOTION] == STILL:
            q = turn_freely(load_quaternion(row, ORIENTATION), load(row, MOMENTUM), load(kind, INVERSE_MOMENTS), time)
            row[ORIENTATION] = q[0]
            store(row, ORIENTATION + 1, (q[1], q[2], q[3]))
