"""What the engine knows of a pair of neighbours: two flights, the plane between them, and its sides in the lists (theory, section 3).

A plane of direction n, from a body to a neighbour, keeps the two apart while the body's side of it, U = n.x + h(n), stays below the
neighbour's, L = n.x - h(n). Each side moves with its own body alone, so the list entry that a body has of a neighbour keeps n and the
bound of L: after a collision a body computes its own U, and looks at no neighbour.
"""

from math import inf, sqrt

import numpy as np

from ccd.compiling import kernel
from ccd.first_contact import gap_motion, grown, holding_time, support_motion
from ccd.vectors import add_scaled, cross, dot, load, norm, scale, store, subtract
from edmd.boundary import displaced
from edmd.flight import kind_of, load_vectors, position_at, turning_ahead
from edmd.state import (
    EVENT,
    GROWTH,
    HORIZON,
    IMAGE,
    LARGEST,
    NORMAL,
    NOW,
    ROUNDING,
    SIDE,
    SIDE_BEND,
    SIDE_RATE,
    SINCE,
    SIZE,
    SPREAD,
    TIME,
    TWIN,
    VECTORS,
    VELOCITY,
)
from edmd.tolerances import CROSSED


@kernel
def size_now(clock):
    return clock[SIZE] + clock[GROWTH] * clock[NOW]


@kernel
def flight_now(world, body):
    """What the bounds need of a body, in registers: position now, velocity, turning, semi-axis vectors, and the age of the last two."""
    row, kind, now = world.bodies[body], world.kinds[kind_of(world, body)], world.clock[NOW]
    return position_at(row, now), load(row, VELOCITY), turning_ahead(row, kind), load_vectors(row, VECTORS), now - row[TIME]


@kernel
def flight_support(flight, n, clock, reach):
    """(value, rate, bend) of a parabola nowhere below size * h(n) of a body up to the time `reach` from now."""
    _, _, turning, vectors, age = flight
    return grown(support_motion(vectors, turning, n, age, reach), size_now(clock), clock[GROWTH], reach)


@kernel
def pair_motion(a, b, r, n, clock, reach):
    """(gap, rate, bend, sum of supports) of two flights in direction n, eq. (8). Bodies need not be up to date."""
    motion_a, motion_b = flight_support(a, n, clock, reach), flight_support(b, n, clock, reach)
    gap, rate, bend = gap_motion(n, r, subtract(b[1], a[1]), motion_a, motion_b)
    return gap, rate, bend, motion_a[0] + motion_b[0]


@kernel
def direction_of(lists, entry):
    n = lists.directions[entry]
    return np.float64(n[NORMAL]), np.float64(n[NORMAL + 1]), np.float64(n[NORMAL + 2])


@kernel
def imaged(world, entry, r):
    """r moved by the cell vectors that lead to the image of the neighbour."""
    if world.lists.links[entry, IMAGE // 4] == 0:
        return r
    image = world.lists.images[entry]
    return displaced(r, world.grid.box, image[IMAGE], image[IMAGE + 1], image[IMAGE + 2])


@kernel
def record(world, entry, own, other, n):
    """Let a pair be watched by the plane of direction n, from now on. -> for how long it holds."""
    lists, clock = world.lists, world.clock
    number, twin = lists.numbers[entry], lists.links[entry, TWIN]
    store(lists.directions[entry], NORMAL, n)
    n = direction_of(lists, entry)
    store(lists.directions[twin], NORMAL, scale(-1.0, n))
    above, below = flight_support(other, n, clock, 2 * clock[HORIZON]), flight_support(own, n, clock, 2 * clock[HORIZON])
    there = dot(n, imaged(world, entry, (0.0, 0.0, 0.0)))
    side, rate = dot(n, other[0]) + there - above[0], dot(n, other[1]) - above[1]
    top, top_rate = dot(n, own[0]) + below[0], dot(n, own[1]) + below[1]
    number[SIDE], number[SIDE_RATE], number[SIDE_BEND], number[SINCE] = side, rate, above[2], clock[NOW]
    number = lists.numbers[twin]
    number[SIDE], number[SIDE_RATE], number[SIDE_BEND], number[SINCE] = there - top, -top_rate, below[2], clock[NOW]
    bend = above[2] + below[2]
    return within(clock[HORIZON], held(side - top, rate - top_rate, bend, (above[0] + below[0], clock[ROUNDING])), bend)


@kernel
def held(gap, rate, bend, errors):
    """For how long a plane on record holds, whose gap may be 0 but for rounding; 0 for one that cuts into the bodies.

    errors: a length that the gap is a difference of, and the rounding of a position.
    """
    length, rounding = errors
    span = holding_time(gap - 8 * rounding, rate, bend)
    return span if gap >= -CROSSED * length - 8 * rounding else 0.0


@kernel
def within(horizon, span, bend):
    """A span that bounds vouch for up to a horizon; without a bend, of bodies that do not turn, they vouch for all of it."""
    return span if bend == 0.0 else min(span, horizon)


@kernel
def hold_until(world, entry, time):
    """Write a pair's earliest contact into the list of this body; the neighbour's entry is void."""
    numbers = world.lists.numbers
    numbers[entry, EVENT] = time
    numbers[world.lists.links[entry, TWIN], EVENT] = inf


@kernel
def ball_now(world, body):
    """Of a sphere: position now, velocity, radius at size 1."""
    row = world.bodies[body]
    return position_at(row, world.clock[NOW]), load(row, VELOCITY), world.kinds[kind_of(world, body)][LARGEST]


@kernel
def is_sphere(world, body):
    return world.kinds[kind_of(world, body)][SPREAD] == 0.0


@kernel
def meeting(r, v, reach, growing):
    """How long until two spheres meet, eq. (9b), inf for never; r, v: between their centres, reach: sum of the radii, growing: its rate.

    No jump: whether they come nearer is a toss.
    """
    closing, opening = dot(r, v) - reach * growing, dot(v, v) - growing * growing
    distance = norm(r)
    apart = max(distance - reach, 0.0) * (distance + reach)
    offset, passing = add_scaled(scale(reach, v), -growing, r), cross(r, v)
    square = dot(offset, offset) - dot(passing, passing)            # closing^2 - opening * apart, without the cancellation from afar
    root = sqrt(max(square, 0.0))
    over, under = (apart, root - closing) if closing < 0 else (closing + root, -opening)
    return inf if (square < 0) | (under <= 0) else over / under


@kernel
def meeting_of_balls(world, entry, own, other):
    """`meeting` of two balls, besides their gap, its rate and the vector between the centres."""
    clock, reach = world.clock, own[2] + other[2]
    r, v = imaged(world, entry, subtract(other[0], own[0])), subtract(other[1], own[1])
    distance, growing = norm(r), reach * clock[GROWTH]
    reach *= size_now(clock)
    rate = dot(scale(1.0 / distance, r), v) - growing           # along the n of the impulse, to the bit: else energy drifts one way
    return meeting(r, v, reach, growing), distance - reach, rate, r
