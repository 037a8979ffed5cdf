"""The earliest thing that can happen to a body. Bounds are never made exact before their time comes (docs/theory.md, section 3)."""

from math import inf

from ccd.compiling import kernel
from ccd.first_contact import gap_motion, grown, holding_time, support_motion
from ccd.separation import best_plane
from ccd.tolerances import COARSE, EXACT, TOUCHING
from ccd.vectors import load, store, subtract
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
def centre_to_centre(world, link, a, b):
    """Vector from the centre of body A to that of the image of B, now."""
    now = world.clock[NOW]
    return displaced(subtract(position_at(b, now), position_at(a, now)), world.grid.box, link[SHIFT], link[SHIFT + 1], link[SHIFT + 2])


@kernel
def body_support(row, n, clock):
    """`support_motion` of a body from its own time, with its growth."""
    motion = support_motion(load_vectors(row, VECTORS), load(row, TURNING), row[BEND], n, clock[NOW] - row[TIME])
    return grown(motion, size_now(clock), clock[GROWTH], clock[HORIZON])


@kernel
def pair_motion(a, b, r, n, clock):
    """(gap, rate, bend, sum of supports) of a pair in direction n, eq. (8). Bodies need not be up to date."""
    motion_a, motion_b = body_support(a, n, clock), body_support(b, n, clock)
    gap, rate, bend = gap_motion(n, r, subtract(load(b, VELOCITY), load(a, VELOCITY)), motion_a, motion_b)
    return gap, rate, bend, motion_a[0] + motion_b[0]


@kernel
def renew_plane(world, pair, a, b, r, precision):
    """The best separating direction for the poses that the bodies have on record."""
    plane = world.pairs.plane[pair]
    n, plane[PENCIL], converged = best_plane(load_vectors(a, VECTORS), load_vectors(b, VECTORS), r, plane[PENCIL], precision)
    store(plane, NORMAL, n)
    return n, converged


@kernel
def bound(world, pair):
    """A time span, from now, in which the pair cannot touch: by its last plane, by a new one when that holds for a short time only."""
    clock, link = world.clock, world.pairs.link[pair]
    a, b = world.bodies[link[BODY_A]], world.bodies[link[BODY_B]]
    r = centre_to_centre(world, link, a, b)
    gap, rate, bend, _ = pair_motion(a, b, r, load(world.pairs.plane[pair], NORMAL), clock)
    span = holding_time(gap, rate, bend)
    if span < clock[REFINE]:
        n, _ = renew_plane(world, pair, a, b, r, COARSE)
        gap, rate, bend, _ = pair_motion(a, b, r, n, clock)
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
    lists = world.lists
    for slot in range(lists.count[body]):
        hold(world, body, slot, world.clock[NOW] + bound(world, lists.pair[body, slot]))


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
    a, b = world.bodies[link[BODY_A]], world.bodies[link[BODY_B]]
    world.tally[LOOKS] += 1
    advance(a, clock[NOW])
    advance(b, clock[NOW])
    r = centre_to_centre(world, link, a, b)
    n, converged = renew_plane(world, pair, a, b, r, EXACT)
    gap, rate, bend, supports = pair_motion(a, b, r, n, clock)
    time = clock[NOW] + min(holding_time(gap, rate, bend), clock[HORIZON])
    if rate < 0 and converged and (gap <= TOUCHING * supports or time == clock[NOW]):
        return True, rate
    hold(world, body, slot, time)
    return False, rate
