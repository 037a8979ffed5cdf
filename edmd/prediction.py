"""The earliest thing that can happen to a body. Bounds are never made exact before their time comes (docs/theory.md, section 3)."""

from math import inf

from ccd.compiling import kernel, large_kernel
from ccd.first_contact import support_course
from ccd.revolution import course_of_axis
from ccd.vectors import dot, norm, subtract
from edmd.calendar import schedule
from edmd.events import EventKind
from edmd.flight import flight_of
from edmd.pairs import ball_now, direction_of, held, hold_until, imaged, is_sphere, meeting, size_now, support_until, within
from edmd.prefetch import fetch, fetch_body
from edmd.state import (
    AWAITED,
    BEGIN,
    COUNT,
    ESCAPE_TIME,
    EVENT,
    GROWTH,
    HORIZON,
    IMAGE,
    MET_TIME,
    NORMAL,
    NOW,
    PARTNER,
    REFINE,
    ROUNDING,
    SIDE,
    SIDE_BEND,
    SIDE_RATE,
    SINCE,
    SLOT,
    TWIN,
    WATCHED,
)

ESCAPE = int(EventKind.ESCAPE)
BLOCK, WIDTH = 32, 8                    # entries bounded at once, and a multiple of the lanes of a vector instruction
NORMALS, SIDES, RATES, BENDS, AGES, SPANS, COLUMNS = (BLOCK * column for column in (0, 3, 4, 5, 6, 7, 8))


@kernel
def predict(world, body):
    """After a change of velocity: bound every pair of the body anew, which is up to date, with its turning; some are to be watched."""
    begin = int(world.lists.spans[body, BEGIN])
    end = begin + int(world.lists.spans[body, COUNT])
    world.turns[body, MET_TIME] = -inf
    if is_sphere(world, body):
        own = ball_now(world, body)
        for first in range(begin, end, BLOCK):
            _predict_balls(world, body, (first, min(first + BLOCK, end)), own)
    else:
        flight = flight_of(world, body)
        for first in range(begin, end, BLOCK):
            _predict_block(world, (first, min(first + BLOCK, end)), flight)


