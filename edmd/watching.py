"""Watching a pair: one step of the certified shoot, which says that it touches, or when to look again (docs/theory.md, section 3)."""

from math import inf, sqrt

from ccd.compiling import kernel
from ccd.first_contact import holding_time
from ccd.separation import best_plane, support
from ccd.tolerances import EXACT, TOUCHING
from ccd.turning_plane import facing, following
from ccd.vectors import add, add_scaled, cross, dot, norm, scale, subtract
from edmd.flight import advance, kind_of
from edmd.pairs import (
    ball_now,
    direction_of,
    flight_now,
    hold_until,
    imaged,
    is_sphere,
    meeting_of_balls,
    pair_motion,
    record,
    size_now,
    within,
)
from edmd.state import GROWTH, HORIZON, LOOKS, NOW, PARTNER, REFINE, ROUNDING, TWIN
from edmd.tolerances import ALIGNED, CROSSED, FAR, IMMINENT, LOOK_PAST, NEWTON_STEPS, WELL_ALIGNED


@kernel
def watch(world, entry):
    """Bring a pair up to date, see whether it touches, and note when it can at the earliest. -> touches, rate of the gap, normal."""
    links, now = world.lists.links, world.clock[NOW]
    body, partner = int(links[links[entry, TWIN], PARTNER]), int(links[entry, PARTNER])
    world.tally[LOOKS] += 1
    advance(world.bodies[body], world.kinds[kind_of(world, body)], now)
    advance(world.bodies[partner], world.kinds[kind_of(world, partner)], now)
    if is_sphere(world, body) and is_sphere(world, partner):
        return _watch_balls(world, entry, ball_now(world, body), ball_now(world, partner))
    return _watch_ellipsoids(world, entry, flight_now(world, body), flight_now(world, partner))


@kernel
def _watch_balls(world, entry, own, other):
    span, gap, rate, r = meeting_of_balls(world, entry, own, other)
    now, reach = world.clock[NOW], (own[2] + other[2]) * size_now(world.clock)
    touches = rate < 0 and (gap <= TOUCHING * reach + world.clock[ROUNDING] or now + span == now)
    hold_until(world, entry, now + span)
    return touches, rate, scale(1.0 / norm(r), r)


@kernel
def _watch_ellipsoids(world, entry, own, other):
    """Find the plane that is best when the bodies come together; just before that the plane on record stays: it is near enough."""
    clock = world.clock
    now, soon = clock[NOW], IMMINENT * clock[REFINE]
    r, start = imaged(world, entry, subtract(other[0], own[0])), direction_of(world.lists, entry)
    n, lead, found, best, asked = start, 0.0, False, False, False
    for step in range(NEWTON_STEPS):
        n, tilt, lead, gap = tilted(own, other, r, n, clock)
        if gap < -CROSSED or (step == 0 and tilt > FAR):
            break
        best = tilt <= ALIGNED
        found = best or lead > soon or (tilt * tilt <= WELL_ALIGNED * gap and gap > CROSSED)
        if found:
            break
    while True:                                         # twice at most: with the pencil's plane where the other will not do
        if not found:
            n, best = plane(own, other, r, start)
            found, asked, lead = True, True, 0.0
        reach = max(LOOK_PAST * lead, LOOK_PAST * soon) if lead > 0.0 else clock[HORIZON]
        gap, rate, bend, supports = pair_motion(own, other, r, n, clock, reach)
        span = within(reach, holding_time(gap, rate, bend), bend)
        close = gap <= TOUCHING * supports + clock[ROUNDING] or now + span == now           # positions are known no better
        if asked or (gap >= 0.0 and not close) or (best and (gap >= 0.0 or lead == 0.0)):
            break
        found = False                                   # aimed ahead, it cuts into the bodies now, or it is not the best of two that touch
    touches = rate < 0 and best and close
    if touches or span > soon:              # the bound on record looks further ahead, and is less sharp
        span = max(span, record(world, entry, own, other, n))
    hold_until(world, entry, now if touches else now + span)
    return touches, rate, n


@kernel
def tilted(own, other, r, n, clock):
    """One step of Newton's method from n towards the direction that is best when the bodies come together, eq. (8b).

    -> direction, squared angle from n, time from now when that should be, gap over the sum of the supports (-1 where float64 cannot tell).
    """
    size, growth = size_now(clock), clock[GROWTH]
    spin_a, spin_b = own[2][0], other[2][0]
    face_a, face_b = facing(own[3], (size, spin_a, growth), n), facing(other[3], (size, spin_b, growth), n)
    v, supports = subtract(other[1], own[1]), size * (face_a[0] + face_b[0])
    rate = (dot(n, v) - size * (dot(face_a[1], cross(n, spin_a)) + dot(face_b[1], cross(n, spin_b))) - growth * (face_a[0] + face_b[0]))
    gap = dot(n, r) - supports
    lag, drift = add_scaled(r, -size, add(face_a[1], face_b[1])), add(add(v, face_a[3]), face_b[3])
    now, solved = following(face_a, face_b, max(gap, 0.0), n, lag)
    later, _ = following(face_a, face_b, max(gap, 0.0), n, drift)
    gap, closing, bend = gap + 0.5 * dot(now, lag), max(-rate - dot(later, lag), 0.0), max(dot(later, drift), 0.0)
    comes = gap > 0.0 and closing > 0.0
    lead = min(gap / closing, sqrt(gap / bend) if bend > 0.0 else inf, clock[HORIZON]) if comes else 0.0
    tilt = add_scaled(now, lead, later)
    turned = add(n, tilt)
    return scale(1.0 / norm(turned), turned), dot(tilt, tilt), lead, gap / supports if solved else -1.0


@kernel
def plane(own, other, r, n):
    """The best separating direction for the poses of now, and whether it converged; n: a direction near it.

    (1 - lambda) h_A = lambda h_B at the maximiser, by eq. (2): the direction says where to start.
    """
    h_a, h_b = support(own[3], n), support(other[3], n)
    n, _, converged = best_plane(own[3], other[3], r, h_a / (h_a + h_b), EXACT)
    return n, converged
