"""All maximal separation and overlapping intervals of two moving ellipsoids (paper, Sec. 3.2, Algorithms 1 to 3) on a CCD equation's grid.

Candidate intervals wait on a stack, the earliest on top, so that the pieces come out in order of time. A candidate separation interval
(CSI) is cut by Bézier shoots from both ends, a candidate overlapping interval (COI) is confirmed when F has no loop in it.
What Remarks 3 and 4 of the paper settle with a small epsilon is said here: an interval throughout which |f - 1| <= TOUCHING_STATE is
proved is TOUCHING (a tangential contact), and one that is too narrow to be decided is UNRESOLVED.
"""

from math import inf, nan

import numpy as np

from ccd.bernstein import hull_crossing, restrict
from ccd.bezier_shoot import best_certificate, bezier_shoot, contact_time, slope, state_of
from ccd.compiling import kernel
from ccd.grid import quartic
from ccd.status import State
from ccd.tolerances import CANDIDATES, CLIPS_WELL, CONTACT_TIME_STEPS, LOOP_ROUNDS, NARROW, ROOT, SIDE, STRIP, TANGENT, TOUCHING_STATE

SEPARATE, TOUCHING, OVERLAPPING, UNRESOLVED = int(State.SEPARATE), int(State.TOUCHING), int(State.OVERLAPPING), int(State.UNRESOLVED)
CSI, COI, KNOWN = 0.0, 1.0, 2.0         # what waits on the stack; KNOWN: already confirmed to be separate
ASIDE = 0.375                           # where a candidate is divided whose middle is a contact
STACK = (512, 5)                        # rows: start, end, kind, and whether the bodies touch at start and at end
PIECES = (512, 3)                       # rows: start, end, State


def empty_work(degree):
    """Working space for `separation_intervals`, and for what it calls."""
    return np.empty((14, max(degree + 1, 5)))


@kernel
def _positive_range(largest):
    """Where in [0, 1] the upper hull of control points is above zero. -> low, high; low is inf for nowhere."""
    return hull_crossing(largest, -1.0, False), 1 - hull_crossing(largest, -1.0, True)


@kernel
def _monotonic(f):
    """Whether the control points of F_t have one sign."""
    rising = falling = False
    for i in range(f.shape[0]):
        for j in range(f.shape[1] - 1):
            step = f[i, j + 1] - f[i, j]
            rising, falling = rising or step > 0, falling or step < 0
    return not (rising and falling)


@kernel
def _strip_has_no_loop(f, work):
    """`has_no_loop` for the part of F whose control points are given. What can be cut off is, until little comes off."""
    largest_u, largest_t = work[12, :5], work[13, :f.shape[1]]
    for _ in range(LOOP_ROUNDS):
        for i in range(5):
            largest_u[i] = -inf
        for j in range(f.shape[1]):
            largest_t[j] = max(max(max(f[0, j], f[1, j]), max(f[2, j], f[3, j])), f[4, j])
            for i in range(5):
                largest_u[i] = max(largest_u[i], f[i, j])
        u_low, u_high = _positive_range(largest_u)
        if u_low == inf or _monotonic(f):
            return True
        t_low, t_high = _positive_range(largest_t)
        if u_high - u_low > CLIPS_WELL and t_high - t_low > CLIPS_WELL:
            return False
        for i in range(5):
            restrict(f[i], t_low, t_high)
        for j in range(f.shape[1]):
            restrict(f[:, j], u_low, u_high)
    return False


@kernel
def has_no_loop(grid, start, end, level, work):
    """Whether F, not positive at start and end, is proved not to be positive between them (paper, Sec. 3.2, COI handling).

    Either all control points are negative, or F_t has one sign in the sub-region where F can be positive, found by cutting
    off what lies outside the hull of the control points, in u and in t. Where that comes to a halt u is divided into strips: F_t may
    have another sign in each. In u / (1 - u) = odds u' / (1 - u'), which only rescales control points, the best u is in the middle, however
    different the bodies. level: as for `bezier_shoot`.
    """
    f, strip = work[2:7, :grid.shape[1]], work[7:12, :grid.shape[1]]
    quartic(grid, level, f)
    _, u, _ = best_certificate(grid, 0.5 * (start + end), 0.5)
    odds, scale = u / (1 - u), 1.0
    for i in range(5):
        for j in range(f.shape[1]):
            f[i, j] *= scale
        scale *= odds
        restrict(f[i], start, end)
    low, width = 0.0, 1.0
    while low < 1:
        for j in range(f.shape[1]):
            for i in range(5):
                strip[i, j] = f[i, j]
            restrict(strip[:, j], low, low + width)
        if _strip_has_no_loop(strip, work):
            low += width
            width = min(2 * width, 1 - low)
        elif width <= STRIP:
            return False
        else:
            width *= 0.5
    return True


@kernel
def _is_touching(grid, start, end, u, work):
    """Whether |f - 1| <= 2 TOUCHING_STATE is proved for all of [start, end], by the u that is best in its middle."""
    middle = 0.5 * (start + end)
    return (bezier_shoot(grid, (u, 1 - 2 * TOUCHING_STATE, False), middle, end, work) >= end
            and bezier_shoot(grid, (u, 1 - 2 * TOUCHING_STATE, False), middle, start, work) <= start
            and has_no_loop(grid, start, end, 1 + 2 * TOUCHING_STATE, work))


