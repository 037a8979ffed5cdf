"""The event queue: a tournament over bodies, eight to a match. Order is total: by time, then by body.

The rounds stand one behind the other, the last one first, each match in one cache line: place k of the first round belongs to body k, and
each later place to the winner of a match, which `calendar.body` tells.
"""

from math import inf

from ccd.compiling import kernel

WAYS = 8


@kernel
def schedule(calendar, body, time):
    """Give a body its next event, and decide again every match on its way to the top, as far as that changes who wins."""
    times, bodies, rounds = calendar.time, calendar.body, calendar.rounds
    place = body
    times[rounds[0] + place] = time
    for k in range(len(rounds) - 1):
        match = place // WAYS
        first, above = rounds[k] + match * WAYS, rounds[k + 1] + match
        earliest, winner = _earliest(times, first)
        winner = whose(calendar, first + winner)
        if times[above] == earliest and bodies[above] == winner and winner != body:
            break
        times[above], bodies[above], place = earliest, winner, match


@kernel
def whose(calendar, place):
    """The body that a place belongs to."""
    first = int(calendar.rounds[0])
    return place - first if place >= first else int(calendar.body[place])


@kernel
def _earliest(times, first):
    """The earliest of a match, and its place."""
    return _winner((times[first], times[first + 1], times[first + 2], times[first + 3],
                    times[first + 4], times[first + 5], times[first + 6], times[first + 7]))


@kernel
def earliest_but(times, first, one):
    """`_earliest` of all but one place. Number by number, as they were written: a vector of them would wait until they are in the cache."""
    return _winner((_but(times, first, 0, one), _but(times, first, 1, one), _but(times, first, 2, one), _but(times, first, 3, one),
                    _but(times, first, 4, one), _but(times, first, 5, one), _but(times, first, 6, one), _but(times, first, 7, one)))


@kernel
def _winner(times):
    """The earliest of eight, and which: of equal ones the first. No jump: who wins is a toss."""
    a, i = _earlier(times[0], 0, times[1], 1)
    b, j = _earlier(times[2], 2, times[3], 3)
    c, k = _earlier(times[4], 4, times[5], 5)
    d, m = _earlier(times[6], 6, times[7], 7)
    a, i = _earlier(a, i, b, j)
    c, k = _earlier(c, k, d, m)
    return _earlier(a, i, c, k)


@kernel
def _but(times, first, place, one):
    return times[first + place] if place != one else inf


@kernel
def _earlier(time, place, other_time, other_place):
    other = other_time < time
    return other_time if other else time, other_place if other else place
