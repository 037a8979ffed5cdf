"""The event queue: a tournament tree over bodies. Order is total: by time, then by body."""

from math import inf

from ccd.compiling import kernel


@kernel
def schedule(calendar, body, time, slot):
    """Give a body its next event, and decide again every match on its way to the root, as far as that changes who wins."""
    times, bodies = calendar.time, calendar.body
    calendar.slot[body] = slot
    node, winner = body + len(times) // 2, body
    times[node] = time
    while node > 1:
        rival = times[node ^ 1]
        rival_wins = (rival < time) | ((rival == time) & (node & 1 == 1))           # no jump: who wins is a toss
        time, winner = rival if rival_wins else time, bodies[node ^ 1] if rival_wins else winner
        node //= 2
        if times[node] == time and bodies[node] == winner and winner != body:
            break
        times[node], bodies[node] = time, winner


@kernel
def earliest_rival(calendar, body):
    """The earliest event of all other bodies: the best of those that the body meets on its way to the root."""
    node, earliest = body + len(calendar.time) // 2, inf
    while node > 1:
        earliest = min(earliest, calendar.time[node ^ 1])
        node //= 2
    return earliest
