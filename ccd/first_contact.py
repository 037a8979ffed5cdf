"""First contact of two bodies in free flight: the certified shoot, eqs. (4) to (11) of docs/theory.md.

A direction n held fixed separates the bodies while the gap between the two supporting planes is positive. That gap is bounded from below
by a parabola in time whose first root is a time before which the bodies cannot touch. Go there, take the best direction again, repeat:
quadratic convergence to a regular contact (the paper's Sec. 3.3 and Appendix C), always from the safe side.

The event engine takes the same steps one at a time: `support_motion`, `gap_motion` and `holding_time` are its predictor.
"""

from math import inf, sqrt

from ccd.compiling import kernel
from ccd.rotation import body_axes, turn
from ccd.separation import best_plane, contact_point, semi_axis_vectors
from ccd.status import Status
from ccd.tolerances import EXACT, SHOOT_STEPS, TOUCHING
from ccd.vectors import add_scaled, cross, dot, norm, scale, subtract

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
def free_flight_contact(a, b, t_max):
    """First contact of two free flights in [0, t_max]. -> status, time, unit normal from A to B, contact point, steps.

    A flight is (semi_axes, centre, orientation, velocity, angular_velocity, growth_rate): tuples and a number.
    """
    axes_a, centre_a, turn_a, velocity_a, spin_a, growth_a = a
    axes_b, centre_b, turn_b, velocity_b, spin_b, growth_b = b
    bend_a, bend_b = curvature(axes_a, spin_a), curvature(axes_b, spin_b)
    velocity = subtract(velocity_b, velocity_a)
    start = subtract(centre_b, centre_a)
    nowhere = (0.0, 0.0, 0.0)
    time, pencil_parameter = 0.0, norm(axes_a) / (norm(axes_a) + norm(axes_b))
    if norm(start) == 0.0:
        return OVERLAPPING, 0.0, nowhere, centre_a, 0
    for step in range(SHOOT_STEPS):
        size_a, size_b = 1 + growth_a * time, 1 + growth_b * time
        s_a = semi_axis_vectors(axes_a, body_axes(turn(turn_a, spin_a, time)))
        s_b = semi_axis_vectors(axes_b, body_axes(turn(turn_b, spin_b, time)))
        scaled_a = (scale(size_a, s_a[0]), scale(size_a, s_a[1]), scale(size_a, s_a[2]))
        scaled_b = (scale(size_b, s_b[0]), scale(size_b, s_b[1]), scale(size_b, s_b[2]))
        r = add_scaled(start, time, velocity)
        n, pencil_parameter, converged = best_plane(scaled_a, scaled_b, r, pencil_parameter, EXACT)
        horizon = t_max - time
        motion_a = grown(support_motion(s_a, spin_a, bend_a, n, 0.0), size_a, growth_a, horizon)
        motion_b = grown(support_motion(s_b, spin_b, bend_b, n, 0.0), size_b, growth_b, horizon)
        gap, rate, bend = gap_motion(n, r, velocity, motion_a, motion_b)
        touching = TOUCHING * (motion_a[0] + motion_b[0])
        if step == 0 and gap < -touching:
            return OVERLAPPING, 0.0, n, contact_point(centre_a, scaled_a, r, scaled_b, n), 0
        if not converged:
            return UNRESOLVED, time, n, nowhere, step
        ahead = holding_time(gap, rate, bend)
        if rate < 0 and (gap <= touching or time + ahead == time):
            return CONTACT, time, n, contact_point(add_scaled(centre_a, time, velocity_a), scaled_a, r, scaled_b, n), step
        time += ahead
        if time > t_max:
            return NO_CONTACT, inf, nowhere, nowhere, step
    return UNRESOLVED, time, n, nowhere, SHOOT_STEPS
