"""Rational Euclidean and affine motions (paper, Appendices B and D): x_lab = M(t) x_body, in homogeneous coordinates.

Their polynomials are given in powers of t, lowest first. The frame of the body is the one in which its ellipsoid is canonical, eq. (1) of
the paper: centred, with the semi-axes along x, y and z; the centre and orientation of a ccd.Ellipsoid are not used with such a motion.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ccd import checks
from ccd.annotations import ArrayLike, Floats, Span
from ccd.motion.tensors import DENOMINATOR_VANISHES, FLAT, TURN_VANISHES, affine_tensors, empty_tensors, interpolated_tensors, rigid_tensors
from ccd.quaternions import rotation_matrices

if TYPE_CHECKING:
    from ccd.motion.tensors import Tensors

WHY_NOT = {TURN_VANISHES: "rotation: the quaternion polynomial vanishes", DENOMINATOR_VANISHES: "denominator: it has a root",
           FLAT: "linear: the map is singular"}


def _polynomials(name, value, rows, what):
    """Power-basis coefficients without the highest powers that no row has. Read-only."""
    coefficients = checks.real_array(name, value, (*rows, None), what)
    if coefficients.size == 0:
        raise ValueError(f"{name} has no coefficients: expected {what}")
    while coefficients.shape[-1] > 1 and not coefficients[..., -1].any():
        coefficients = np.ascontiguousarray(coefficients[..., :-1])
    coefficients.flags.writeable = False
    return coefficients


def _at(coefficients, t):
    """Polynomials at one time, by Horner's rule."""
    total = np.zeros(coefficients.shape[:-1])
    for k in range(coefficients.shape[-1] - 1, -1, -1):
        total = total * t + coefficients[..., k]
    return total


def _set(motion, **polynomials):
    for name, (rows, what) in polynomials.items():
        value = _polynomials(name, getattr(motion, name), rows, what)
        if name != "translation" and not value.any():
            raise ValueError(f"{name} is zero: expected {what} with no root while the body moves")
        object.__setattr__(motion, name, value)


def _matrix(linear, translation):
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = linear, translation
    return matrix


@dataclass(frozen=True, eq=False)
class RationalMotion:
    """A rational Euclidean motion, eq. (2) of the paper: x_lab = R(t) x_body + translation(t) / denominator(t).

    rotation (4, k + 1): Euler parameters e0, e1, e2, e3 (a quaternion, scalar first, of any length) as polynomials, so that R is rational
    of degree 2 k. translation (3, m + 1), denominator (d + 1,).
    """

    rotation: Floats
    translation: Floats
    denominator: Floats = (1.0,)        # type: ignore[assignment]

    if TYPE_CHECKING:               # what may be given; the fields say what it becomes
        def __init__(self, rotation: ArrayLike, translation: ArrayLike, denominator: ArrayLike = ...) -> None: ...

    def __post_init__(self):
        _set(self, rotation=((4,), "four polynomials (4, k + 1)"), translation=((3,), "three polynomials (3, m + 1)"),
             denominator=((), "a polynomial (d + 1,)"))

    @property
    def degree(self) -> int:
        """As the paper counts it: the highest degree in R(t) and the translation."""
        return max(2 * self.rotation.shape[1] - 2, self.translation.shape[1] - 1, len(self.denominator) - 1)

    def matrix(self, t: float) -> Floats:
        """M(t) (4, 4)."""
        quaternion = _at(self.rotation, t)
        quaternion /= np.linalg.norm(quaternion)
        return _matrix(rotation_matrices(quaternion[None])[0], _at(self.translation, t) / _at(self.denominator, t))

    def tensors(self, semi_axes: ArrayLike, span: Span) -> tuple[Tensors, str | None]:
        """Its part in the CCD equation for t in start + [0, width], span = (start, width). -> Tensors, and what is wrong, or None."""
        k, m, d = self.rotation.shape[1] - 1, self.translation.shape[1] - 1, len(self.denominator) - 1
        tensors = empty_tensors(q=4 * k, p=4 * k, det=4 * k + 2 * d, mu=4 * k, v=d, path=m)
        fault = rigid_tensors(tensors, semi_axes, (self.rotation, self.translation, self.denominator), span,
                              (np.empty((2 * k + 1, 13)), np.empty((3, 2 * max(k, d) + 1))))
        return tensors, WHY_NOT.get(fault)


