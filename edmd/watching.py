"""Watching a pair: the certified shoot, which says when it can touch at the earliest (docs/theory.md, section 3). It moves no body."""

from math import inf

from ccd.compiling import kernel
from ccd.first_contact import holding_time
from ccd.lanes import abreast, absolute, first, first_of, second_of, sqrt, total, total_of
from ccd.separation import best_plane_of
from ccd.tolerances import EXACT, TOUCHING
from ccd.turning_plane import leaning, times
from ccd.vectors import add, add_scaled, cross, dot, load, norm, root_and_inverse, scale, store, subtract
from edmd.couple import flights_of
from edmd.flight import course, face_of, shape_of
from edmd.pairs import (
    ball_now,
    direction_of,
    hold_until,
    imaged,
    is_met,
    is_sphere,
    meeting_of_balls,
    record,
    rounded,
    set_met,
    size_at,
    size_now,
    support_until,
    within,
)
from edmd.state import GROWTH, HORIZON, LOOKS, MET, MET_SINCE, MET_TIME, NOW, PARTNER, REFINE, ROUNDING, TIME
from edmd.tolerances import ALIGNED, ALMOST, CROSSED, FAR, GRAZING, IMMINENT, LOOK_PAST, NEWTON_STEPS, PRESSED, SHOTS, WELL_ALIGNED

NEWTON, AIMED, BEST = range(3)          # ways to a plane, each for where the one before will not do
UNKNOWN = -1.0                          # a gap where float64 cannot tell


@kernel
def watch(world, entry, body):
    """Note when a body and one on its list can touch at the earliest; a contact that is near, and its normal, to the last digits."""
    partner = int(world.lists.links[entry, PARTNER])
    if is_sphere(world, body) and is_sphere(world, partner):
        world.tally[LOOKS] += 1
        span, _, _, _ = meeting_of_balls(world, entry, ball_now(world, body), ball_now(world, partner))
        hold_until(world, entry, world.clock[NOW] + span)
    else:
        hold_until(world, entry, _shoot(world, entry, body, partner))


@kernel
def touching(world, entry, body, partner):
    """Whether a pair whose time has come touches, and the normal: two balls do; other bodies where a shoot has found them to."""
    if is_sphere(world, body) and is_sphere(world, partner):
        world.tally[LOOKS] += 1
        span, gap, rate, r = meeting_of_balls(world, entry, ball_now(world, body), ball_now(world, partner))
        now, reach = world.clock[NOW], ball_now(world, body)[2] + ball_now(world, partner)[2]
        close = gap <= TOUCHING * reach * size_now(world.clock) + world.clock[ROUNDING] or now + span == now
        return rate < 0 and close, scale(1.0 / norm(r), r)
    turn = world.turns[body]
    known = is_met(world, entry, body) and turn[MET_TIME] == world.clock[NOW] and turn[MET_SINCE] == world.bodies[partner, TIME]
    return known, load(turn, MET)


@kernel
def _shoot(world, entry, body, partner):
    """By planes that are best when the bodies come together, up to the contact where that is near. -> until when they do not touch."""
    clock = world.clock
    time, growth, soon, n = clock[NOW], clock[GROWTH], IMMINENT * clock[REFINE], direction_of(world.lists, entry)
    for shot in range(SHOTS):
        world.tally[LOOKS] += 1
        pair, size, start = flights_of(world, body, partner, time), size_at(clock, time), n
        r = imaged(world, entry, subtract(second_of(pair.position), first_of(pair.position)))
        velocity = subtract(second_of(pair.velocity), first_of(pair.velocity))
        for way in range(3):
            best, lead, apart, found = True, 0.0, 0.0, True
            if way != NEWTON:
                n, best = _plane(pair, r, start)
            if way != BEST:
                n, best, lead, apart, found = _aimed(pair, r, n, (size, growth, clock[HORIZON], soon))
                if not found:
                    continue
            recorded = shot == 0 and apart > GRAZING and (lead > soon or lead == 0.0)
            if recorded:
                n = rounded(n)
            seen = course(pair, n)
            reach = LOOK_PAST * max(lead, soon) if lead > 0.0 else clock[HORIZON]
            supports, rising, bend = total_of(support_until(seen, size, growth, reach))
            gap, rate, touch = dot(n, r) - supports, dot(n, velocity) - rising, TOUCHING * supports
            give = PRESSED * touch + 4 * clock[ROUNDING]
            touch += clock[ROUNDING]                                                  # positions are known no better
            room = gap + give if gap <= touch and rate * rate <= 4 * bend * give else gap       # a bounce no higher than that, eq. (13c)
            span = within(reach, holding_time(room, rate, bend), bend)
            close = room <= touch or time + span == time
            if (gap >= 0.0 and not close) or (best and (gap >= 0.0 or lead == 0.0)):
                break                                   # else, aimed ahead, it cuts into the bodies now, or two that touch need the best
        stiff = bend + 2 * (size * total(pair.turning[3]) + abs(growth) * total(absolute(seen[1])))
        if rate < 0 and best and not recorded and (close or stiff * span * span <= touch):      # that bounds the gap at the end of the span
            time += 0.0 if close else span
            turn = world.turns[body]
            set_met(world, entry, body)
            store(turn, MET, n)
            turn[MET_TIME], turn[MET_SINCE] = time, world.bodies[partner, TIME]
            return time
        if recorded:                                    # the bound on record looks further ahead, and is less sharp
            span = max(span, record(world, entry, pair, n, seen))
        time += span
        if span > soon or time > clock[NOW] + soon:
            break
    return time


