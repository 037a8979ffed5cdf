"""What the questions of the collision detection return."""

from typing import NamedTuple

import numpy as np

from ccd.status import State, Status


class Separation(NamedTuple):
    """How two ellipsoids at rest stand to each other, eq. (1).

    contact_function f: > 1 apart, 1 touching, < 1 overlapping; sqrt(f) is the factor by which both must grow to touch.
    gap: signed distance of the two supporting planes whose normal is `normal` (unit, from A to B): a lower bound of the distance when
    positive. point: where the bodies touch, when they do. pencil_parameter: the maximiser lambda in (0, 1).
    """

    state: State
    contact_function: float
    gap: float
    normal: np.ndarray
    point: np.ndarray
    pencil_parameter: float


class Contact(NamedTuple):
    """A first contact. time is inf for NO_CONTACT; normal (from A to B) and point are nan then. iterations: steps of the shoot.
    reason: for UNRESOLVED, what could not be told and where."""

    status: Status
    time: float
    point: np.ndarray
    normal: np.ndarray
    iterations: int
    reason: str = ""


class Interval(NamedTuple):
    """A maximal interval of time throughout which two ellipsoids are in one state (paper, Sec. 3.2).

    start_point, end_point (3,): where they touch at its ends; nan at an end of the time span where they do not. TOUCHING intervals, mostly
    a single instant (start == end), are contacts at which the bodies do not overlap, or do not come apart: tangential ones. UNRESOLVED is
    what could not be decided in double precision.
    """

    start: float
    end: float
    state: State
    start_point: np.ndarray
    end_point: np.ndarray