@kernel
def _predict_balls(world, body, entries, own):
    """The meetings of a sphere with some of its neighbours, in columns; those that are no spheres are bounded."""
    clock, column, lists = world.clock, world.columns, world.lists
    begin, end = entries
    now, growth, size = clock[NOW], clock[GROWTH], size_now(clock)
    for entry in range(begin, end):
        fetch(world.bodies[lists.links[entry, PARTNER]], 0)
        fetch(lists.numbers[lists.links[entry, TWIN]], 0)
    for entry in range(begin, end):
        k, partner = entry - begin, int(lists.links[entry, PARTNER])
        other = ball_now(world, partner)
        r, v = imaged(world, entry, subtract(other[0], own[0])), subtract(other[1], own[1])
        column[k], column[BLOCK + k], column[2 * BLOCK + k] = r
        column[3 * BLOCK + k], column[4 * BLOCK + k], column[5 * BLOCK + k] = v
        column[AGES + k] = own[2] + other[2]
    for k in range((end - begin + WIDTH - 1) // WIDTH * WIDTH):
        reach = column[AGES + k]
        column[SPANS + k] = meeting((column[k], column[BLOCK + k], column[2 * BLOCK + k]),
                                    (column[3 * BLOCK + k], column[4 * BLOCK + k], column[5 * BLOCK + k]), size * reach, growth * reach)
    for entry in range(begin, end):
        span = column[SPANS + entry - begin]
        hold_until(world, entry, now + span)
        if not is_sphere(world, int(lists.links[entry, PARTNER])):
            n = direction_of(lists, entry)
            _tell_side(lists.numbers[lists.links[entry, TWIN]], clock, n, dot(n, imaged(world, entry, (0.0, 0.0, 0.0))), own)
            _watch_anew(world, entry)


@large_kernel
def _tell_side(number, clock, n, there, own):
    """Write a sphere's side of the plane into the list of a neighbour that is none."""
    reach = own[2] * norm(n)
    number[SIDE] = there - dot(n, own[0]) - size_now(clock) * reach
    number[SIDE_RATE], number[SIDE_BEND], number[SINCE] = -dot(n, own[1]) - clock[GROWTH] * reach, 0.0, clock[NOW]


@kernel
def _watch_anew(world, entry):
    """Ask for a better plane than the one on record, or where there is no room to ask, for a look at once."""
    tally = world.tally
    fetch_body(world, int(world.lists.links[entry, PARTNER]))
    if tally[WATCHED] < len(world.watched):
        world.watched[tally[WATCHED]] = entry
        tally[WATCHED] += 1
    else:
        world.lists.numbers[entry, EVENT] = world.clock[NOW]


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
        fetch(lists.numbers[lists.links[entry, TWIN]], 0)
    _bound_columns(column, (end - begin + WIDTH - 1) // WIDTH * WIDTH, own,
                   (size_now(clock), clock[GROWTH], 2 * clock[HORIZON], clock[ROUNDING]))
    for entry in range(begin, end):
        k, twin = entry - begin, lists.links[entry, TWIN]
        number, there = lists.numbers[twin], 0.0
        if lists.links[entry, IMAGE // 4] != 0:
            there = dot(direction_of(lists, entry), imaged(world, entry, (0.0, 0.0, 0.0)))
        number[SIDE], number[SIDE_RATE], number[SIDE_BEND] = there - column[SIDES + k], -column[RATES + k], column[BENDS + k]
        number[SINCE], number[EVENT] = now, inf
        age, lists.numbers[entry, EVENT] = column[AGES + k], now + column[SPANS + k]
        if (column[SPANS + k] < clock[REFINE] and age > 0.0) or age > clock[HORIZON]:       # age 0: of the pair that has just collided
            _watch_anew(world, entry)


@kernel
def _bound_columns(column, size, own, growing):
    """How long the planes hold; the body's own sides take the place of its neighbours'. own: up to date."""
    if own.axial:
        _, squares, _, bend, _, fourth = own.turning
        for k in range(size):
            _bound(column, k, own, course_of_axis(own.vectors, squares, bend, fourth, _direction(column, k)), growing)
    else:
        for k in range(size):
            _bound(column, k, own, support_course(own.vectors, own.turning, _direction(column, k)), growing)


@kernel
def _direction(column, k):
    return column[NORMALS + k], column[NORMALS + BLOCK + k], column[NORMALS + 2 * BLOCK + k]


@kernel
def _bound(column, k, own, course, growing):
    """How long the plane of one column holds. course: of the body's support in its direction."""
    n, age, (factor, growth, horizon, rounding) = _direction(column, k), column[AGES + k], growing
    height, rising, bending = support_until(course, factor, growth, horizon)
    top, top_rate = dot(n, own.position) + height, dot(n, own.velocity) + rising
    rate = column[RATES + k] - age * column[BENDS + k]
    gap = column[SIDES + k] + 0.5 * age * (column[RATES + k] + rate) - top
    bend = column[BENDS + k] + bending
    column[SPANS + k] = within(0.5 * horizon, held(gap, rate - top_rate, bend, (height, rounding)), bend)
    column[SIDES + k], column[RATES + k], column[BENDS + k] = top, top_rate, bending


@kernel
def reschedule(world, body):
    """The body waits for the earliest of its pairs, or for its escape."""
    numbers, span = world.lists.numbers, world.lists.spans[body]
    begin = int(span[BEGIN])
    earliest, what = world.lists.escapes[body, ESCAPE_TIME], ESCAPE
    for slot in range(int(span[COUNT])):                            # no jump: who is earlier is a toss
        time = numbers[begin + slot, EVENT]
        earlier = time < earliest
        earliest, what = time if earlier else earliest, slot if earlier else what
    span[SLOT] = what
    span[AWAITED] = world.lists.links[begin + what, PARTNER] if what != ESCAPE else body
    schedule(world.calendar, body, earliest)
