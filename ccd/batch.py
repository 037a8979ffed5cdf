"""Arrays of pairs, on all cores."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numba
import numpy as np
from numpy.typing import NDArray

from ccd import blocks, checks, flight_blocks, separation, top_contact
from ccd.annotations import ArrayLike, Floats
from ccd.characteristic import UNCERTAIN, decided_state
from ccd.compiling import parallel_kernel
from ccd.tolerances import SHARP
from ccd.vectors import load


@dataclass(frozen=True, eq=False)
class Bodies:
    """n ellipsoids as arrays: semi_axes (n, 3) or (3,) for all, center (n, 3), orientation (n, 4), velocity (n, 3),
    angular_velocity (n, 3) in the lab frame, growth_rate (n,) or one number. What moves may be left out: at rest.

    moments (n, 3) or (3,) for all: the bodies turn freely with these principal moments, as in `ccd.FreeFlight`; angular_velocity is that at
    t = 0. Without them each turns at its constant angular velocity.
    """

    semi_axes: Floats
    center: Floats
    orientation: Floats
    velocity: Floats = None                 # type: ignore[assignment]
    angular_velocity: Floats = None         # type: ignore[assignment]
    growth_rate: Floats = None              # type: ignore[assignment]
    moments: Floats | None = None

    if TYPE_CHECKING:               # what may be given; the fields say what it becomes
        def __init__(self, semi_axes: ArrayLike, center: ArrayLike, orientation: ArrayLike, velocity: ArrayLike | None = ...,
                     angular_velocity: ArrayLike | None = ..., growth_rate: ArrayLike | None = ...,
                     moments: ArrayLike | None = ...) -> None: ...

    def __post_init__(self):
        center = checks.real_array("center", self.center, (None, 3), "an array (n, 3)")
        n = len(center)
        semi_axes = _semi_axes(self.semi_axes, n)
        growth_rate = 0.0 if self.growth_rate is None else self.growth_rate
        growth_rate = np.full(n, growth_rate) if np.ndim(growth_rate) == 0 else growth_rate
        values = {"center": center, "semi_axes": semi_axes,
                  "orientation": checks.unit_quaternions("orientation", self.orientation, (n, 4), f"quaternions ({n}, 4)"),
                  "growth_rate": checks.real_array("growth_rate", growth_rate, (n,), f"one number or ({n},)")}
        for name in ("velocity", "angular_velocity"):
            value = getattr(self, name)
            values[name] = np.zeros((n, 3)) if value is None else checks.real_array(name, value, (n, 3), f"an array ({n}, 3)")
        if self.moments is not None:
            moments = np.tile(self.moments, (n, 1)) if np.ndim(self.moments) == 1 else self.moments
            values["moments"] = checks.principal_moments("moments", moments, (n, 3), f"({n}, 3) positive moments of inertia")
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def __len__(self):
        return len(self.center)


@dataclass(frozen=True, eq=False)
class AffineBodies:
    """n affine poses as arrays, as `ccd.AffineEllipsoid`: semi_axes (n, 3) or (3,) for all, linear (n, 3, 3), translation (n, 3)."""

    semi_axes: Floats
    linear: Floats
    translation: Floats

    if TYPE_CHECKING:               # what may be given; the fields say what it becomes
        def __init__(self, semi_axes: ArrayLike, linear: ArrayLike, translation: ArrayLike) -> None: ...

    def __post_init__(self):
        translation = checks.real_array("translation", self.translation, (None, 3), "an array (n, 3)")
        n = len(translation)
        for name, value in (("translation", translation), ("semi_axes", _semi_axes(self.semi_axes, n)),
                            ("linear", checks.linear_map("linear", self.linear, (n, 3, 3), f"matrices ({n}, 3, 3)"))):
            object.__setattr__(self, name, value)

    def __len__(self):
        return len(self.translation)

    @property
    def center(self) -> Floats:
        return self.translation

    @property
    def semi_axis_vectors(self) -> Floats:
        """(n, 3, 3): columns are where the three semi-axes of each body go."""
        return self.linear * self.semi_axes[:, None, :]


def _semi_axes(value, n):
    if np.ndim(value) == 1:
        return np.tile(checks.semi_axes("semi_axes", value), (n, 1))
    return checks.semi_axes("semi_axes", value, (n, 3), f"({n}, 3) positive lengths")


def state(bodies_a: Bodies | AffineBodies, bodies_b: Bodies | AffineBodies) -> NDArray[np.int8]:
    """State (n,) int8 of the pairs (a[k], b[k]), by Theorem 1 of the paper: +1 separate, 0 touching, -1 overlapping. Motion is ignored.

    bodies_a, bodies_b: both Bodies or both AffineBodies. The same answers as `ccd.state`, and the same ArithmeticError.
    """
    _check_lengths(bodies_a, bodies_b)
    states = np.empty(len(bodies_a), dtype=np.int8)
    if isinstance(bodies_a, AffineBodies):
        _affine_states(*_affine_pose(bodies_a, bodies_b), states)
    else:
        blocks.states(_pose(bodies_a), _pose(bodies_b), states)
    if (states == UNCERTAIN).any():
        raise ArithmeticError(f"pair {(states == UNCERTAIN).argmax()}: the contact function cannot be maximised in double precision")
    return states


def contact_function(bodies_a: Bodies, bodies_b: Bodies) -> Floats:
    """The contact function f (n,) of the pairs (a[k], b[k]), eq. (1): > 1 apart, 1 touching, < 1 overlapping. Motion is ignored.

    bodies_a, bodies_b: both Bodies or both AffineBodies. nan where float64 cannot hold the pencil parameter (sizes some 1e20 apart).
    """
    _check_lengths(bodies_a, bodies_b)
    f = np.empty(len(bodies_a))
    if isinstance(bodies_a, AffineBodies):
        g, t, _, _ = _affine_pose(bodies_a, bodies_b)
        _affine_contact_functions(g, t, f)
    else:
        blocks.contact_functions(_pose(bodies_a), _pose(bodies_b), f)
    return f


def first_contact(bodies_a: Bodies, bodies_b: Bodies, t_max: float = 1.0) -> tuple[Floats, NDArray[np.int8]]:
    """First contacts of the pairs (a[k], b[k]) in free flight within [0, t_max]. -> time (n,), inf for none, and status (n,) int8.

    All cores share the pairs; `numba.set_num_threads(1)` makes it serial. Every pair gives the same bits whatever the number of threads,
    and the same as `ccd.first_contact` alone.
    """
    _check_lengths(bodies_a, bodies_b, (Bodies,))
    t_max = checks.real_number("t_max", t_max, "a positive time", above=0)
    for name, bodies in (("bodies_a", bodies_a), ("bodies_b", bodies_b)):
        if (1 + bodies.growth_rate * t_max <= 0).any():
            raise ValueError(f"{name}.growth_rate: the semi-axes of a body would vanish before t_max = {t_max}")
    time, status = np.empty(len(bodies_a)), np.empty(len(bodies_a), dtype=np.int8)
    if bodies_a.moments is None and bodies_b.moments is None:
        flight_blocks.first_contacts(_flights(bodies_a), _flights(bodies_b), t_max, time, status)
    else:
        top_contact.first_contacts(_tops(bodies_a), _tops(bodies_b), t_max, time, status)
    return time, status


def _check_lengths(bodies_a, bodies_b, kinds=(Bodies, AffineBodies)):
    for name, bodies in (("bodies_a", bodies_a), ("bodies_b", bodies_b)):
        if not isinstance(bodies, kinds):
            raise ValueError(f"{name} = {bodies!r}: expected {' or '.join(f'ccd.{kind.__name__}' for kind in kinds)}")
    if type(bodies_a) is not type(bodies_b):
        raise ValueError(f"bodies_b is {type(bodies_b).__name__}: expected {type(bodies_a).__name__}, as bodies_a")
    if len(bodies_a) != len(bodies_b):
        raise ValueError(f"bodies_b has {len(bodies_b)} bodies: expected as many as bodies_a, {len(bodies_a)}")


def _pose(bodies):
    return bodies.semi_axes, bodies.center, bodies.orientation


def _affine_pose(bodies_a, bodies_b):
    """What `characteristic.decided_state` takes of each pair: g (n, 3, 3), a vector a row, t (n, 3), det g (n,), aspect ratio (n,)."""
    s_a, s_b = bodies_a.semi_axis_vectors, bodies_b.semi_axis_vectors
    solved = np.linalg.solve(s_b, np.concatenate([s_a, (bodies_b.center - bodies_a.center)[:, :, None]], axis=2))
    g, t = np.ascontiguousarray(solved[:, :, :3].transpose(0, 2, 1)), np.ascontiguousarray(solved[:, :, 3])
    return g, t, np.linalg.det(s_a) / np.linalg.det(s_b), np.linalg.cond(s_a) * np.linalg.cond(s_b)


@parallel_kernel
def _affine_states(g, t, det, aspect, state):
    for k in numba.prange(len(state)):
        state[k] = decided_state((load(g[k, 0], 0), load(g[k, 1], 0), load(g[k, 2], 0)), load(t[k], 0), det[k], aspect[k])


@parallel_kernel
def _affine_contact_functions(g, t, f):
    for k in numba.prange(len(f)):
        value, _, converged = separation.contact_function((load(g[k, 0], 0), load(g[k, 1], 0), load(g[k, 2], 0)), load(t[k], 0), SHARP)
        f[k] = value if converged else np.nan


def _flights(bodies):
    return *_pose(bodies), bodies.velocity, bodies.angular_velocity, bodies.growth_rate


def _tops(bodies):
    moments = np.ones((len(bodies), 3)) if bodies.moments is None else bodies.moments
    return *_pose(bodies), bodies.velocity, bodies.angular_velocity, moments.min(axis=1, keepdims=True) / moments, bodies.growth_rate