@kernel
def _state_beside(grid, time, direction, u):
    """State at an end of the span, or beside it when the bodies touch there (Remark 3). -> state, touching at the end itself, u."""
    excess, u, _ = best_certificate(grid, time, u)
    state = state_of(excess)
    if state != 0:
        return state, False, u
    step = SIDE
    while step < 0.1 and state == 0:
        excess, _, _ = best_certificate(grid, time + direction * step, u)
        state = state_of(excess)
        step *= 8
    return state, True, u


@kernel
def _push(stack, top, start, end, kind, touching):
    stack[top, 0], stack[top, 1], stack[top, 2] = start, end, kind
    stack[top, 3], stack[top, 4] = touching
    return top + 1


@kernel
def _emit(pieces, count, start, end, state):
    """Add a piece, or lengthen the last one when the state goes on."""
    if end <= start:
        return count
    if count > 0 and pieces[count - 1, 2] == state:
        pieces[count - 1, 1] = end
        return count
    pieces[count, 0], pieces[count, 1], pieces[count, 2] = start, end, state
    return count + 1


@kernel
def _initialise(grid, stack):
    """Algorithm 1: [0, 1] as a CSI, a COI, or one of each divided at a contact instant. -> number of candidates."""
    first, touching_first, u = _state_beside(grid, 0.0, 1.0, 0.5)
    last, touching_last, _ = _state_beside(grid, 1.0, -1.0, u)
    if first * last >= 0:
        kind = COI if first < 0 or last < 0 else CSI
        return _push(stack, 0, 0.0, 1.0, kind, (touching_first, touching_last))
    time, u = contact_time(grid, 0.0, 1.0, first < 0, u)
    top = _push(stack, 0, time, 1.0, COI if last < 0 else CSI, (True, touching_last))
    return _push(stack, top, 0.0, time, COI if first < 0 else CSI, (touching_first, True))


@kernel
def separation_intervals(grid, pieces, stack, work):
    """Fill in pieces (capacity, 3): start, end, State, in order of time over [0, 1]. -> how many. work: `empty_work`."""
    top, count, u = _initialise(grid, stack), 0, 0.5
    for step in range(CANDIDATES + 1):
        if top == 0:
            break
        top -= 1
        start, end, kind = stack[top, 0], stack[top, 1], stack[top, 2]
        touching, touching_end = stack[top, 3] > 0, stack[top, 4] > 0
        if step == CANDIDATES or count >= pieces.shape[0] - 4 or top >= stack.shape[0] - 5:
            return _emit(pieces, count, start, 1.0, UNRESOLVED)
        if kind == KNOWN:
            count = _emit(pieces, count, start, end, SEPARATE)
            continue
        left, right = start, end
        if kind == CSI:
            _, u, _ = best_certificate(grid, start, u)
            left = bezier_shoot(grid, (u, 1 + TOUCHING_STATE, touching), start, end, work)
            if left < end:
                _, u, _ = best_certificate(grid, end, u)
                right = bezier_shoot(grid, (u, 1 + TOUCHING_STATE, touching_end), end, start, work)
            if left >= right:
                count = _emit(pieces, count, start, end, SEPARATE)
                continue
            count = _emit(pieces, count, start, left, SEPARATE)
            top = _push(stack, top, right, end, KNOWN, (False, touching_end)) if right < end else top
        elif has_no_loop(grid, start, end, 1 - TOUCHING_STATE, work):
            count = _emit(pieces, count, start, end, OVERLAPPING)
            continue
        middle = 0.5 * (left + right)
        excess, u, converged = best_certificate(grid, middle, u)
        state = state_of(excess)
        at_left, at_right = touching and left == start, touching_end and right == end
        if state == 0 and (right - left <= NARROW or _is_touching(grid, left, right, u, work)):
            beside_contact = (at_left or at_right) and right - left <= TANGENT      # the last bit of a regular contact's approach
            state = TOUCHING if not beside_contact else SEPARATE if kind == CSI else OVERLAPPING
            count = _emit(pieces, count, left, right, state)
            continue
        if state == 0:                          # divided at a tangential contact, neither part would have it inside
            middle = left + ASIDE * (right - left)
            excess, u, converged = best_certificate(grid, middle, u)
            state = state_of(excess)
        if not converged or right - left <= NARROW:
            count = _emit(pieces, count, left, right, UNRESOLVED)
        elif state != 0 and (state < 0) == (kind == CSI):
            first, _ = contact_time(grid, left, middle, kind == COI, u)
            second, _ = contact_time(grid, middle, right, kind == CSI, u)
            top = _push(stack, top, second, right, kind, (True, at_right))
            top = _push(stack, top, first, second, COI if kind == CSI else CSI, (True, True))
            top = _push(stack, top, left, first, kind, (at_left, True))
        else:
            top = _push(stack, top, middle, right, kind, (False, at_right))
            top = _push(stack, top, left, middle, kind, (at_left, False))
    return count


@kernel
def _falls(grid, t, u, work):
    _, u, _ = best_certificate(grid, t, u)
    return slope(grid, u, t, work) < 0


@kernel
def tangent_instant(grid, start, end, work):
    """The instant of contact in a TOUCHING piece: when max F turns from falling to rising, or back. nan when the piece is not narrow."""
    if end - start > TANGENT:
        return nan
    falls_first = _falls(grid, start, 0.5, work)
    for _ in range(CONTACT_TIME_STEPS):
        middle = 0.5 * (start + end)
        if _falls(grid, middle, 0.5, work) == falls_first:
            start = middle
        else:
            end = middle
        if end - start <= ROOT:
            break
    return 0.5 * (start + end)
