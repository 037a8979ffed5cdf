"""What one asks about one pair of ellipsoids."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ccd.annotations import Span
from ccd.answers import Contact, Separation
from ccd.checks import time_span
from ccd.compiling import kernel
from ccd.ellipsoid import Ellipsoid
from ccd.equation import CCDEquation
from ccd.first_contact import free_flight_contact
from ccd.motion import FreeFlight, Motion
from ccd.quaternions import products, rotations
from ccd.rotation import body_axes
from ccd.separation import contact_function, contact_point, normal, relative_pose, semi_axis_vectors, shape_matrix, support
from ccd.status import State, Status
from ccd.tolerances import SHARP, SHOOT_STEPS, TOUCHING_STATE
from ccd.top_contact import at_time, free_top_contact
from ccd.vectors import dot, subtract

if TYPE_CHECKING:
    from ccd.answers import Interval


@kernel
def _separation(semi_axes_a, center_a, orientation_a, semi_axes_b, center_b, orientation_b):
    axes_a, axes_b = body_axes(orientation_a), body_axes(orientation_b)
    s_a, s_b = semi_axis_vectors(semi_axes_a, axes_a), semi_axis_vectors(semi_axes_b, axes_b)
    r = subtract(center_b, center_a)
    f, odds, converged = contact_function(*relative_pose(semi_axes_a, axes_a, semi_axes_b, axes_b, r), SHARP)
    a, b = shape_matrix(s_a), shape_matrix(s_b)
    n = normal(a, b, r, odds / (1 + odds)) if odds < 1 else normal(b, a, r, 1 / (1 + odds))         # the smaller weight, to its last digit
    gap = dot(n, r) - support(s_a, n) - support(s_b, n)
    return converged, f, gap, n, contact_point(center_a, s_a, r, s_b, n), odds / (1 + odds)


def separation(a: Ellipsoid, b: Ellipsoid) -> Separation:
    """State, contact function, gap, normal and contact point of two ellipsoids at rest (Perram and Wertheim; eqs. (1) to (4)).

    Concentric ellipsoids have no normal: contact function 0, gap minus infinity, normal and point nan. ArithmeticError where float64
    cannot hold the pencil parameter (sizes some 1e20 apart).
    """
    _check_ellipsoids(a, b)
    if np.array_equal(a.center, b.center):
        return Separation(State.OVERLAPPING, 0.0, -np.inf, np.full(3, np.nan), np.full(3, np.nan), 0.5)
    bodies = (a.semi_axes, a.center, a.orientation, b.semi_axes, b.center, b.orientation)
    converged, f, gap, n, point, x = _separation(*map(_tuple, bodies))
    if not converged:
        raise ArithmeticError(f"the contact function of {a} and {b} cannot be maximised in double precision")
    state = State.TOUCHING if abs(f - 1) <= TOUCHING_STATE else State.SEPARATE if f > 1 else State.OVERLAPPING
    return Separation(state, f, gap, np.array(n), np.array(point), x)


def first_contact(a: Ellipsoid, motion_a: Motion, b: Ellipsoid, motion_b: Motion, t_span: Span = (0.0, 1.0)) -> Contact:
    """The first contact of two moving ellipsoids within t_span. -> Contact

    a, b: Ellipsoid. Both in FreeFlight or at Rest(), from their own poses at t = 0: by the certified shoot (docs/theory.md, section 2),
    where one of them turns freely with moments of its own by a simpler one that takes more steps.
    Rational motions, with Rest() or FreeFlight without rotation as the other: by recursive Bézier shoots on the CCD equation (paper,
    Sec. 3.3). Status OVERLAPPING when the bodies overlap at t_span[0] already, and UNRESOLVED where float64 cannot tell. Contact times
    are good to 1e-12 of the span at regular contacts.
    """
    if not isinstance(motion_a, FreeFlight) or not isinstance(motion_b, FreeFlight):
        return CCDEquation(a, motion_a, b, motion_b, t_span).first_contact()
    _check_ellipsoids(a, b)
    start, end = time_span("t_span", t_span)
    _check_growth("motion_a", motion_a, start, end)
    _check_growth("motion_b", motion_b, start, end)
    if motion_a.moments is None and motion_b.moments is None:
        found = free_flight_contact(_flight(a, motion_a, start), _flight(b, motion_b, start), end - start)
    else:
        found = free_top_contact(_top(a, motion_a, start), _top(b, motion_b, start), end - start)
    status, time, n, point, steps = found
    if status == Status.NO_CONTACT:
        n = point = (np.nan,) * 3
    return Contact(Status(status), start + time, np.array(point), np.array(n), steps, _reason(status, start + time, steps))


def _reason(status, time, steps):
    if status != Status.UNRESOLVED:
        return ""
    if steps < SHOOT_STEPS:
        return f"at time {time} the pencil of the two shapes cannot be maximised in double precision; they do not touch before"
    return f"no decision after {steps} steps of the shoot, which have come to time {time}; the bodies do not touch before"


def contact_intervals(a: Ellipsoid, motion_a: Motion, b: Ellipsoid, motion_b: Motion, t_span: Span = (0.0, 1.0)) -> list[Interval]:
    """All maximal intervals of separation and of overlap of two ellipsoids within t_span (paper, Sec. 3.2, Algorithms 1 to 3).

    Arguments as for `CCDEquation`. -> list of Interval, end to end over t_span.
    """
    return CCDEquation(a, motion_a, b, motion_b, t_span).contact_intervals()


def _check_ellipsoids(a, b):
    for name, body in (("a", a), ("b", b)):
        if not isinstance(body, Ellipsoid):
            raise ValueError(f"{name} = {body!r}: expected a ccd.Ellipsoid")


def _check_growth(name, motion, start, end):
    if min(1 + motion.growth_rate * start, 1 + motion.growth_rate * end) <= 0:
        raise ValueError(f"{name}.growth_rate = {motion.growth_rate}: the semi-axes would vanish within t_span = ({start}, {end})")


def _flight(body, motion, start):
    """The flight from t = start on, as the kernel takes it."""
    size = 1 + motion.growth_rate * start
    orientation = products(rotations(motion.angular_velocity[None] * start), body.orientation[None])[0]
    return (_tuple(body.semi_axes * size), _tuple(body.center + motion.velocity * start), _tuple(orientation),
            _tuple(motion.velocity), _tuple(motion.angular_velocity), motion.growth_rate / size)


def _top(body, motion, start):
    """The same for the kernel that takes free bodies: equal moments turn at a constant rate."""
    inverse_moments = (1.0, 1.0, 1.0) if motion.moments is None else _tuple(motion.moments.min() / motion.moments)
    flight = (_tuple(body.semi_axes), _tuple(body.center), _tuple(body.orientation), _tuple(motion.velocity),
              _tuple(motion.angular_velocity), inverse_moments, motion.growth_rate)
    return flight if start == 0 else at_time(flight, start)


def _tuple(array):
    return tuple(array.tolist())