@dataclass(frozen=True, eq=False)
class AffineMotion:
    """A rational affine motion: x_lab = (linear(t) x_body + translation(t)) / denominator(t), which changes the ellipsoid's shape.

    linear (3, 3, k + 1), nowhere singular while the body moves; translation (3, m + 1), denominator (d + 1,) of both.
    """

    linear: Floats
    translation: Floats
    denominator: Floats = (1.0,)        # type: ignore[assignment]

    if TYPE_CHECKING:               # what may be given; the fields say what it becomes
        def __init__(self, linear: ArrayLike, translation: ArrayLike, denominator: ArrayLike = ...) -> None: ...

    def __post_init__(self):
        _set(self, linear=((3, 3), "nine polynomials (3, 3, k + 1)"), translation=((3,), "three polynomials (3, m + 1)"),
             denominator=((), "a polynomial (d + 1,)"))

    @property
    def degree(self) -> int:
        """As the paper counts it: the highest degree in linear, translation and denominator."""
        return max(self.linear.shape[2], self.translation.shape[1], len(self.denominator)) - 1

    def matrix(self, t: float) -> Floats:
        """M(t) (4, 4)."""
        d = _at(self.denominator, t)
        return _matrix(_at(self.linear, t) / d, _at(self.translation, t) / d)

    def tensors(self, semi_axes: ArrayLike, span: Span) -> tuple[Tensors, str | None]:
        """As RationalMotion.tensors."""
        k, m, d = self.linear.shape[2] - 1, self.translation.shape[1] - 1, len(self.denominator) - 1
        tensors = empty_tensors(q=2 * k + 2 * d, p=4 * k, det=6 * k, mu=4 * d, v=d, path=m)
        fault = affine_tensors(tensors, semi_axes, (self.linear.reshape(9, k + 1), self.translation, self.denominator), span,
                               (np.empty((2 * k + 1, 24)), np.empty((3, max(3 * k, 2 * d) + 1))))
        return tensors, WHY_NOT.get(fault)


@dataclass(frozen=True, eq=False)
class AffineInterpolant:
    """The affine interpolant of Appendix D, t from 0 to 1: X^-1 and the centre go linearly from one ellipsoid to another.

    X is the shape matrix of docs/theory.md; X^-1 is the paper's B(t), eq. (3). inverses (2, 3, 3) and centers (2, 3): at t = 0 and t = 1.
    semi_axes (3,): of the ellipsoid that moves, at t = 0. Made by ccd.interpolate_affine.
    """

    semi_axes: Floats
    inverses: Floats
    centers: Floats

    degree = 1

    def matrix(self, t):
        """M(t) (4, 4): one of the maps, all alike up to a rotation of the canonical body, that give the ellipsoid at time t."""
        inverse = (1 - t) * self.inverses[0] + t * self.inverses[1]
        return _matrix(np.linalg.cholesky(np.linalg.inv(inverse)) / self.semi_axes, (1 - t) * self.centers[0] + t * self.centers[1])

    def tensors(self, semi_axes, span):
        """As RationalMotion.tensors."""
        if not np.allclose(semi_axes, self.semi_axes, rtol=1e-12, atol=0):
            return None, f"semi_axes = {semi_axes}: this interpolant moves the ellipsoid that starts with {tuple(self.semi_axes)}"
        if span[0] < 0 or span[0] + span[1] > 1:
            return None, "an affine interpolant is given from t = 0 to t = 1 only"
        tensors = empty_tensors(q=2, p=1, det=0, mu=3, v=0, path=1)
        interpolated_tensors(tensors, self.inverses.reshape(2, 9)[:, [0, 4, 8, 1, 2, 5]], self.centers, span)
        return tensors, None
