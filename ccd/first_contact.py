"""First contact of two bodies in free flight: the certified shoot, eqs. (4) to (11) of docs/theory.md.

A direction separates the bodies while the gap between its two supporting planes is positive. That gap is bounded from below by a parabola
in time whose first root is a time before which the bodies cannot touch. Go there, take the best direction again, repeat: quadratic
convergence to a regular contact (the paper's Sec. 3.3 and Appendix C), always from the safe side.

The search for a pair carries a direction that turns (turning_plane.py). The event engine, which throws most of its steps
away, holds the direction fixed: `support_course`, `bend_until` and `holding_time` are its predictor.
"""

from math import inf

from ccd.compiling import kernel
from ccd.lanes import greater, lesser, sqrt, where_less
from ccd.rotation import body_axes, turn_about
from ccd.separation import best_plane, contact_point, semi_axis_vectors, support
from ccd.status import Status
from ccd.tolerances import CANCELLING, EXACT, LAG, SHOOT_STEPS, SPHERE_MARGIN, TOUCHING
from ccd.turning_plane import facing, first_root, following, holding_span, support_series, swing
from ccd.vectors import add, add_scaled, cross, dot, norm, root_and_inverse, scale, subtract

CONTACT, NO_CONTACT, OVERLAPPING, UNRESOLVED = (int(Status.CONTACT), int(Status.NO_CONTACT), int(Status.OVERLAPPING),
                                                int(Status.UNRESOLVED))
UNDERWAY, LAGGING = -1, -2                              # of a shoot that has not ended
MOVED, CORRECTED, BEST = 0.0, 1.0, 2.0                  # how the plane of a state came about: carried on, by Newton, by the pencil


@kernel
def support_motion(s, turning, n, reach):
    """(value, rate, curvature) of a parabola in time that is nowhere below h(n) of a turning body, from now to `reach`, eqs. (5) to (7d).

    s: its semi-axis vectors; turning: see `support_course`.
    """
    course = support_course(s, turning, n)
    return course[0], course[1], bend_until(course, reach)


@kernel
def support_course(s, turning, n):
    """How h(n) of a turning body begins, and what bounds it later: (value, rate, and four more that `bend_until` takes).

    turning: (angular velocity and acceleration, half the sum of the largest and the smallest squared semi-axis, a bound on h'' for every n
    and all time, what the third derivative of h^2 over 6 may have above what is taken of it, and a bound on the fourth over 24). No sine,
    no cosine.
    """
    spin, acceleration, middle, bend, third, fourth = turning
    p, q, w = dot(s[0], n), dot(s[1], n), dot(s[2], n)
    seen = cross(n, spin)
    bent = cross(n, acceleration)
    twice = add(cross(seen, spin), bent)
    dp, dq, dw = dot(s[0], seen), dot(s[1], seen), dot(s[2], seen)
    ddp, ddq, ddw = dot(s[0], twice), dot(s[1], twice), dot(s[2], twice)
    h, over = root_and_inverse(p * p + q * q + w * w)
    half_rate = p * dp + q * dq + w * dw
    rate = half_rate * over
    second = dp * dp + dq * dq + dw * dw + p * ddp + q * ddq + w * ddw - rate * rate
    third += dp * ddp + dq * ddq + dw * ddw - (1 / 3) * dot(spin, spin) * half_rate - middle * dot(seen, bent)
    return h, rate, second, third, fourth, bend


@kernel
def bend_until(course, reach):
    """A bound on the curvature of h in time, up to `reach`: the local one where h surely keeps half its value."""
    h, rate, second, third, fourth, bend = course
    later = h + rate * reach
    over = second + greater(reach * (third + reach * fourth), 0.0)
    return where_less(0.5 * h, later, lesser(bend, greater(over / h, over / where_less(0.5 * h, later, later, h))), bend)


@kernel
def grown(motion, size, growth, horizon):
    """`support_motion` of the same body with semi-axes times size + growth * time, a bound up to the horizon, eq. (11)."""
    value, rate, bend = motion
    extra = 2 * growth * rate + greater(growth * bend, 0.0) * horizon
    return size * value, size * rate + growth * value, size * bend + extra


