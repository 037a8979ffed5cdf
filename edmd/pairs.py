"""What the engine knows of a pair of neighbours: the plane between them, and its sides in the lists (theory, section 3).

A plane of direction n, from a body to a neighbour, keeps the two apart while the body's side of it, U = n.x + h(n), stays below the
neighbour's, L = n.x - h(n). Each side moves with its own body alone, so the list entry that a body has of a neighbour keeps n and the
bound of L: after a collision a body computes its own U, and looks at no neighbour.
"""

from math import inf, sqrt

import numpy as np

from ccd.compiling import kernel
from ccd.first_contact import bend_until, grown, holding_time
from ccd.lanes import first, second, total, two
from ccd.vectors import add_scaled, cross, dot, load, norm, scale, store, subtract
from edmd.boundary import displaced
from edmd.flight import kind_of, position_at
from edmd.state import (
    EVENT,
    GROWTH,
    HORIZON,
    IMAGE,
    LARGEST,
    MET_IMAGE,
    MET_PARTNER,
    NORMAL,
    NOW,
    PARTNER,
    ROUNDING,
    SIDE,
    SIDE_BEND,
    SIDE_RATE,
    SINCE,
    SIZE,
    SPREAD,
    TWIN,
    VELOCITY,
)
from edmd.tolerances import CROSSED


@kernel
def size_now(clock):
    return size_at(clock, clock[NOW])


@kernel
def size_at(clock, time):
    return clock[SIZE] + clock[GROWTH] * time


@kernel
def support_until(course, size, growth, reach):
    """(value, rate, bend) of a parabola nowhere below size * h(n) of a body up to the time `reach` from now."""
    return grown((course[0], course[1], bend_until(course, reach)), size, growth, reach)


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
def set_met(world, entry, body):
    """Note that the contact which is known of a body is that with the neighbour, and the image of it, of an entry."""
    link, span = world.lists.links[entry], world.lists.spans[body]
    span[MET_PARTNER], span[MET_IMAGE] = link[PARTNER], link[IMAGE // 4]


@kernel
def is_met(world, entry, body):
    """Whether the contact that is known of a body, or was known, is with the neighbour of an entry."""
    link, span = world.lists.links[entry], world.lists.spans[body]
    return span[MET_PARTNER] == link[PARTNER] and span[MET_IMAGE] == link[IMAGE // 4]


@kernel
def rounded(n):
    """A direction as the lists keep it."""
    return np.float64(np.float32(n[0])), np.float64(np.float32(n[1])), np.float64(np.float32(n[2]))


@kernel
def turn_plane(world, entry, n):
    """Put the direction n (`rounded`) on record. Both sides are to be bounded anew, this body's first: the other is void till then."""
    lists = world.lists
    store(lists.directions[entry], NORMAL, n)
    store(lists.directions[lists.links[entry, TWIN]], NORMAL, scale(-1.0, n))
    lists.numbers[entry, SINCE] = world.clock[NOW]


@kernel
def record(world, entry, pair, n, seen):
    """Let a pair be watched by the plane of direction n (`rounded`), from now on; seen: its `course`. -> for how long it holds."""
    lists, clock = world.lists, world.clock
    number, twin, size, growth = lists.numbers[entry], lists.links[entry, TWIN], size_now(clock), clock[GROWTH]
    turn_plane(world, entry, n)
    height, rising, bending = support_until(seen, size, growth, 2 * clock[HORIZON])
    there, outwards = dot(n, imaged(world, entry, (0.0, 0.0, 0.0))), two(1.0, -1.0)
    sides, rates = dot(n, pair.position) + outwards * height, dot(n, pair.velocity) + outwards * rising
    top, side, top_rate, rate = first(sides), second(sides) + there, first(rates), second(rates)
    number[SIDE], number[SIDE_RATE], number[SIDE_BEND] = side, rate, second(bending)
    number = lists.numbers[twin]
    number[SIDE], number[SIDE_RATE], number[SIDE_BEND], number[SINCE] = there - top, -top_rate, first(bending), clock[NOW]
    bend = total(bending)
    return within(clock[HORIZON], held(side - top, rate - top_rate, bend, (total(height), clock[ROUNDING])), bend)


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
