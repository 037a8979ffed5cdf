"""Arrays of pairs, on all cores."""

from dataclasses import dataclass

import numpy as np

from ccd import blocks, checks, flight_blocks
from ccd.characteristic import UNCERTAIN


@dataclass(frozen=True, eq=False)
class Bodies:
    """n ellipsoids as arrays: semi_axes (n, 3) or (3,) for all, center (n, 3), orientation (n, 4), velocity (n, 3),
    angular_velocity (n, 3) in the lab frame, growth_rate (n,) or one number. What moves may be left out: at rest."""

    semi_axes: np.ndarray
    center: np.ndarray
    orientation: np.ndarray
    velocity: np.ndarray = None
    angular_velocity: np.ndarray = None
    growth_rate: np.ndarray = None

    def __post_init__(self):
        center = checks.real_array("center", self.center, (None, 3), "an array (n, 3)")
        n = len(center)
        if np.ndim(self.semi_axes) == 1:
            semi_axes = np.tile(checks.semi_axes("semi_axes", self.semi_axes), (n, 1))
        else:
            semi_axes = checks.semi_axes("semi_axes", self.semi_axes, (n, 3), f"({n}, 3) positive lengths")
        growth_rate = 0.0 if self.growth_rate is None else self.growth_rate
        growth_rate = np.full(n, growth_rate) if np.ndim(growth_rate) == 0 else growth_rate
        values = {"center": center, "semi_axes": semi_axes,
                  "orientation": checks.unit_quaternions("orientation", self.orientation, (n, 4), f"quaternions ({n}, 4)"),
                  "growth_rate": checks.real_array("growth_rate", growth_rate, (n,), f"one number or ({n},)")}
        for name in ("velocity", "angular_velocity"):
            value = getattr(self, name)
            values[name] = np.zeros((n, 3)) if value is None else checks.real_array(name, value, (n, 3), f"an array ({n}, 3)")
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def __len__(self):
        return len(self.center)


def state(bodies_a, bodies_b):
    """State (n,) int8 of the pairs (a[k], b[k]), by Theorem 1 of the paper: +1 separate, 0 touching, -1 overlapping. Motion is ignored.

    The same answers as `ccd.state`, and the same ArithmeticError.
    """
    _check_lengths(bodies_a, bodies_b)
    states = np.empty(len(bodies_a), dtype=np.int8)
    blocks.states(_pose(bodies_a), _pose(bodies_b), states)
    if (states == UNCERTAIN).any():
        raise ArithmeticError(f"pair {(states == UNCERTAIN).argmax()}: the contact function cannot be maximised in double precision")
    return states


def contact_function(bodies_a, bodies_b):
    """The contact function f (n,) of the pairs (a[k], b[k]), eq. (1): > 1 apart, 1 touching, < 1 overlapping. Motion is ignored.

    nan where float64 cannot hold the pencil parameter (sizes some 1e20 apart).
    """
    _check_lengths(bodies_a, bodies_b)
    f = np.empty(len(bodies_a))
    blocks.contact_functions(_pose(bodies_a), _pose(bodies_b), f)
    return f


def first_contact(bodies_a, bodies_b, t_max=1.0):
    """First contacts of the pairs (a[k], b[k]) in free flight within [0, t_max]. -> time (n,), inf for none, and status (n,) int8.

    All cores share the pairs; `numba.set_num_threads(1)` makes it serial. Every pair gives the same bits whatever the number of threads,
    and the same as `ccd.first_contact` alone.
    """
    _check_lengths(bodies_a, bodies_b)
    t_max = checks.real_number("t_max", t_max, "a positive time", above=0)
    for name, bodies in (("bodies_a", bodies_a), ("bodies_b", bodies_b)):
        if (1 + bodies.growth_rate * t_max <= 0).any():
            raise ValueError(f"{name}.growth_rate: the semi-axes of a body would vanish before t_max = {t_max}")
    time, status = np.empty(len(bodies_a)), np.empty(len(bodies_a), dtype=np.int8)
    flight_blocks.first_contacts(_flights(bodies_a), _flights(bodies_b), t_max, time, status)
    return time, status


def _check_lengths(bodies_a, bodies_b):
    for name, bodies in (("bodies_a", bodies_a), ("bodies_b", bodies_b)):
        if not isinstance(bodies, Bodies):
            raise ValueError(f"{name} = {bodies!r}: expected ccd.Bodies")
    if len(bodies_a) != len(bodies_b):
        raise ValueError(f"bodies_b has {len(bodies_b)} bodies: expected as many as bodies_a, {len(bodies_a)}")


def _pose(bodies):
    return bodies.semi_axes, bodies.center, bodies.orientation


def _flights(bodies):
    return *_pose(bodies), bodies.velocity, bodies.angular_velocity, bodies.growth_rate