@kernel
def gap_motion(n, r, velocity, motion_a, motion_b):
    """(gap, rate, bend): the gap of direction n is at least gap + rate t - bend t^2 / 2, eqs. (4), (5) and (8)."""
    return (dot(n, r) - motion_a[0] - motion_b[0],
            dot(n, velocity) - motion_a[1] - motion_b[1],
            motion_a[2] + motion_b[2])


@kernel
def holding_time(gap, rate, bend):
    """How long gap + rate t - bend t^2 / 2 stays positive at least, eq. (8). inf when it always does."""
    return first_root(max(gap, 0.0), rate, bend)


@kernel
def meeting_window(r, velocity, reach, growing, t_max):
    """When two bounding spheres overlap within [0, t_max], a little widened: (begin, end); begin > t_max for never, eq. (9b).

    reach: sum of the radii at t = 0; growing: its rate.
    """
    distance = norm(r)
    reach += SPHERE_MARGIN * reach + 4 * CANCELLING * distance
    apart = (distance - reach) * (distance + reach)
    closing = dot(r, velocity) - reach * growing
    opening = dot(velocity, velocity) - growing * growing
    passing = cross(r, velocity)
    offset = add_scaled(scale(reach, velocity), -growing, r)
    square = dot(offset, offset) - dot(passing, passing)
    if apart > 0 and (square < 0 or (closing >= 0 and opening >= 0)):
        return inf, inf
    root = sqrt(max(square, 0.0))
    begin = apart / (root - closing) if apart > 0 else 0.0
    if opening <= 0:
        return begin, t_max
    return begin, min(t_max, (root - closing) / opening if closing < 0 else -apart / (root + closing))


@kernel
def scaled(size, s):
    return scale(size, s[0]), scale(size, s[1]), scale(size, s[2])


@kernel
def launch(a, b, t_max):
    """Two flights as the shoot takes them. -> status, body A, body B, (start, velocity, end), state.

    A flight is (semi_axes, centre, orientation, velocity, angular_velocity, growth_rate): tuples and a number. A body: (semi_axes,
    spin axis, spin rate, growth_rate, `swing`). start: from A to B at t = 0. State: what `advance` changes.
    """
    axes_a, centre_a, turn_a, velocity_a, _, growth_a = a
    axes_b, centre_b, turn_b, velocity_b, _, growth_b = b
    start, velocity = subtract(centre_b, centre_a), subtract(velocity_b, velocity_a)
    radius_a, radius_b = max(axes_a), max(axes_b)
    time, end = meeting_window(start, velocity, radius_a + radius_b, radius_a * growth_a + radius_b * growth_b, t_max)
    status = OVERLAPPING if norm(start) == 0 else NO_CONTACT if time >= end else UNDERWAY
    state = (turn_a, turn_b, add_scaled(start, time, velocity), time, time, end, MOVED)
    return status, _launched(a), _launched(b), (start, velocity, end), state


@kernel
def _launched(flight):
    semi_axes, _, orientation, _, spin, growth = flight
    rate = norm(spin)
    axis = scale(1.0 / max(rate, 1e-300), spin)
    return semi_axes, axis, rate, growth, swing(semi_axis_vectors(semi_axes, body_axes(orientation)), axis, rate)


