"""First contact of two bodies in free flight: the certified shoot, eqs. (4) to (11) of docs/theory.md.

A direction separates the bodies while the gap between its two supporting planes is positive. That gap is bounded from below by a parabola
in time whose first root is a time before which the bodies cannot touch. Go there, take the best direction again, repeat: quadratic
convergence to a regular contact (the paper's Sec. 3.3 and Appendix C), always from the safe side.

The search for a pair carries a direction that turns (turning_plane.py). The event engine, which takes one step at a time and throws most of
them away, holds the direction fixed: `support_motion`, `gap_motion` and `holding_time` are its predictor.
"""

from math import inf, sqrt

from ccd.compiling import kernel
from ccd.rotation import body_axes, turn
from ccd.separation import best_plane, contact_point, semi_axis_vectors
from ccd.status import Status
from ccd.tolerances import CANCELLING, EXACT, LAG, SHOOT_STEPS, SPHERE_MARGIN, TOUCHING
from ccd.turning_plane import facing, following, holding_span, support_series, swing
from ccd.vectors import add, add_scaled, cross, dot, norm, scale, subtract

CONTACT, NO_CONTACT, OVERLAPPING, UNRESOLVED = (int(Status.CONTACT), int(Status.NO_CONTACT), int(Status.OVERLAPPING),
                                                int(Status.UNRESOLVED))


@kernel
def curvature(semi_axes, angular_velocity):
    """A bound on h'' of a turning body for every n and all time, eq. (7) with h >= a_min."""
    smallest, largest = min(semi_axes), max(semi_axes)
    return dot(angular_velocity, angular_velocity) * (largest * largest - smallest * smallest) / smallest


@kernel
def support_motion(s, angular_velocity, bend, n, age):
    """(value, rate, curvature) of a parabola in time that is nowhere below h(n) of a turning body, eqs. (5) and (7).

    The semi-axis vectors s are those of `age` ago; the parabola's time counts from now. bend: the body's `curvature`.
    No sine, no cosine.
    """
    p, q, w = dot(s[0], n), dot(s[1], n), dot(s[2], n)
    h = sqrt(p * p + q * q + w * w)
    turning = cross(n, angular_velocity)
    rate = (p * dot(s[0], turning) + q * dot(s[1], turning) + w * dot(s[2], turning)) / h
    return h + age * (rate + 0.5 * age * bend), rate + age * bend, bend


@kernel
def grown(motion, size, growth, horizon):
    """`support_motion` of the same body with semi-axes times size + growth * time, a bound up to the horizon, eq. (11)."""
    value, rate, bend = motion
    extra = 2 * growth * rate + max(growth, 0.0) * horizon * bend
    return size * value, size * rate + growth * value, max(size * bend + extra, 0.0)


@kernel
def gap_motion(n, r, velocity, motion_a, motion_b):
    """(gap, rate, bend): the gap of direction n is at least gap + rate t - bend t^2 / 2, eqs. (4), (5) and (8)."""
    return (dot(n, r) - motion_a[0] - motion_b[0],
            dot(n, velocity) - motion_a[1] - motion_b[1],
            motion_a[2] + motion_b[2])


@kernel
def holding_time(gap, rate, bend):
    """How long gap + rate t - bend t^2 / 2 stays positive at least, eq. (8). inf when it always does."""
    gap = max(gap, 0.0)
    root = sqrt(rate * rate + 2 * bend * gap)
    if rate < 0:
        return 2 * gap / (root - rate)
    return (rate + root) / bend if bend > 0 else inf


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
def free_flight_contact(a, b, t_max):
    """First contact of two free flights in [0, t_max]. -> status, time, unit normal from A to B, contact point, steps.

    A flight is (semi_axes, centre, orientation, velocity, angular_velocity, growth_rate): tuples and a number.
    """
    axes_a, centre_a, turn_a, velocity_a, spin_a, growth_a = a
    axes_b, centre_b, turn_b, velocity_b, spin_b, growth_b = b
    velocity, start = subtract(velocity_b, velocity_a), subtract(centre_b, centre_a)
    n = nowhere = (0.0, 0.0, 0.0)
    if norm(start) == 0.0:
        return OVERLAPPING, 0.0, nowhere, centre_a, 0
    radius_a, radius_b = max(axes_a), max(axes_b)
    time, end = meeting_window(start, velocity, radius_a + radius_b, radius_a * growth_a + radius_b * growth_b, t_max)
    if time >= end:
        return NO_CONTACT, inf, nowhere, nowhere, 0
    swing_a = swing(semi_axis_vectors(axes_a, body_axes(turn_a)), spin_a)
    swing_b = swing(semi_axis_vectors(axes_b, body_axes(turn_b)), spin_b)
    n, ahead, guess = add_scaled(start, time, velocity), time, end
    for step in range(SHOOT_STEPS):
        turn_a, turn_b = turn(turn_a, spin_a, ahead), turn(turn_b, spin_b, ahead)
        s_a, s_b = semi_axis_vectors(axes_a, body_axes(turn_a)), semi_axis_vectors(axes_b, body_axes(turn_b))
        size_a, size_b = 1 + growth_a * time, 1 + growth_b * time
        r = add_scaled(start, time, velocity)
        balance, maximised = 0.5, False
        for attempt in range(3):
            if maximised:
                n, _, converged = best_plane(scaled(size_a, s_a), scaled(size_b, s_b), r, balance, EXACT)
                if not converged:
                    return UNRESOLVED, time, n, nowhere, step
            else:
                n = scale(1.0 / norm(n), n)
            face_a, face_b = facing(s_a, size_a, spin_a, growth_a, n), facing(s_b, size_b, spin_b, growth_b, n)
            supports = size_a * face_a[0] + size_b * face_b[0]
            gap = dot(n, r) - supports
            gap_now = max(gap, 0.0)
            if maximised:
                break
            balance = size_a * face_a[0] / supports                 # lambda where n is the best direction of touching bodies, eq. (2)
            if gap <= TOUCHING * supports:
                maximised = True
                continue
            lag = add_scaled(add_scaled(r, -size_a, face_a[1]), -size_b, face_b[1])
            towards = following(face_a, face_b, gap_now, n, lag)
            if 0.0 < dot(lag, towards) <= LAG * gap:
                break
            n, maximised = add(n, towards), attempt > 0             # one step of Newton, then the pencil
        if time == 0.0 and gap < -TOUCHING * supports:
            return OVERLAPPING, 0.0, n, contact_point(centre_a, scaled(size_a, s_a), r, scaled(size_b, s_b), n), 0
        m = following(face_a, face_b, gap_now, n, add(velocity, add(face_a[3], face_b[3])))
        flight_a, flight_b = (size_a, spin_a, growth_a), (size_b, spin_b, growth_b)
        series_a, series_b = support_series(face_a, flight_a, n, m), support_series(face_b, flight_b, n, m)
        rate = dot(n, velocity) + dot(m, r) - series_a[0] - series_b[0]
        plane = (gap_now, rate, 2 * dot(m, velocity), norm(m))
        ahead = holding_span(plane, (series_a, swing_a), (series_b, swing_b), end - time, guess)
        if rate < 0 and (gap <= TOUCHING * supports or time + ahead == time):
            where = add_scaled(centre_a, time, velocity_a)
            return CONTACT, time, n, contact_point(where, scaled(size_a, s_a), r, scaled(size_b, s_b), n), step
        time += ahead
        guess = 2 * ahead
        n = add_scaled(n, ahead, m)
        if time > end:
            return NO_CONTACT, inf, nowhere, nowhere, step
    return UNRESOLVED, time, n, nowhere, SHOOT_STEPS
