"""The earliest thing that can happen to a body. Bounds are never made exact before their time comes (docs/theory.md, section 3).

A plane of direction n, from a body to a neighbour, keeps the two apart while the body's side of it, U = n.x + h(n), stays below the
neighbour's, L = n.x - h(n). Each side moves with its own body alone, so the list entry that a body has of a neighbour keeps n and the
bound of L: after a collision a body computes its own U, and looks at no neighbour.
"""

from math import inf, sqrt

import numpy as np

from ccd.compiling import kernel
from ccd.first_contact import gap_motion, grown, holding_time, support_motion
from ccd.separation import best_plane, support
from ccd.tolerances import COARSE, EXACT, TOUCHING
from ccd.vectors import add_scaled, cross, dot, load, norm, scale, store, subtract
from edmd.boundary import displaced
from edmd.calendar import earliest_rival, schedule
from edmd.events import EventKind
from edmd.flight import advance, kind_of, load_vectors, position_at, turning_ahead
from edmd.state import (
    BEGIN,
    COUNT,
    ESCAPE_TIME,
    EVENT,
    GROWTH,
    HORIZON,
    IMAGE,
    LARGEST,
    LOOKS,
    NORMAL,
    NOW,
    PARTNER,
    REFINE,
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
from edmd.tolerances import IMMINENT

ESCAPE = int(EventKind.ESCAPE)
BLOCK, WIDTH = 32, 8                    # entries bounded at once, and a multiple of the lanes of a vector instruction
NORMALS, SIDES, RATES, BENDS, AGES, SPANS, COLUMNS = (BLOCK * column for column in (0, 3, 4, 5, 6, 7, 8))


@kernel
def size_now(clock):
    return clock[SIZE] + clock[GROWTH] * clock[NOW]


@kernel
def flight_now(world, body):
    """What the bounds need of a body, in registers: position now, velocity, turning, semi-axis vectors, and the age of the last two."""
    row, kind, now = world.bodies[body], world.kinds[kind_of(world, body)], world.clock[NOW]
    return position_at(row, now), load(row, VELOCITY), turning_ahead(row, kind), load_vectors(row, VECTORS), now - row[TIME]


@kernel
def flight_support(flight, n, clock):
    """(value, rate, bend) of a parabola nowhere below size * h(n) of a body within two horizons from now."""
    _, _, turning, vectors, age = flight
    motion = support_motion(vectors, turning, n, age, 2 * clock[HORIZON])
    if clock[GROWTH] == 0.0:
        return scale(clock[SIZE], motion)
    return grown(motion, size_now(clock), clock[GROWTH], 2 * clock[HORIZON])


@kernel
def pair_motion(a, b, r, n, clock):
    """(gap, rate, bend, sum of supports) of two flights in direction n, eq. (8). Bodies need not be up to date."""
    motion_a, motion_b = flight_support(a, n, clock), flight_support(b, n, clock)
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
def hold(world, entry, own, other, n):
    """Let a pair be watched by the plane of direction n, from now on. -> for how long it holds."""
    lists, clock = world.lists, world.clock
    store(lists.directions[entry], NORMAL, n)
    n = direction_of(lists, entry)
    store(lists.directions[lists.links[entry, TWIN]], NORMAL, scale(-1.0, n))
    above = flight_support(other, n, clock)
    side, rate, bend = dot(n, imaged(world, entry, other[0])) - above[0], dot(n, other[1]) - above[1], above[2]
    number = lists.numbers[entry]
    number[SIDE], number[SIDE_RATE], number[SIDE_BEND], number[SINCE] = side, rate, bend, clock[NOW]
    return span_of_sides(world, entry, own, n)


@kernel
def span_of_sides(world, entry, own, n):
    """How long the plane of an entry holds, its body being as it is now, which the neighbour's entry is told. At most the horizon."""
    lists, clock = world.lists, world.clock
    number, other = lists.numbers[entry], lists.numbers[lists.links[entry, TWIN]]
    below = flight_support(own, n, clock)
    top, top_rate = dot(n, own[0]) + below[0], dot(n, own[1]) + below[1]
    age = clock[NOW] - number[SINCE]
    rate = number[SIDE_RATE] - age * number[SIDE_BEND]
    gap = number[SIDE] + 0.5 * age * (number[SIDE_RATE] + rate) - top - 8 * clock[ROUNDING]
    there = imaged(world, entry, (0.0, 0.0, 0.0))
    other[SIDE], other[SIDE_RATE], other[SIDE_BEND], other[SINCE] = dot(n, there) - top, -top_rate, below[2], clock[NOW]
    return _within(clock[HORIZON], holding_time(gap, rate - top_rate, number[SIDE_BEND] + below[2]), number[SIDE_BEND] + below[2])


@kernel
def _within(horizon, span, bend):
    """A span that bounds within two horizons vouch for; without a bend, of bodies that do not turn, they vouch for all of it."""
    return span if bend == 0.0 else min(span, horizon)


@kernel
def renew(world, entry, own):
    """The best plane for the poses that the bodies have on record. -> for how long it holds."""
    other = flight_now(world, int(world.lists.links[entry, PARTNER]))
    r = imaged(world, entry, subtract(other[0], own[0]))
    n, _ = plane(own, other, r, direction_of(world.lists, entry), COARSE)
    return hold(world, entry, own, other, n)


@kernel
def plane(own, other, r, n, precision):
    """The best separating direction for the poses on record, and whether it converged; n: a direction near it.

    (1 - lambda) h_A = lambda h_B at the maximiser, by eq. (2): the direction says where to start.
    """
    h_a, h_b = support(own[3], n), support(other[3], n)
    n, _, converged = best_plane(own[3], other[3], r, h_a / (h_a + h_b), precision)
    return n, converged


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


@kernel
def hold_until(world, entry, time):
    """Write a pair's earliest contact into the list of this body; the neighbour's entry is void."""
    numbers = world.lists.numbers
    numbers[entry, EVENT] = time
    numbers[world.lists.links[entry, TWIN], EVENT] = inf


@kernel
def predict(world, body):
    """After a change of velocity: bound every pair of the body anew, which is up to date."""
    begin = int(world.lists.spans[body, BEGIN])
    end = begin + int(world.lists.spans[body, COUNT])
    if is_sphere(world, body):
        own = ball_now(world, body)
        for first in range(begin, end, BLOCK):
            _predict_balls(world, body, (first, min(first + BLOCK, end)), own)
    else:
        flight = flight_now(world, body)
        for first in range(begin, end, BLOCK):
            _predict_block(world, (first, min(first + BLOCK, end)), flight)


@kernel
def _predict_balls(world, body, entries, own):
    """The meetings of a sphere with some of its neighbours, in columns; those that are no spheres are bounded."""
    clock, column, lists = world.clock, world.columns, world.lists
    begin, end = entries
    now, growth, size = clock[NOW], clock[GROWTH], size_now(clock)
    for entry in range(begin, end):
        k, partner = entry - begin, int(lists.links[entry, PARTNER])
        other = ball_now(world, partner)
        r, v = imaged(world, entry, subtract(other[0], own[0])), subtract(other[1], own[1])
        for i in range(3):
            column[i * BLOCK + k], column[(3 + i) * BLOCK + k] = r[i], v[i]
        column[AGES + k] = own[2] + other[2]
    for k in range((end - begin + WIDTH - 1) // WIDTH * WIDTH):
        reach = column[AGES + k]
        column[SPANS + k] = meeting((column[k], column[BLOCK + k], column[2 * BLOCK + k]),
                                    (column[3 * BLOCK + k], column[4 * BLOCK + k], column[5 * BLOCK + k]), size * reach, growth * reach)
    for entry in range(begin, end):
        span = column[SPANS + entry - begin]
        if not is_sphere(world, int(lists.links[entry, PARTNER])):
            span = renew(world, entry, flight_now(world, body))
        hold_until(world, entry, now + span)


@kernel
def _predict_block(world, entries, own):
    """Bound the pairs of some entries of a body: in columns, so that the arithmetic becomes vector instructions (`_bound_columns`)."""
    lists, clock, column = world.lists, world.clock, world.columns
    now, (begin, end) = clock[NOW], entries
    for entry in range(begin, end):
        k, number, n = entry - begin, lists.numbers[entry], lists.directions[entry]
        column[NORMALS + k], column[NORMALS + BLOCK + k], column[NORMALS + 2 * BLOCK + k] = n[NORMAL], n[NORMAL + 1], n[NORMAL + 2]
        column[SIDES + k], column[RATES + k], column[BENDS + k] = number[SIDE], number[SIDE_RATE], number[SIDE_BEND]
        column[AGES + k] = now - number[SINCE]
    _bound_columns(column, (end - begin + WIDTH - 1) // WIDTH * WIDTH, own,
                   (size_now(clock), clock[GROWTH], 2 * clock[HORIZON], 8 * clock[ROUNDING]))
    for entry in range(begin, end):
        k, twin = entry - begin, lists.links[entry, TWIN]
        number, there = lists.numbers[twin], 0.0
        if lists.links[entry, IMAGE // 4] != 0:
            there = dot(direction_of(lists, entry), imaged(world, entry, (0.0, 0.0, 0.0)))
        number[SIDE], number[SIDE_RATE], number[SIDE_BEND] = there - column[SIDES + k], -column[RATES + k], column[BENDS + k]
        number[SINCE], number[EVENT] = now, inf
        span = column[SPANS + k]
        if span < clock[REFINE] or column[AGES + k] > clock[HORIZON]:
            span = max(span, renew(world, entry, own))
        lists.numbers[entry, EVENT] = now + span


@kernel
def _bound_columns(column, size, own, growing):
    """How long the planes hold; the body's own sides take the place of its neighbours'. own: up to date."""
    position, velocity, turning, vectors, _ = own
    factor, growth, horizon, rounding = growing
    for k in range(size):
        n = (column[NORMALS + k], column[NORMALS + BLOCK + k], column[NORMALS + 2 * BLOCK + k])
        height, rising, bending = grown(support_motion(vectors, turning, n, 0.0, horizon), factor, growth, horizon)
        top, top_rate, age = dot(n, position) + height, dot(n, velocity) + rising, column[AGES + k]
        rate = column[RATES + k] - age * column[BENDS + k]
        gap = column[SIDES + k] + 0.5 * age * (column[RATES + k] + rate) - top - rounding
        bend = column[BENDS + k] + bending
        column[SPANS + k] = _within(0.5 * horizon, holding_time(gap, rate - top_rate, bend), bend)
        column[SIDES + k], column[RATES + k], column[BENDS + k] = top, top_rate, bending


@kernel
def reschedule(world, body):
    """The body waits for the earliest of its pairs, or for its escape."""
    numbers, span = world.lists.numbers, world.lists.spans[body]
    begin = int(span[BEGIN])
    earliest, what = world.anchors[body, ESCAPE_TIME], ESCAPE
    for slot in range(int(span[COUNT])):
        if numbers[begin + slot, EVENT] < earliest:
            earliest, what = numbers[begin + slot, EVENT], slot
    schedule(world.calendar, body, earliest, what)


@kernel
def is_next(world, body, entry):
    """Whether the pair of an entry, just looked at, is what comes next of all events."""
    numbers, span = world.lists.numbers, world.lists.spans[body]
    begin, time = int(span[BEGIN]), numbers[entry, EVENT]
    if time - world.clock[NOW] > IMMINENT * world.clock[REFINE] or time >= world.anchors[body, ESCAPE_TIME]:
        return False
    for other in range(begin, begin + int(span[COUNT])):
        if numbers[other, EVENT] <= time and other != entry:
            return False
    return time < earliest_rival(world.calendar, body)


@kernel
def look(world, body, entry):
    """Bring a pair up to date and see whether it touches. If not, it waits for its next look. -> touches, rate of the gap, normal."""
    partner, now = int(world.lists.links[entry, PARTNER]), world.clock[NOW]
    world.tally[LOOKS] += 1
    advance(world.bodies[body], world.kinds[kind_of(world, body)], now)
    advance(world.bodies[partner], world.kinds[kind_of(world, partner)], now)
    if is_sphere(world, body) and is_sphere(world, partner):
        return _look_at_balls(world, entry, ball_now(world, body), ball_now(world, partner))
    return _look_at_ellipsoids(world, entry, flight_now(world, body), flight_now(world, partner))


@kernel
def _look_at_balls(world, entry, own, other):
    span, gap, rate, r = meeting_of_balls(world, entry, own, other)
    now, reach = world.clock[NOW], (own[2] + other[2]) * size_now(world.clock)
    if rate < 0 and (gap <= TOUCHING * reach + world.clock[ROUNDING] or now + span == now):      # positions are known no better
        return True, rate, scale(1.0 / norm(r), r)
    hold_until(world, entry, now + span)
    return False, rate, r


@kernel
def _look_at_ellipsoids(world, entry, own, other):
    """One step of the certified shoot. Just before a contact the plane on record stays: it is near enough to start from."""
    clock = world.clock
    r = imaged(world, entry, subtract(other[0], own[0]))
    n, converged = plane(own, other, r, direction_of(world.lists, entry), EXACT)
    gap, rate, bend, supports = pair_motion(own, other, r, n, clock)
    time = clock[NOW] + _within(clock[HORIZON], holding_time(gap, rate, bend), bend)
    if rate < 0 and converged and (gap <= TOUCHING * supports + clock[ROUNDING] or time == clock[NOW]):     # as of balls
        hold(world, entry, own, other, n)                   # a plane that cuts into the bodies would say nothing of what comes next
        return True, rate, n
    if time - clock[NOW] > IMMINENT * clock[REFINE]:
        hold(world, entry, own, other, n)
    hold_until(world, entry, time)
    return False, rate, n