@kernel
def advance(a, b, course, state):
    """One pass of the shoot: a step in time, or where the plane lags behind the best one, a step of Newton to it. -> status, new state.

    UNDERWAY: go on. LAGGING: go on from `maximised`. Any other status ends the shoot, and the state is that of the end. No branch.
    """
    semi_axes_a, axis_a, rate_a, growth_a, swing_a = a
    semi_axes_b, axis_b, rate_b, growth_b, swing_b = b
    start, velocity, end = course
    turn_a, turn_b, n, time, ahead, guess, plane = state
    turn_a, turn_b = turn_about(turn_a, axis_a, rate_a * ahead), turn_about(turn_b, axis_b, rate_b * ahead)
    s_a, s_b = semi_axis_vectors(semi_axes_a, body_axes(turn_a)), semi_axis_vectors(semi_axes_b, body_axes(turn_b))
    flight_a, flight_b = (1 + growth_a * time, scale(rate_a, axis_a), growth_a), (1 + growth_b * time, scale(rate_b, axis_b), growth_b)
    r = add_scaled(start, time, velocity)
    n = scale(1.0 / norm(n), n)
    face_a, face_b = facing(s_a, flight_a, n), facing(s_b, flight_b, n)
    supports = flight_a[0] * face_a[0] + flight_b[0] * face_b[0]
    gap = dot(n, r) - supports
    gap_now, slack = max(gap, 0.0), TOUCHING * supports
    lag = add_scaled(add_scaled(r, -flight_a[0], face_a[1]), -flight_b[0], face_b[1])
    towards, solved = following(face_a, face_b, gap_now, n, lag)
    near = solved & (gap >= -slack) & (dot(lag, towards) <= max(LAG * gap, slack))
    lags = (plane != BEST) & (not near)

    m, _ = following(face_a, face_b, gap_now, n, add(velocity, add(face_a[3], face_b[3])))
    series_a, series_b = support_series(face_a, flight_a, n, m), support_series(face_b, flight_b, n, m)
    rate = dot(n, velocity) + dot(m, r) - series_a[0] - series_b[0]
    span = holding_span((gap_now, rate, 2 * dot(m, velocity), norm(m)), (series_a, swing_a), (series_b, swing_b), end - time, guess)

    met = (rate < 0) & ((gap <= slack) | (time + span == time))
    inside = (time == 0) & (gap < -slack)
    arrived = OVERLAPPING if inside else CONTACT if met else NO_CONTACT if time + span > end else UNDERWAY
    status = (UNDERWAY if plane == MOVED else LAGGING) if lags else arrived
    moves = (status == UNDERWAY) & (not lags)
    step, correct = span if moves else 0.0, 1.0 if status == UNDERWAY else 0.0
    n = add_scaled(add_scaled(n, step, m), correct, towards)
    return status, (turn_a, turn_b, n, time + step, step, 2 * step if moves else guess, MOVED if moves else CORRECTED)


@kernel
def maximised(a, b, course, state):
    """The state with the best plane of its time, by the pencil. -> converged, state."""
    turn_a, turn_b, n, time, ahead, guess, _ = state
    s_a, s_b, r = _standing(a, b, course, state)
    h_a, h_b = support(s_a, n), support(s_b, n)
    n, _, converged = best_plane(s_a, s_b, r, h_a / (h_a + h_b), EXACT)
    return converged, (turn_a, turn_b, n, time, ahead, guess, BEST)


@kernel
def _standing(a, b, course, state):
    """Semi-axis vectors of both bodies, and r, at the time of the state."""
    size_a, size_b = 1 + a[3] * state[3], 1 + b[3] * state[3]
    return (scaled(size_a, semi_axis_vectors(a[0], body_axes(state[0]))), scaled(size_b, semi_axis_vectors(b[0], body_axes(state[1]))),
            add_scaled(course[0], state[3], course[1]))


@kernel
def free_flight_contact(a, b, t_max):
    """First contact of two free flights (see `launch`) in [0, t_max]. -> status, time, unit normal from A to B, contact point, steps."""
    status, body_a, body_b, course, state = launch(a, b, t_max)
    steps = 0
    while status == UNDERWAY and steps < SHOOT_STEPS:
        status, state = advance(body_a, body_b, course, state)
        steps += 1
        if status == LAGGING:
            converged, state = maximised(body_a, body_b, course, state)
            status = UNDERWAY if converged else UNRESOLVED
    _, _, n, time, _, _, _ = state
    if status == UNDERWAY:
        return UNRESOLVED, time, n, a[1], SHOOT_STEPS
    if status == NO_CONTACT:
        return NO_CONTACT, inf, n, a[1], steps
    if steps == 0:                                                      # concentric
        return OVERLAPPING, time, n, a[1], 0
    s_a, s_b, r = _standing(body_a, body_b, course, state)
    return status, time, n, contact_point(add_scaled(a[1], time, a[3]), s_a, r, s_b, n), steps
