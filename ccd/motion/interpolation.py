"""Rational motions made from poses and flights: interpolants between two poses (paper, Sec. 4.1 and Appendix D), and free flight."""

from __future__ import annotations

from math import factorial

import numpy as np
from numpy.polynomial import Polynomial

from ccd import checks
from ccd.annotations import Span
from ccd.ellipsoid import Ellipsoid
from ccd.motion.flight import FreeFlight
from ccd.motion.rational import AffineInterpolant, AffineMotion, RationalMotion
from ccd.quaternions import products, rotations


def interpolate_rigid(start: Ellipsoid, end: Ellipsoid) -> RationalMotion:
    """The motion from one pose at t = 0 to another at t = 1: linear quaternion curve, linear translation (paper, Sec. 4.1).

    start, end: Ellipsoid with the same semi-axes. The shorter way round is taken. -> RationalMotion, rotation of degree 2.
    """
    _same_shape("start", start, "end", end)
    first, last = start.orientation, end.orientation
    last = -last if first @ last < 0 else last
    return RationalMotion(np.stack([first, last - first], axis=1), np.stack([start.center, end.center - start.center], axis=1))


def interpolate_affine(a_start: Ellipsoid, a_end: Ellipsoid, b_start: Ellipsoid, b_end: Ellipsoid) -> AffineInterpolant:
    """The affine interpolant of the motion of B relative to A, t from 0 to 1, which makes F of degree 6 (paper, Appendix D).

    a_start, a_end and b_start, b_end: Ellipsoid, each pair with the same semi-axes. The motion is that of B as seen from A's canonical
    frame: to be used with Ellipsoid(a_start.semi_axes) at Rest(). B is deformed on the way; at both ends it is exact.
    -> AffineInterpolant
    """
    _same_shape("a_start", a_start, "a_end", a_end)
    _same_shape("b_start", b_start, "b_end", b_end)
    inverses, centers = np.empty((2, 3, 3)), np.empty((2, 3))
    for k, (a, b) in enumerate(((a_start, b_start), (a_end, b_end))):
        turn = a.rotation_matrix.T @ b.rotation_matrix / b.semi_axes
        inverses[k] = turn @ turn.T
        centers[k] = a.rotation_matrix.T @ (b.center - a.center)
    return AffineInterpolant(b_start.semi_axes, inverses, centers)


def approximate_flight(ellipsoid: Ellipsoid, flight: FreeFlight, t_span: Span = (0.0, 1.0),
                       degree: int = 3) -> RationalMotion | AffineMotion:
    """A rational motion close to a free flight within t_span, for the algebraic solution (paper, Sec. 5, asks for such).

    The rotation by an angle theta since the middle of the span becomes that of the quaternion 1 + i theta / 2 + ..., the numerator of the
    diagonal Padé approximant of exp(i theta) of degree k: its angle errs by about theta^(2 k + 1) k!^2 / ((2 k)! (2 k + 1)!), for k = 3
    1e-5 theta^7. Cut long flights into spans. Exact without rotation. -> RationalMotion, or AffineMotion for a body that grows.
    """
    start, end = checks.time_span("t_span", t_span)
    degree = checks.natural_number("degree", degree)
    if degree < 1:
        raise ValueError(f"degree = {degree}: expected 1 or more")
    if not isinstance(ellipsoid, Ellipsoid) or not isinstance(flight, FreeFlight):
        raise ValueError(f"ellipsoid = {ellipsoid!r}, flight = {flight!r}: expected a ccd.Ellipsoid and a ccd.FreeFlight")
    if flight.moments is not None:
        raise ValueError(f"flight.moments = {flight.moments.tolist()}: expected a flight at a constant angular velocity")
    path = np.array([ellipsoid.center, flight.velocity]).T
    if not flight.angular_velocity.any() and flight.growth_rate == 0:
        return RationalMotion(ellipsoid.orientation[:, None], path)
    middle = 0.5 * (start + end)
    since_middle = Polynomial([-middle, 1.0])
    spin, rate = flight.angular_velocity, np.linalg.norm(flight.angular_velocity)
    turn = [Polynomial([0.0]) for _ in range(4)]
    for j in range(degree + 1 if rate > 0 else 1):
        pade = factorial(2 * degree - j) * factorial(degree) / (factorial(2 * degree) * factorial(j) * factorial(degree - j))
        power = (-1)**(j // 2) * pade * rate**(j - j % 2) * since_middle**j
        if j % 2:
            turn[1:] = [turn[k + 1] + spin[k] * power for k in range(3)]
        else:
            turn[0] = turn[0] + power
    pose = products(rotations(spin[None] * middle), ellipsoid.orientation[None])[0]
    rotation = _rows([sum(sign * turn[k] * pose[l] for sign, k, l in terms) for terms in PRODUCT])
    if flight.growth_rate == 0:
        return RationalMotion(rotation, path)
    e = [Polynomial(row) for row in rotation]
    norm = sum((each * each for each in e), Polynomial([0.0]))
    size = Polynomial([1.0, flight.growth_rate])
    return AffineMotion(_rows([size * entry for entry in _rotation(e)]).reshape(3, 3, -1),
                        _rows([Polynomial(row) * norm for row in path]), norm.coef)


# the terms (sign, i, j) of the product of two quaternions, component by component
PRODUCT = (((1, 0, 0), (-1, 1, 1), (-1, 2, 2), (-1, 3, 3)), ((1, 0, 1), (1, 1, 0), (1, 2, 3), (-1, 3, 2)),
           ((1, 0, 2), (-1, 1, 3), (1, 2, 0), (1, 3, 1)), ((1, 0, 3), (1, 1, 2), (-1, 2, 1), (1, 3, 0)))


def _rotation(e):
    """E R, row by row, from the Euler parameters (paper, Appendix B)."""
    w, x, y, z = e
    return (w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y),
            2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x),
            2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z)


def _rows(polynomials):
    """As an array of coefficients, all of the highest degree among them."""
    size = max(len(each.coef) for each in polynomials)
    return np.array([np.pad(each.coef, (0, size - len(each.coef))) for each in polynomials])


def _same_shape(name, first, other_name, second):
    for each, value in ((name, first), (other_name, second)):
        if not isinstance(value, Ellipsoid):
            raise ValueError(f"{each} = {value!r}: expected a ccd.Ellipsoid")
    if not np.array_equal(first.semi_axes, second.semi_axes):
        raise ValueError(f"{other_name}.semi_axes = {second.semi_axes}: expected those of {name}, {first.semi_axes}")
