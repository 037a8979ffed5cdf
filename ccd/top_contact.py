"""First contact of two free bodies with any moments of inertia: the shoot with fixed directions, eqs. (4) to (11) and (12b) to (12f).

As in first_contact.py, but the plane that turns with the motion needs constant rates. Here every step takes the best direction of its time,
by the pencil, and holds it as long as a parabola under the gap stays positive.
"""

from math import inf

import numba

from ccd import first_contact
from ccd.compiling import kernel, parallel_kernel
from ccd.first_contact import CONTACT, NO_CONTACT, OVERLAPPING, UNRESOLVED
from ccd.free_top import angular_momentum, angular_velocity, fastest_turning, top_of, turn_freely, turn_top
from ccd.rotation import body_axes, load_quaternion, unit
from ccd.separation import best_plane, contact_point, semi_axis_vectors
from ccd.tolerances import EXACT, SHOOT_STEPS, TOUCHING
from ccd.vectors import add_scaled, load, norm, scale, subtract


@kernel
def at_time(flight, time):
    """A flight (semi_axes, centre, orientation, velocity, angular_velocity, inverse_moments, growth_rate), as it is at a later time."""
    semi_axes, centre, orientation, velocity, spin, inverse_moments, growth = flight
    momentum = angular_momentum(orientation, spin, inverse_moments)
    turned = turn_freely(orientation, momentum, inverse_moments, time)
    size = 1 + growth * time
    return (scale(size, semi_axes), add_scaled(centre, time, velocity), turned, velocity,
            angular_velocity(turned, momentum, inverse_moments), inverse_moments, growth / size)


@kernel
def _launched(flight):
    """(semi_axes, orientation, momentum, inverse_moments, its `Top`) and a bound on q'' / 2 for all time, eq. (12e)."""
    semi_axes, _, orientation, _, spin, inverse_moments, _ = flight
    momentum = angular_momentum(orientation, spin, inverse_moments)
    top = top_of(orientation, momentum, inverse_moments)
    speed, change = fastest_turning(top, inverse_moments)
    least, most = min(semi_axes), max(semi_axes)
    return (semi_axes, orientation, momentum, inverse_moments, top), (speed * speed + 0.5 * change) * (most - least) * (most + least)


@kernel
def _posed(body, time):
    """Semi-axis vectors without growth, and the angular velocity, at a time."""
    semi_axes, orientation, momentum, inverse_moments, top = body
    turned = unit(turn_top(top, orientation, momentum, inverse_moments, time))
    return semi_axis_vectors(semi_axes, body_axes(turned)), angular_velocity(turned, momentum, inverse_moments)


@kernel
def _support(s, spin, bend, n):
    """`support_motion` by the tangent of h, eq. (12f), and up to when it holds: while the tangent is at least half of h, or for ever."""
    h, rate, _ = first_contact.support_motion(s, (spin, (0.0, 0.0, 0.0), 0.0, 0.0, 0.0, 0.0), n, 0.0)
    local, always = (bend - rate * rate) / h * (2.0 if rate < 0 else 1.0), bend / min(norm(s[0]), norm(s[1]), norm(s[2]))
    if rate < 0 and local < always:
        return (h, rate, local), -0.5 * h / rate
    return (h, rate, min(local, always)), inf


@kernel
def _holding(now, n, r, velocity, left):
    """How long the direction n keeps two bodies apart at least, and its gap, rate and the sum of the supports, eqs. (5) to (12f).

    now: of each body, (semi-axis vectors without growth, angular velocity, bound of (12e), size, growth).
    """
    (s_a, spin_a, bend_a, size_a, growth_a), (s_b, spin_b, bend_b, size_b, growth_b) = now
    (motion_a, reach_a), (motion_b, reach_b) = _support(s_a, spin_a, bend_a, n), _support(s_b, spin_b, bend_b, n)
    reach = min(left, reach_a, reach_b)
    motion_a, motion_b = first_contact.grown(motion_a, size_a, growth_a, reach), first_contact.grown(motion_b, size_b, growth_b, reach)
    gap, rate, bend = first_contact.gap_motion(n, r, velocity, motion_a, motion_b)
    span = first_contact.holding_time(gap, rate, bend)
    if span > reach:
        span = inf if reach == left else reach
    return span, gap, rate, motion_a[0] + motion_b[0]


@kernel
def free_top_contact(a, b, t_max):
    """First contact of two flights (see `at_time`) in [0, t_max]. -> status, time, unit normal from A to B, contact point, steps."""
    start, velocity = subtract(b[1], a[1]), subtract(b[3], a[3])
    if norm(start) == 0:
        return OVERLAPPING, 0.0, start, a[1], 0
    radius_a, radius_b = max(a[0]), max(b[0])
    time, end = first_contact.meeting_window(start, velocity, radius_a + radius_b, radius_a * a[6] + radius_b * b[6], t_max)
    if time >= end:
        return NO_CONTACT, inf, start, a[1], 0
    (body_a, bend_a), (body_b, bend_b) = _launched(a), _launched(b)
    n, x = start, radius_a / (radius_a + radius_b)
    for steps in range(1, SHOOT_STEPS + 1):
        (s_a, spin_a), (s_b, spin_b) = _posed(body_a, time), _posed(body_b, time)
        size_a, size_b = 1 + a[6] * time, 1 + b[6] * time
        r = add_scaled(start, time, velocity)
        n, x, converged = best_plane(first_contact.scaled(size_a, s_a), first_contact.scaled(size_b, s_b), r, x, EXACT)
        if not converged:
            return UNRESOLVED, time, n, a[1], steps
        now = (s_a, spin_a, bend_a, size_a, a[6]), (s_b, spin_b, bend_b, size_b, b[6])
        span, gap, rate, supports = _holding(now, n, r, velocity, end - time)
        inside = time == 0 and gap < -TOUCHING * supports
        if inside or (rate < 0 and (gap <= TOUCHING * supports or time + span == time)):
            point = contact_point(add_scaled(a[1], time, a[3]), first_contact.scaled(size_a, s_a), r, first_contact.scaled(size_b, s_b), n)
            return OVERLAPPING if inside else CONTACT, time, n, point, steps
        if time + span > end:
            return NO_CONTACT, inf, n, a[1], steps
        time += span
    return UNRESOLVED, time, n, a[1], SHOOT_STEPS


@parallel_kernel
def first_contacts(flights_a, flights_b, t_max, time, status):
    """First contact of each pair of flights in [0, t_max] into `time` and `status`, both (n,). Flights: as for `at_time`, as arrays."""
    for k in numba.prange(len(time)):
        status[k], time[k], _, _, _ = free_top_contact(_flight(flights_a, k), _flight(flights_b, k), t_max)


@kernel
def _flight(flights, k):
    semi_axes, centre, orientation, velocity, spin, inverse_moments, growth = flights
    return (load(semi_axes[k], 0), load(centre[k], 0), load_quaternion(orientation[k], 0), load(velocity[k], 0), load(spin[k], 0),
            load(inverse_moments[k], 0), growth[k])