@kernel
def _aimed(pair, r, n, scales):
    """Newton's method from n to the direction that is best when the bodies come together; just before that, to one near enough.

    scales: (size, growth, horizon, a time that is soon). -> direction, whether it is the best one to the last digits, time to the contact,
    gap over the supports, whether the direction was found.
    """
    best, lead, gap = False, 0.0, 0.0
    for step in range(NEWTON_STEPS):
        n, tilt, lead, gap = tilted(pair, r, n, scales)
        if gap == UNKNOWN or tilt > FAR or (step > 0 and gap < -CROSSED):
            break
        best = tilt <= ALIGNED
        if best or lead > scales[3] or (lead > ALMOST * scales[3] and tilt * tilt <= WELL_ALIGNED * gap and gap > CROSSED):
            return n, best, lead, gap, True
    return n, best, lead, gap, False


@kernel
def tilted(pair, r, n, scales):
    """One step of Newton's method from n towards the direction that is best when the bodies come together, eq. (8d).

    scales: as for `_aimed`. -> direction, squared angle from n, time until that should be, gap over the sum of the supports or UNKNOWN.
    """
    size, growth, horizon, _ = scales
    h, c, curvature, drifts, _ = face_of(pair, size, growth, n)
    supports, v = total(h), subtract(second_of(pair.velocity), first_of(pair.velocity))
    rate = dot(n, v) - size * total(dot(c, cross(n, pair.turning[0]))) - growth * supports
    supports *= size
    gap = dot(n, r) - supports
    lag, drift = add_scaled(r, -size, total_of(c)), add(v, total_of(drifts))
    k = total_of(curvature[:3]) + total_of(curvature[3:])
    steps, solved = leaning(k, max(gap, 0.0), n, abreast(lag, drift))
    now, later = first_of(steps), second_of(steps)
    gap, closing, bend = gap + 0.5 * dot(now, lag), max(-rate - dot(later, lag), 0.0), max(dot(later, drift), 0.0)
    comes = gap > 0.0 and closing > 0.0
    lead = min(gap / closing, sqrt(gap * bend) * (1.0 / bend) if bend > 1e-300 else inf, horizon) if comes else 0.0
    tilt = add_scaled(now, lead, later)
    turned = add(n, tilt)
    _, over = root_and_inverse(dot(turned, turned))
    return scale(over, turned), dot(tilt, tilt), lead, gap / supports if solved else UNKNOWN


@kernel
def _plane(pair, r, n):
    """The best separating direction for these poses, and whether it converged; n: a direction near it.

    (1 - lambda) h_A = lambda h_B at the maximiser, by eq. (2): the direction says where to start.
    """
    x = shape_of(pair)
    h = sqrt(dot(times(x, n), n))
    a, b = first_of(x[:3]) + first_of(x[3:]), second_of(x[:3]) + second_of(x[3:])
    n, _, converged = best_plane_of(a, b, r, first(h) / total(h), EXACT)
    return n, converged
