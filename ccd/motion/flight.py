"""Motions of a body from its own pose: free flight and rest."""

from dataclasses import dataclass

import numpy as np

from ccd import checks


@dataclass(frozen=True, eq=False)
class FreeFlight:
    """Constant velocity (3,), rotation at a constant angular velocity (3,) in the lab frame, semi-axes times 1 + growth_rate t."""

    velocity: np.ndarray
    angular_velocity: np.ndarray = (0.0, 0.0, 0.0)
    growth_rate: float = 0.0

    def __post_init__(self):
        for name in ("velocity", "angular_velocity"):
            value = checks.real_array(name, getattr(self, name), (3,), "three components")
            value.flags.writeable = False
            object.__setattr__(self, name, value)
        object.__setattr__(self, "growth_rate", checks.real_number("growth_rate", self.growth_rate))


def Rest():
    """The motion of a body that stays where it is."""
    return FreeFlight((0.0, 0.0, 0.0))
