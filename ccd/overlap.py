"""Do two ellipsoids at rest overlap, and where do they touch: Section 2 of the paper, for rigid and for affine poses."""

from __future__ import annotations

import numpy as np

from ccd.annotations import Floats
from ccd.characteristic import UNCERTAIN, aspect_ratio, decided_state, polynomial
from ccd.compiling import kernel
from ccd.ellipsoid import AffineEllipsoid, AnyEllipsoid, Ellipsoid
from ccd.rotation import body_axes
from ccd.separation import contact_function, relative_pose
from ccd.status import State
from ccd.tolerances import SHARP, TOUCHING_POINT
from ccd.vectors import subtract


def state(a: AnyEllipsoid, b: AnyEllipsoid) -> State:
    """Are two ellipsoids at rest separate, touching or overlapping? (Theorem 1 of the paper; eqs. (16) to (18).)

    a, b: Ellipsoid or AffineEllipsoid. TOUCHING: the contact function (1) is within 1e-12 of 1, as `separation` has it; within that band,
    and wherever rounding might change the signs of the roots, the contact function itself decides. ArithmeticError where float64 cannot
    hold its pencil parameter (sizes some 1e20 apart).
    """
    _check_bodies(a, b)
    if isinstance(a, Ellipsoid) and isinstance(b, Ellipsoid):
        found = _rigid_state(*_numbers(a), *_numbers(b))
    else:
        found = decided_state(*_affine_pose(a, b), np.linalg.cond(a.semi_axis_vectors) * np.linalg.cond(b.semi_axis_vectors))
    if found == UNCERTAIN:
        raise _not_maximised(a, b)
    return State(found)


def characteristic_polynomial(a: AnyEllipsoid, b: AnyEllipsoid) -> Floats:
    """The coefficients (5,) of f(lambda) = det(lambda A - M_A^T M_B^-T B M_B^-1 M_A), highest power first (paper, Sec. 2.1, Appendix A).

    A = diag(1 / a^2, 1 / b^2, 1 / c^2, -1), B likewise, and M_A, M_B carry the canonical frames of a and b (Ellipsoid or AffineEllipsoid)
    to the lab. For rigid poses this is det(lambda a.quadric - b.quadric).
    """
    _check_bodies(a, b)
    coefficients = np.array([-1.0, *polynomial(*_pose(a, b))])
    return coefficients / a.semi_axes.prod() ** 2


def contact_point(a: AnyEllipsoid, b: AnyEllipsoid) -> Floats:
    """Where two touching ellipsoids touch (3,): the null vector of lambda_0 A - B at the double root lambda_0 (paper, Theorem 2).

    a, b: Ellipsoid or AffineEllipsoid. ValueError where the contact function is further than 1e-6 from 1. Within that distance the point
    is where they touch once both are scaled about their centres by the square root of the contact function, which moves no point of a
    surface by more than 5e-7 of its distance from the centre.
    """
    _check_bodies(a, b)
    g, t, _ = _pose(a, b)
    f, odds, converged = contact_function(g, t, SHARP)
    if not converged:
        raise _not_maximised(a, b)
    if not abs(f - 1) <= TOUCHING_POINT:
        raise ValueError(f"a and b do not touch: their contact function is {f!r}, expected 1 to within {TOUCHING_POINT}")
    # lambda_0 = -odds. Where A is the unit sphere the null vector is (p, 1) with (g^T g - lambda_0) p = g^T t, eq. (19): the normal
    # equations of a least-squares problem, which is better solved as one.
    p = np.linalg.lstsq(np.vstack([np.transpose(g), np.sqrt(odds) * np.eye(3)]), np.append(t, np.zeros(3)))[0]
    return a.center + a.semi_axis_vectors @ p


@kernel
def _rigid_pose(semi_axes_a, center_a, orientation_a, semi_axes_b, center_b, orientation_b):
    g, t = relative_pose(semi_axes_a, body_axes(orientation_a), semi_axes_b, body_axes(orientation_b), subtract(center_b, center_a))
    return g, t, semi_axes_a[0] * semi_axes_a[1] * semi_axes_a[2] / (semi_axes_b[0] * semi_axes_b[1] * semi_axes_b[2])


@kernel
def _rigid_state(semi_axes_a, center_a, orientation_a, semi_axes_b, center_b, orientation_b):
    g, t, det = _rigid_pose(semi_axes_a, center_a, orientation_a, semi_axes_b, center_b, orientation_b)
    return decided_state(g, t, det, aspect_ratio(semi_axes_b))


def _pose(a, b):
    """What the kernels take: g, t and det g."""
    if isinstance(a, Ellipsoid) and isinstance(b, Ellipsoid):
        return _rigid_pose(*_numbers(a), *_numbers(b))
    return _affine_pose(a, b)


def _affine_pose(a, b):
    solved = np.linalg.solve(b.semi_axis_vectors, np.column_stack([a.semi_axis_vectors, b.center - a.center]))
    g1, g2, g3, t = (_tuple(column) for column in solved.T)
    return (g1, g2, g3), t, np.linalg.det(a.semi_axis_vectors) / np.linalg.det(b.semi_axis_vectors)


def _numbers(body):
    return _tuple(body.semi_axes), _tuple(body.center), _tuple(body.orientation)


def _tuple(array):
    return tuple(array.tolist())


def _check_bodies(a, b):
    for name, body in (("a", a), ("b", b)):
        if not isinstance(body, (Ellipsoid, AffineEllipsoid)):
            raise ValueError(f"{name} = {body!r}: expected a ccd.Ellipsoid or a ccd.AffineEllipsoid")


def _not_maximised(a, b):
    return ArithmeticError(f"the contact function of {a} and {b} cannot be maximised in double precision")
