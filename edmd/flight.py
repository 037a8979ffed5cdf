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
    BEND,
    BENDING,
    FASTEST,
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
    SWERVE,
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
def set_turning(row, turn, kind):
    """What is constant in flight of how a shape turns, for a new angular momentum: FASTEST, the largest angular velocity there will be, of
    a body of revolution in steady motion that of its axis; BEND and SWERVE, bounds on how its support values bend, eqs. (7d) and (7e)."""
    if kind[MOTION] == STILL:
        return
    if kind[MOTION] == FREE:
        _set_free_turning(row, turn, kind)
    else:
        spin = scale(kind[ACROSS], load(row, MOMENTUM))
        rate, turn[FASTEST] = norm(spin), _swing(row, kind, spin)
        swing = turn[FASTEST] + UNSTEADY * rate
        turn[BEND] = 0.5 * swing * (rate + swing) * kind[BENDING]


@large_kernel
def _set_free_turning(row, turn, kind):
    most, hardest = fastest_turning(load_quaternion(row, ORIENTATION), load(row, MOMENTUM), load(kind, INVERSE_MOMENTS))
    square, jolt, bending = most * most, 2 * kind[UNEQUAL] * most * hardest, kind[BENDING]
    turn[FASTEST], turn[BEND] = most, (square + 0.5 * hardest) * bending
    turn[SWERVE] = (1 / 6) * bending * (kind[LARGEST] - kind[SPREAD]) * (4 * square * most + 6 * most * hardest + jolt)


@kernel
def turning_ahead(row, turn, kind, q):
    """How the shape will turn from the orientation q on, as `support_course` takes it."""
    if kind[MOTION] == FREE:
        spin, acceleration = _free_turning(q, load(row, MOMENTUM), load(kind, INVERSE_MOMENTS))
        return spin, acceleration, turn[BEND], turn[SWERVE], 0.0
    return scale(kind[ACROSS], load(row, MOMENTUM)), (0.0, 0.0, 0.0), turn[BEND], 0.0, 1.0


@large_kernel
def _free_turning(q, momentum, inverse_moments):
    return angular_velocity(q, momentum, inverse_moments), angular_acceleration(q, momentum, inverse_moments)


@kernel
def _swing(row, kind, spin):
    """How fast the axis of a shape that turns steadily moves, a constant, eq. (7e); without an axis, how fast it turns."""
    axis = int(kind[AXIS])
    return norm(spin if axis >= NO_AXIS else cross(spin, scale(1.0 / kind[SEMI_AXES + axis], load(row, VECTORS + 3 * axis))))


@large_kernel
def turned_by(row, kind, time):
    """Orientation and semi-axis vectors of a body so much later than its row has them."""
    q = load_quaternion(row, ORIENTATION)
    if time == 0.0 or kind[MOTION] == STILL:
        return q, load_vectors(row, VECTORS)
    if kind[MOTION] == FREE:
        q = _turned_freely(q, load(row, MOMENTUM), load(kind, INVERSE_MOMENTS), time)
    else:
        q = turn(q, scale(kind[ACROSS], load(row, MOMENTUM)), time)
    return q, _vectors(kind, q)


@large_kernel
def _turned_freely(q, momentum, inverse_moments, time):
    return turn_freely(q, momentum, inverse_moments, time)


@kernel
def _vectors(kind, q):
    return semi_axis_vectors(load(kind, SEMI_AXES), body_axes(q))


@kernel
def flight_of(world, body, time):
    """What the bounds need of a body at some time, in registers: position, velocity, turning, semi-axis vectors. It stays where it is."""
    row, kind = world.bodies[body], world.kinds[kind_of(world, body)]
    q, vectors = turned_by(row, kind, time - row[TIME])
    return position_at(row, time), load(row, VELOCITY), turning_ahead(row, world.turns[body], kind, q), vectors


@kernel
def advance(row, kind, now):
    """Move the body of this row to the present."""
    if kind[MOTION] != STILL:
        _advance_shape(row, kind, now)
    store(row, POSITION, position_at(row, now))
    row[TIME] = now


@kernel
def _advance_shape(row, kind, now):
    q, vectors = turned_by(row, kind, now - row[TIME])
    row[ORIENTATION] = q[0]
    store(row, ORIENTATION + 1, (q[1], q[2], q[3]))
    store_vectors(row, VECTORS, vectors)


@kernel
def advance_all(rows, kinds, now):
    for body in range(len(rows)):
        advance(rows[body], kinds[int(rows[body, KIND])], now)


@kernel
def set_shapes(rows, turns, kinds):
    """The semi-axis vectors and the turning of all bodies from their orientations and angular momenta."""
    for body in range(len(rows)):
        row, kind = rows[body], kinds[int(rows[body, KIND])]
        store_vectors(row, VECTORS, _vectors(kind, load_quaternion(row, ORIENTATION)))
        set_turning(row, turns[body], kind)


@kernel
def turn_still(rows, kinds, time):
    """The orientations, after this time, of bodies whose turning does not move their shapes."""
    for body in range(len(rows)):
        row, kind = rows[body], kinds[int(rows[body, KIND])]
        if kind[MOTION] == STILL:
            q = turn_freely(load_quaternion(row, ORIENTATION), load(row, MOMENTUM), load(kind, INVERSE_MOMENTS), time)
            row[ORIENTATION] = q[0]
            store(row, ORIENTATION + 1, (q[1], q[2], q[3]))
