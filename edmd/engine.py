"""The loop. One event reads as one sentence: take the earliest, look at it, collide, predict again."""

from ccd.compiling import kernel
from edmd.collision import collide
from edmd.couple import set_turning_of_both
from edmd.events import Ended, EventKind
from edmd.neighbors import DONE, escape, set_escapes
from edmd.pairs import rounded, turn_plane
from edmd.prediction import predict, reschedule
from edmd.prefetch import fetch_collision, fetch_event, fetch_next, fetch_pair, fetch_surroundings
from edmd.state import (
    BEGIN,
    COLLISIONS,
    COUNT,
    ENOUGH,
    EVENT,
    EVENTS,
    FAINT,
    INSTANT,
    LATEST,
    LOOKS,
    NEXT_EPOCH,
    NOW,
    PARTNER,
    SLOT,
    STANDING,
    WATCHED,
)
from edmd.tolerances import EVENTS_AT_ONCE, FAINT_COLLISIONS, FETCHED_AHEAD, FOREVER, STALL_EVENTS
from edmd.watching import touching, watch

ESCAPE = int(EventKind.ESCAPE)
TIME, COLLISIONS_REACHED, EPOCH, PAUSED, STALLED, AT_REST = (int(Ended.TIME), int(Ended.COLLISIONS), int(Ended.EPOCH),
                                                             int(Ended.PAUSED), int(Ended.STALLED), int(Ended.AT_REST))


@kernel
def advance_events(world, until_time, until_collisions):
    """Treat events in order until a time (counted from the epoch) or a number of collisions. -> why it ended, see `Ended`."""
    calendar, lists, clock, tally = world.calendar, world.lists, world.clock, world.tally
    ahead = len(world.bodies) >= FETCHED_AHEAD
    patience = STALL_EVENTS + 100 * len(world.bodies)
    for _ in range(EVENTS_AT_ONCE):
        if tally[COLLISIONS] >= until_collisions:
            return COLLISIONS_REACHED
        if tally[COLLISIONS] >= tally[NEXT_EPOCH] or tally[LOOKS] >= tally[ENOUGH]:
            return EPOCH
        time, body = calendar.time[0], int(calendar.body[0])
        if time > until_time and (until_time <= clock[LATEST] or time >= FOREVER):
            if until_time >= FOREVER:
                return AT_REST
            clock[NOW] = until_time
            return TIME
        if time > clock[LATEST]:
            clock[NOW] = max(clock[LATEST], clock[NOW])
            return EPOCH
        tally[STANDING] = tally[STANDING] + 1 if time <= clock[NOW] + clock[INSTANT] else 0
        if tally[STANDING] > patience or tally[FAINT] > FAINT_COLLISIONS:
            return STALLED
        clock[NOW] = max(time, clock[NOW])
        tally[EVENTS] += 1
        then = fetch_next(world, body) if ahead else body
        slot, partner, watched, tally[WATCHED] = int(lists.spans[body, SLOT]), body, 0, 0
        entry = int(lists.spans[body, BEGIN]) + slot
        fetch_surroundings(world, body)
        if slot == ESCAPE:
            status = escape(world, body)
            if status != DONE:
                return status
        elif slot < lists.spans[body, COUNT] and lists.numbers[entry, EVENT] == time:
            partner = int(lists.links[entry, PARTNER])
            fetch_pair(world, entry, body, partner)
            touches, n = touching(world, entry, body, partner)
            if touches:
                fetch_collision(world, body, partner, ahead)
                collide(world, body, partner, n)
                turn_plane(world, entry, rounded(n))
                set_turning_of_both(world, body, partner)
                set_escapes(world, body, partner)
                for one in (body, partner):
                    predict(world, one)
            else:
                world.watched[0], tally[WATCHED], partner = entry, 1, body
        while watched < tally[WATCHED]:
            entry = int(world.watched[watched])
            watch(world, entry, body if 0 <= entry - lists.spans[body, BEGIN] < lists.spans[body, COUNT] else partner)
            watched += 1
        if ahead:
            fetch_event(world, then)
        reschedule(world, body)
        if partner != body:
            reschedule(world, partner)
    return PAUSED
