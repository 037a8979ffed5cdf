"""State, ContactTime and BézierShoot (paper, Secs. 3.2 and 3.3) on the grid of a CCD equation, and the first contact by recursive shoots.

A u with F(u, t) > 0 proves that the bodies are separate at t. A shoot holds the best u of one moment and asks how long it keeps its proof:
until the first root in t, found by Bézier clipping. The best u is the one that maximises the contact function f = u (1 - u) N / D,
which at a contact is the one that maximises F, and whose value does not depend on the common denominator of the motions.
"""

from math import inf, sqrt

from ccd.bernstein import first_root, restrict, without_root_at_start
from ccd.compiling import kernel
from ccd.grid import coefficients, held
from ccd.separation import contact_value, maximise
from ccd.status import Status
from ccd.tolerances import ARRIVED, CONCENTRIC, CONTACT_TIME_STEPS, EXACT, ROOT, SHOOT_STEPS, TOUCHING_STATE

CONTACT, NO_CONTACT, OVERLAPPING, UNRESOLVED = (int(Status.CONTACT), int(Status.NO_CONTACT), int(Status.OVERLAPPING),
                                                int(Status.UNRESOLVED))


@kernel
def best_certificate(grid, t, start):
    """f - 1 at one time in [0, 1] (State is its sign), the u that attains it, converged. start: a guess of u.

    Where the centres nearly coincide f, which is concave, is below twice its value at u = 1/2: that is enough to know.
    """
    d, n = coefficients(grid, t)
    at_half = contact_value(d, n, 0.5)
    if at_half <= CONCENTRIC:
        return at_half - 1, 0.5, True
    u, converged = maximise(d, n, start, EXACT)
    return contact_value(d, n, u) - 1, u, converged


@kernel
def state_of(excess):
    """State from f - 1: 1 separate, 0 touching, -1 overlapping."""
    return 0 if abs(excess) <= TOUCHING_STATE else 1 if excess > 0 else -1


@kernel
def slope(grid, u, t, work):
    """The derivative in t of F(u, t), times a positive number."""
    p = work[0, :grid.shape[1]]
    held(grid, u, 1.0, p)
    if len(p) == 1:
        return 0.0
    if t < 0.5:
        restrict(p, t, 1.0)
        return p[1] - p[0]
    restrict(p, 0.0, t)
    return p[len(p) - 1] - p[len(p) - 2]


@kernel
def bezier_shoot(grid, certificate, start, end, work):
    """BézierShoot(start -> end), or (end <- start) when end < start: F(u, t) is positive between start and the time returned.

    certificate: (u, level, touching). level multiplies D: 1 for the bodies themselves, less for a proof that they overlap by
    less than that. touching: F(u, start) is zero because the bodies touch there; that root is divided out. work: (2, degree + 1).
    """
    u, level, touching = certificate
    size = grid.shape[1]
    p = work[0, :size]
    held(grid, u, level, p)
    restrict(p, min(start, end), max(start, end))
    if end < start:
        for i in range(size // 2):
            p[i], p[size - 1 - i] = p[size - 1 - i], p[i]
    if touching:
        if size == 1:
            return start
        without_root_at_start(p)
        size -= 1
    s = first_root(p[:size], work[1, :size])
    return end if s == inf else start + s * (end - start)


@kernel
def contact_time(grid, low, high, low_overlaps, start):
    """ContactTime: an instant between low and high at which f = 1, when the bodies overlap at one end only. -> time, u.

    False position (Illinois) on sqrt(f) - 1, which is nearly straight, in a bracket.
    """
    sign = -1.0 if low_overlaps else 1.0
    excess, u, _ = best_certificate(grid, low, start)
    at_low = sign * (sqrt(excess + 1) - 1)
    excess, u, _ = best_certificate(grid, high, u)
    at_high = sign * (sqrt(excess + 1) - 1)
    last, time = 0, low
    for _ in range(CONTACT_TIME_STEPS):
        before = time
        time = (low * at_high - high * at_low) / (at_high - at_low)
        if not low < time < high:
            time = 0.5 * (low + high)
        excess, u, _ = best_certificate(grid, time, u)
        here = sign * (sqrt(excess + 1) - 1)
        if here == 0.0 or abs(time - before) <= ROOT or high - low <= ROOT:
            return time, u
        if here > 0:
            low, at_low = time, here
            at_high = 0.5 * at_high if last == 1 else at_high
            last = 1
        else:
            high, at_high = time, here
            at_low = 0.5 * at_low if last == -1 else at_low
            last = -1
    return time, u


@kernel
def recursive_shoot(grid, u, end, work):
    """The first contact in [0, end], end at most 1 (paper, Sec. 3.3). u: a guess of the best one at 0. -> status, time, u, shoots."""
    time = 0.0
    for shoot in range(SHOOT_STEPS):
        excess, u, converged = best_certificate(grid, time, u)
        if not converged:
            return UNRESOLVED, time, u, shoot
        touching = False
        if shoot == 0:
            if excess < -TOUCHING_STATE:
                return OVERLAPPING, 0.0, u, 0
            touching = abs(excess) <= TOUCHING_STATE
            if touching and slope(grid, u, 0.0, work) < 0:
                return CONTACT, 0.0, u, 0
        elif excess <= ARRIVED:
            return CONTACT, time, u, shoot
        reached = bezier_shoot(grid, (u, 1.0, touching), time, end, work)
        if reached >= end:
            return NO_CONTACT, inf, u, shoot + 1
        if reached - time <= ROOT * reached:
            return (UNRESOLVED if touching else CONTACT), reached, u, shoot + 1
        time = reached
    return UNRESOLVED, time, u, SHOOT_STEPS
