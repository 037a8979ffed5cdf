"""A body in flight: brought up to date where it is stored, or in registers as it is at some time, for those who look at it."""

from typing import NamedTuple

from ccd import rotation
from ccd.compiling import kernel, large_kernel
from ccd.first_contact import support_course
from ccd.free_top import (
    angular_velocity,
    fastest_turning,
    jolts,
    top_from,
    top_of,
    turn_freely,
    turn_top,
    turning_of,
)
from ccd.lanes import abreast, first, first_of, second, second_of, two
from ccd.precession import NO_AXIS
from ccd.revolution import course_of_axis, facing_of_axis, shape_of_axis, turning_axis
from ccd.rotation import axes_of_any, body_axes, load_quaternion, unit
from ccd.separation import semi_axis_vectors, shape_matrix
from ccd.turning_plane import facing
from ccd.vectors import add, add_scaled, cross, dot, load, norm, scale, store
from edmd.state import (
    ACROSS,
    ACROSS_SQUARE,
    ALONG_SQUARE,
    AXIS,
    BEND,
    BENDING,
    FASTEST,
    FOURTH,
    FREE,
    FREE_MOMENTS,
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
    THIRD,
    TIME,
    TOP,
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
def both(a, b, start):
    """A 3-vector of each of two rows."""
    return abreast(load(a, start), load(b, start))


@kernel
def each(a, b, k):
    """A number of each of two rows."""
    return two(a[k], b[k])


@kernel
def vectors_of_both(a, b, start):
    """The semi-axis vectors that stand in each of two rows."""
    return both(a, b, start), both(a, b, start + 3), both(a, b, start + 6)


@kernel
def store_both(a, b, start, vectors):
    """A 3-vector into each of two rows."""
    store(a, start, first_of(vectors))
    store(b, start, second_of(vectors))


@kernel
def store_each(a, b, k, x):
    """A number into each of two rows."""
    a[k], b[k] = first(x), second(x)


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
    a body of revolution in steady motion that of its axis; what bounds its support values, eqs. (7), (7d), (7e) and (12e); of a free top
    what tells where it turns, for the pose of now."""
    if kind[MOTION] == STILL:
        return
    if kind[MOTION] == FREE:
        _set_free_turning(row, turn, kind)
    else:
        spin = scale(kind[ACROSS], load(row, MOMENTUM))
        rate, turn[FASTEST] = norm(spin), _swing(row, kind, spin)
        swing = turn[FASTEST] + UNSTEADY * rate
        turn[BEND] = 0.5 * swing * (rate + swing) * kind[BENDING]
        turn[FOURTH] = (1 / 3) * rate * rate * turn[BEND] * (kind[LARGEST] - kind[SPREAD])


@large_kernel
def _set_free_turning(row, turn, kind):
    set_free_turning((row, row), (turn, turn), (kind, kind))


@kernel
def set_free_turning(rows, turns, kinds):
    """`set_turning` of two free tops, which may be one."""
    (a, b), (turn_a, turn_b), (kind_a, kind_b) = rows, turns, kinds
    moments, least = both(kind_a, kind_b, FREE_MOMENTS), each(kind_a, kind_b, LARGEST) - each(kind_a, kind_b, SPREAD)
    top = top_of((each(a, b, ORIENTATION),) + both(a, b, ORIENTATION + 1), both(a, b, MOMENTUM), moments)
    (most, hardest), bending = fastest_turning(top, moments), each(kind_a, kind_b, BENDING)
    third, fourth = jolts(most, hardest, each(kind_a, kind_b, UNEQUAL), bending * least)
    store_each(turn_a, turn_b, TOP, top.length)
    store_both(turn_a, turn_b, TOP + 1, top.x)
    store_both(turn_a, turn_b, TOP + 4, (top.spin, top.swerve, top.square))
    store_each(turn_a, turn_b, FASTEST, most)
    store_each(turn_a, turn_b, BEND, (most * most + 0.5 * hardest) * bending)
    store_each(turn_a, turn_b, THIRD, third)
    store_each(turn_a, turn_b, FOURTH, fourth)


@kernel
def _swing(row, kind, spin):
    """How fast the axis of a shape that turns steadily moves, a constant, eq. (7e); without an axis, how fast it turns."""
    axis = int(kind[AXIS])
    return norm(spin if axis >= NO_AXIS else cross(spin, scale(1.0 / kind[SEMI_AXES + axis], load(row, VECTORS + 3 * axis))))


@kernel
def turned(row, turn, kind, time):
    """The orientation so much later than the row of a body has it; of a free top not made unit."""
    if kind[MOTION] == FREE:
        return _turned_freely(turn, load_quaternion(row, ORIENTATION), load(row, MOMENTUM), load(kind, INVERSE_MOMENTS), time)
    return rotation.turn(load_quaternion(row, ORIENTATION), scale(kind[ACROSS], load(row, MOMENTUM)), time)


@large_kernel
def _turned_freely(turn, q, momentum, inverse_moments, time):
    top = top_from(turn[TOP], load(turn, TOP + 1), turn[TOP + 4], turn[TOP + 5], turn[TOP + 6], inverse_moments)
    return turn_top(top, q, momentum, inverse_moments, time)


@kernel
def vectors_after(row, turn, kind, time, size):
    """Semi-axis vectors at this size so much later than the row of a body has them."""
    vectors = load_vectors(row, VECTORS)
    if kind[MOTION] != STILL:
        vectors = semi_axis_vectors(load(kind, SEMI_AXES), axes_of_any(turned(row, turn, kind, time)))
    return scale(size, vectors[0]), scale(size, vectors[1]), scale(size, vectors[2])


class Flight(NamedTuple):
    """What the bounds need of a body at some time, in registers; or of two bodies side by side (couple.py)."""

    position: tuple
    velocity: tuple
    axial: bool             # whether a body of revolution goes by its axis alone
    vectors: tuple          # semi-axis vectors; of an axial body (u, u', u'') of its axis
    turning: tuple          # see `support_course`; of an axial body squares (`course_of_axis`) take the place of the acceleration


@kernel
def flight_of(world, body):
    """A body that is up to date."""
    row, turn, kind = world.bodies[body], world.turns[body], world.kinds[kind_of(world, body)]
    position, velocity, momentum = load(row, POSITION), load(row, VELOCITY), load(row, MOMENTUM)
    spin = scale(kind[ACROSS], momentum)
    if kind[POLE] != GENERAL:
        pole, square = int(kind[POLE]), dot(spin, spin)
        axis = turning_axis(scale(1.0 / kind[SEMI_AXES + pole], load(row, VECTORS + 3 * pole)), spin, square, 0.0)
        squares = kind[ACROSS_SQUARE], kind[ALONG_SQUARE], square
        return Flight(position, velocity, True, axis, (spin, squares, 0.0, turn[BEND], 0.0, turn[FOURTH]))
    free_spin, acceleration = turning_of(body_axes(load_quaternion(row, ORIENTATION)), momentum, load(kind, FREE_MOMENTS))
    middle, third = middle_square(kind[LARGEST], kind[SPREAD]), turn[THIRD] if kind[MOTION] == FREE else 0.0
    return Flight(position, velocity, False, load_vectors(row, VECTORS),
                  (add(spin, free_spin), acceleration, middle, turn[BEND], third, turn[FOURTH]))


@kernel
def middle_square(largest, spread):
    """Half the sum of the largest and the smallest squared semi-axis."""
    least = largest - spread
    return 0.5 * (largest * largest + least * least)


@kernel
def course(flight, n):
    """How the support in direction n goes on (`support_course`)."""
    if flight.axial:
        _, squares, _, bend, _, fourth = flight.turning
        return course_of_axis(flight.vectors, squares, bend, fourth, n)
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
def advance(row, turn, kind, now):
    """Move the body of this row to the present."""
    arrive(row, turn, kind, now)
    if kind[MOTION] == FREE:
        _set_free_turning(row, turn, kind)


@kernel
def arrive(row, turn, kind, now):
    """`advance` of a body whose momentum is about to change: what is constant in its flight is left for `set_turning`."""
    if kind[MOTION] != STILL and now != row[TIME]:
        _advance_shape(row, turn, kind, now)
    store(row, POSITION, position_at(row, now))
    row[TIME] = now


@kernel
def _advance_shape(row, turn, kind, now):
    q = turned(row, turn, kind, now - row[TIME])
    if kind[MOTION] == FREE:
        q = unit(q)
    store_pose(row, q, _vectors(kind, q))


@kernel
def store_pose(row, q, vectors):
    row[ORIENTATION] = q[0]
    store(row, ORIENTATION + 1, (q[1], q[2], q[3]))
    store_vectors(row, VECTORS, vectors)


@kernel
def _vectors(kind, q):
    return semi_axis_vectors(load(kind, SEMI_AXES), body_axes(q))


@kernel
def advance_all(rows, turns, kinds, now):
    for body in range(len(rows)):
        advance(rows[body], turns[body], kinds[int(rows[body, KIND])], now)


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
