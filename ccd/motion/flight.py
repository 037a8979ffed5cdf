"""Motions of a body from its own pose: free flight and rest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ccd import checks
from ccd.annotations import ArrayLike, Floats
from ccd.ellipsoid import Ellipsoid
from ccd.precession import NO_AXIS, SPHERE, symmetry_axes, turning_of_shape


@dataclass(frozen=True, eq=False)
class FreeFlight:
    """Constant velocity (3,), rotation at a constant angular velocity (3,) in the lab frame, semi-axes times 1 + growth_rate t.

    With moments (3,), principal moments of inertia along the semi-axes, of which only the ratios matter, the body turns freely instead, as
    a rigid body without torque; angular_velocity is then that at t = 0 (docs/theory.md, eq. (12b)).
    """

    velocity: Floats
    angular_velocity: Floats = (0.0, 0.0, 0.0)        # type: ignore[assignment]
    growth_rate: float = 0.0
    moments: Floats | None = None

    if TYPE_CHECKING:               # what may be given; the fields say what it becomes
        def __init__(self, velocity: ArrayLike, angular_velocity: ArrayLike = ..., growth_rate: float = ...,
                     moments: ArrayLike | None = ...) -> None: ...

    def __post_init__(self):
        for name in ("velocity", "angular_velocity"):
            value = checks.real_array(name, getattr(self, name), (3,), "three components")
            value.flags.writeable = False
            object.__setattr__(self, name, value)
        object.__setattr__(self, "growth_rate", checks.real_number("growth_rate", self.growth_rate))
        if self.moments is not None:
            moments = checks.principal_moments("moments", self.moments)
            moments.flags.writeable = False
            object.__setattr__(self, "moments", moments)

    @classmethod
    def of_solid(cls, ellipsoid: Ellipsoid, velocity: ArrayLike, angular_velocity: ArrayLike = (0.0, 0.0, 0.0),
                 growth_rate: float = 0.0) -> FreeFlight:
        """The flight of a free solid ellipsoid of uniform density that at t = 0 turns at angular_velocity (3,), lab frame. -> FreeFlight

        Its surface moves exactly as that of the solid. A solid of revolution precesses: its axis turns about the angular momentum L at
        the constant rate L / I_perp, the angular velocity of this flight; the spin about the axis does not show, eq. (12). For a sphere,
        whose turning does not show at all, it is zero. A solid with three different semi-axes turns freely with its moments. With growth
        it turns as it would without, as in every FreeFlight.
        """
        if not isinstance(ellipsoid, Ellipsoid):
            raise ValueError(f"ellipsoid = {ellipsoid!r}: expected a ccd.Ellipsoid")
        spin = checks.real_array("angular_velocity", angular_velocity, (3,), "three components")
        axis = symmetry_axes(ellipsoid.semi_axes[None])[0]
        if axis == NO_AXIS and spin.any():
            return cls(velocity, spin, growth_rate, ellipsoid.inertia())
        if axis == SPHERE:
            turning = np.zeros(3)
        elif axis == NO_AXIS:
            turning = spin
        else:
            moments = ellipsoid.inertia()
            turning = turning_of_shape(spin[None], ellipsoid.rotation_matrix[None, :, axis], moments[axis], moments[axis - 1])[0]
        return cls(velocity, turning, growth_rate)


def Rest() -> FreeFlight:
    """The motion of a body that stays where it is."""
    return FreeFlight((0.0, 0.0, 0.0))
