"""The ellipsoid: shape and pose, quadric, volume, inertia."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING

import numpy as np

from ccd import checks
from ccd.annotations import ArrayLike, Floats
from ccd.quaternions import rotation_matrices


@dataclass(frozen=True, eq=False)
class Ellipsoid:
    """An ellipsoid with semi-axes (3,), centre (3,) and orientation (4,), a quaternion (w, x, y, z) that turns body into lab.

    Quaternions need not be unit. ValueError names what is not finite, not positive or of the wrong shape.
    """

    semi_axes: Floats
    center: Floats = (0.0, 0.0, 0.0)        # type: ignore[assignment]
    orientation: Floats = (1.0, 0.0, 0.0, 0.0)        # type: ignore[assignment]

    if TYPE_CHECKING:               # what may be given; the fields say what it becomes
        def __init__(self, semi_axes: ArrayLike, center: ArrayLike = ..., orientation: ArrayLike = ...) -> None: ...

    def __post_init__(self):
        for name, value in (("semi_axes", checks.semi_axes("semi_axes", self.semi_axes)),
                            ("center", checks.real_array("center", self.center, (3,), "three coordinates")),
                            ("orientation", checks.unit_quaternions("orientation", self.orientation))):
            value.flags.writeable = False
            object.__setattr__(self, name, value)

    @property
    def rotation_matrix(self) -> Floats:
        """(3, 3): columns are the body axes in the lab frame."""
        return rotation_matrices(self.orientation[None])[0]

    @property
    def semi_axis_vectors(self) -> Floats:
        """(3, 3): columns run from the centre to the surface along the body axes, in the lab frame."""
        return self.rotation_matrix * self.semi_axes

    @property
    def shape_matrix(self) -> Floats:
        """(3, 3), X = R diag(a^2) R^T: the surface is (x - c)^T X^-1 (x - c) = 1."""
        return self.semi_axis_vectors @ self.semi_axis_vectors.T

    @property
    def quadric(self) -> Floats:
        """(4, 4), A with the surface (x, 1) A (x, 1)^T = 0 and the inside negative (paper, Sec. 2)."""
        s = self.rotation_matrix / self.semi_axes
        top = s @ s.T
        quadric = np.empty((4, 4))
        quadric[:3, :3] = top
        quadric[:3, 3] = quadric[3, :3] = -top @ self.center
        quadric[3, 3] = self.center @ top @ self.center - 1
        return quadric

    @property
    def volume(self) -> float:
        return 4 * pi / 3 * self.semi_axes.prod()

    def inertia(self, mass: float = 1.0) -> Floats:
        """Principal moments (3,) of the solid body of uniform density."""
        mass = checks.real_number("mass", mass, "a positive number", above=0)
        squares = self.semi_axes**2
        return mass / 5 * (squares.sum() - squares)


@dataclass(frozen=True, eq=False)
class AffineEllipsoid:
    """The ellipsoid with semi-axes (3,) along x, y, z, carried by X_lab = linear X_body + translation (paper, Sec. 2.1).

    linear (3, 3) may stretch, shear and mirror; ValueError where it is singular, or what is given is not finite, not positive or of the
    wrong shape.
    """

    semi_axes: Floats
    linear: Floats
    translation: Floats = (0.0, 0.0, 0.0)        # type: ignore[assignment]

    if TYPE_CHECKING:               # what may be given; the fields say what it becomes
        def __init__(self, semi_axes: ArrayLike, linear: ArrayLike, translation: ArrayLike = ...) -> None: ...

    def __post_init__(self):
        for name, value in (("semi_axes", checks.semi_axes("semi_axes", self.semi_axes)),
                            ("linear", checks.linear_map("linear", self.linear)),
                            ("translation", checks.real_array("translation", self.translation, (3,), "three coordinates"))):
            value.flags.writeable = False
            object.__setattr__(self, name, value)

    @property
    def center(self) -> Floats:
        return self.translation

    @property
    def semi_axis_vectors(self) -> Floats:
        """(3, 3): columns are where the three semi-axes of the body go: from the centre to the surface, not at right angles in general."""
        return self.linear * self.semi_axes


AnyEllipsoid = Ellipsoid | AffineEllipsoid
