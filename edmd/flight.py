"""A body in flight: brought up to date where it is stored, or in registers as it is at some time, for those who look at it."""

from typing import NamedTuple

from ccd.compiling import kernel, large_kernel
from ccd.first_contact import support_course
from ccd.free_top import angular_velocity, fastest_turning, turn_freely, turning_of
from ccd.precession import NO_AXIS
from ccd.revolution import course_of_axis, facing_of_axis, shape_of_axis, turning_axis
from ccd.rotation import body_axes, load_quaternion, turn
from ccd.separation import semi_axis_vectors, shape_matrix
from ccd.turning_plane import facing
from ccd.vectors import add_scaled, cross, dot, load, norm, scale, store
from edmd.state import (
    ACROSS,
    ACROSS_SQUARE,
    ALONG_SQUARE,
    AXIS,
    BEND,
    BENDING,
    FASTEST,
    FREE,
    GENERAL,
    INVERSE_MOMENTS,
    KIND,
    LARGEST,
    MOMENTUM,
    MOTION,
    ORIENTATION,
    POLE,
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
def _swing(row, kind, spin):
    """How fast the axis of a shape that turns steadily moves, a constant, eq. (7e); without an axis, how fast it turns."""
    axis = int(kind[AXIS])
    return norm(spin if axis >= NO_AXIS else cross(spin, scale(1.0 / kind[SEMI_AXES + axis], load(row, VECTORS + 3 * axis))))


@kernel
def _turned(row, kind, time):
    """How a shape stands so much later than its row has it: orientation, semi-axis vectors, angular velocity and acceleration."""
    q, momentum = load_quaternion(row, ORIENTATION), load(row, MOMENTUM)
    if kind[MOTION] == FREE:
        q, axes, spin, acceleration = _turned_freely(q, momentum, load(kind, INVERSE_MOMENTS), time)
        return q, semi_axis_vectors(load(kind, SEMI_AXES), axes), spin, acceleration
    spin = scale(kind[ACROSS], momentum)
    if time != 0.0:
        q = turn(q, spin, time)
    return q, load_vectors(row, VECTORS) if time == 0.0 else _vectors(kind, q), spin, (0.0, 0.0, 0.0)


@large_kernel
def _turned_freely(q, momentum, inverse_moments, time):
    if time != 0.0:
        q = turn_freely(q, momentum, inverse_moments, time)
    axes = body_axes(q)
    spin, acceleration = turning_of(axes, momentum, inverse_moments)
    return q, axes, spin, acceleration


@kernel
def _vectors(kind, q):
    return semi_axis_vectors(load(kind, SEMI_AXES), body_axes(q))


@kernel
def vectors_after(row, kind, time, size):
    """Semi-axis vectors at this size so much later than the row of a body has them."""
    vectors = load_vectors(row, VECTORS)
    if kind[MOTION] != STILL:
        _, vectors, _, _ = _turned(row, kind, time)
    return scale(size, vectors[0]), scale(size, vectors[1]), scale(size, vectors[2])


class Flight(NamedTuple):
    """What the bounds need of a body at some time, in registers."""

    position: tuple
    velocity: tuple
    axial: bool             # whether a body of revolution goes by its axis alone
    vectors: tuple          # semi-axis vectors; of an axial body (u, u', u'') of its axis
    turning: tuple          # see `support_course`; of an axial body squares take the place of the acceleration: across, along, |w|^2


@kernel
def flight_of(world, body, time):
    """A body as it is at some time. It stays where it is."""
    row, kind = world.bodies[body], world.kinds[kind_of(world, body)]
    position, velocity = position_at(row, time), load(row, VELOCITY)
    if kind[POLE] != GENERAL:
        pole, spin = int(kind[POLE]), scale(kind[ACROSS], load(row, MOMENTUM))
        square = dot(spin, spin)
        axis = turning_axis(scale(1.0 / kind[SEMI_AXES + pole], load(row, VECTORS + 3 * pole)), spin, square, time - row[TIME])
        squares = kind[ACROSS_SQUARE], kind[ALONG_SQUARE], square
        return Flight(position, velocity, True, axis, (spin, squares, world.turns[body, BEND], 0.0, 1.0))
    turn, (_, vectors, spin, acceleration) = world.turns[body], _turned(row, kind, time - row[TIME])
    swerve, steady = (turn[SWERVE], 0.0) if kind[MOTION] == FREE else (0.0, 1.0)
    return Flight(position, velocity, False, vectors, (spin, acceleration, turn[BEND], swerve, steady))


@kernel
def course(flight, n):
    """How the support in direction n goes on (`support_course`)."""
    if flight.axial:
        across, along, square = flight.turning[1]
        return course_of_axis(flight.vectors, across, along, square, flight.turning[2], n)
    return support_course(flight.vectors, flight.turning, n)


@kernel
def face_of(flight, size, growth, n):
    """How the body stands to a direction (`facing`)."""
    if flight.axial:
        across, along, _ = flight.turning[1]
        return facing_of_axis(flight.vectors[0], across, along, (size, flight.turning[0], growth), n)
    return facing(flight.vectors, (size, flight.turning[0], growth), n)


@kernel
def shape_of(flight):
    """Its shape matrix."""
    if flight.axial:
        across, along, _ = flight.turning[1]
        return shape_of_axis(flight.vectors[0], across, along)
    return shape_matrix(flight.vectors)


@kernel
def advance(row, kind, now):
    """Move the body of this row to the present."""
    if kind[MOTION] != STILL:
        _advance_shape(row, kind, now)
    store(row, POSITION, position_at(row, now))
    row[TIME] = now


@kernel
def _advance_shape(row, kind, now):
    q, vectors, _, _ = _turned(row, kind, now - row[TIME])
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
