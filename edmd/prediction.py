"""The earliest thing that can happen to a body. Bounds are never made exact before their time comes (docs/theory.md, section 3)."""

from math import inf

from ccd.compiling import kernel
from ccd.first_contact import gap_motion, grown, holding_time, support_motion
from ccd.separation import best_plane
from ccd.tolerances import COARSE, EXACT, TOUCHING
from ccd.vectors import load, scale, store, subtract
from edmd.boundary import displaced
from edmd.calendar import schedule
from edmd.events import EventKind
from edmd.flight import advance, load_vectors, position_at
from edmd.state import (
    BEND,
    BODY_A,
    BODY_B,
    ESCAPE_TIME,
    GROWTH,
    HORIZON,
    LOOKS,
    NORMAL,
    NOW,
    PENCIL,
    REFINE,
    SHIFT,
    SIZE,
    SLOT_A,
    TIME,
    TURNING,
    VECTORS,
    VELOCITY,
)

ESCAPE = int(EventKind.ESCAPE)


@kernel
def size_now(clock):
    return clock[SIZE] + clock[GROWTH] * clock[NOW]


@kernel
def flight_now(row, clock):
    """What the bounds need of a body, in registers: position now, velocity, turning, semi-axis vectors and curvature, and their age."""
    return (position_at(row, clock[NOW]), load(row, VELOCITY), load(row, TURNING), load_vectors(row, VECTORS), row[BEND],
            clock[NOW] - row[TIME])


@kernel
def flight_support(flight, n, clock):
    """`support_motion` of a body from its own time, with its growth."""
    _, _, turning, vectors, bend, age = flight
    motion = support_motion(vectors, turning, bend, n, age)
    if clock[GROWTH] == 0.0:
        return scale(clock[SIZE], motion)
    return grown(motion, size_now(clock), clock[GROWTH], clock[HORIZON])


@kernel
def pair_motion(a, b, r, n, clock):
    """(gap, rate, bend, sum of supports) of two flights in direction n, eq. (8). Bodies need not be up to date."""
    motion_a, motion_b = flight_support(a, n, clock), flight_support(b, n, clock)
    gap, rate, bend = gap_motion(n, r, subtract(b[1], a[1]), motion_a, motion_b)
    return gap, rate, bend, motion_a[0] + motion_b[0]


@kernel
def separation_now(world, link, a, b, side):
    """Vector from the centre of one body of a pair to the image of the other; side is 1 when the first is the pair's A, otherwise -1."""
    return displaced(subtract(b[0], a[0]), world.grid.box, side * link[SHIFT], side * link[SHIFT + 1], side * link[SHIFT + 2])


@kernel
def renew_plane(plane, a, b, r, side, precision):
    """The best separating direction, from a to b, for the poses that the bodies have on record; side as in `separation_now`."""
    start = plane[PENCIL] if side > 0 else 1 - plane[PENCIL]
    n, x, converged = best_plane(a[3], b[3], r, start, precision)
    store(plane, NORMAL, scale(side, n))
    plane[PENCIL] = x if side > 0 else 1 - x
    return n, converged


@kernel
def span_without_contact(world, own, body, slot):
    """A time span, from now, in which the pair cannot touch: by its last plane, by a new one when that holds for a short time only.

    own: the flight of the body; slot: of the pair in its list.
    """
    clock, pair = world.clock, world.lists.pair[body, slot]
    link, plane = world.pairs.link[pair], world.pairs.plane[pair]
    side = 1 if link[BODY_A] == body else -1
    other = flight_now(world.bodies[world.lists.partner[body, slot]], clock)
    r = separation_now(world, link, own, other, side)
    gap, rate, bend, _ = pair_motion(own, other, r, scale(side, load(plane, NORMAL)), clock)
    span = holding_time(gap, rate, bend)
    if span < clock[REFINE]:
        n, _ = renew_plane(plane, own, other, r, side, COARSE)
        gap, rate, bend, _ = pair_motion(own, other, r, n, clock)
        span = max(span, holding_time(gap, rate, bend))
    return min(span, clock[HORIZON])


@kernel
def hold(world, body, slot, time):
    """Write a pair's earliest contact into the list of this body; the partner's entry is void."""
    lists = world.lists
    link = world.pairs.link[lists.pair[body, slot]]
    partner_slot = link[SLOT_A + 1] if link[BODY_A] == body else link[SLOT_A]
    lists.time[lists.partner[body, slot], partner_slot] = inf
    lists.time[body, slot] = time


@kernel
def predict(world, body):
    """After a change of velocity: bound every pair of the body anew."""
    lists, own = world.lists, flight_now(world.bodies[body], world.clock)
    for slot in range(lists.count[body]):
        hold(world, body, slot, world.clock[NOW] + span_without_contact(world, own, body, slot))


@kernel
def reschedule(world, body):
    """The body waits for the earliest of its pairs, or for its escape."""
    times = world.lists.time[body]
    earliest, what = world.anchors[body, ESCAPE_TIME], ESCAPE
    for slot in range(world.lists.count[body]):
        if times[slot] < earliest:
            earliest, what = times[slot], slot
    schedule(world.calendar, body, earliest, what)


@kernel
def look(world, body, slot):
    """One step of the certified shoot for the pair in this slot. -> whether it touches now, and the rate of its gap."""
    clock, pair = world.clock, world.lists.pair[body, slot]
    link = world.pairs.link[pair]
    world.tally[LOOKS] += 1
    advance(world.bodies[link[BODY_A]], clock[NOW])
    advance(world.bodies[link[BODY_B]], clock[NOW])
    a, b = flight_now(world.bodies[link[BODY_A]], clock), flight_now(world.bodies[link[BODY_B]], clock)
    r = separation_now(world, link, a, b, 1)
    n, converged = renew_plane(world.pairs.plane[pair], a, b, r, 1, EXACT)
    gap, rate, bend, supports = pair_motion(a, b, r, n, clock)
    time = clock[NOW] + min(holding_time(gap, rate, bend), clock[HORIZON])
    if rate < 0 and converged and (gap <= TOUCHING * supports or time == clock[NOW]):
        return True, rate
    hold(world, body, slot, time)
    return False, rate
