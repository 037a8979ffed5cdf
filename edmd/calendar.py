"""The event queue: a tournament tree over bodies. Order is total: by time, then by body."""

from ccd.compiling import kernel


@kernel
def schedule(calendar, body, time, slot):
    """Give a body its next event: the winner of every match on the way to the root is decided again, as far as it changes."""
    times, bodies = calendar.time, calendar.body
    calendar.slot[body] = slot
    node = body + len(times) // 2
    times[node] = time
    while node > 1:
        node //= 2
        left, right = 2 * node, 2 * node + 1
        winner = left + (times[right] < times[left])         # no jump: which child wins is a toss
        if times[node] == times[winner] and bodies[node] == bodies[winner] and bodies[node] != body:
            break
        times[node] = times[winner]
        bodies[node] = bodies[winner]
