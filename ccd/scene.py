"""The first contact between two groups of ellipsoids within a frame, with culling and a running bound on its time (paper, Sec. 4.1)."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum
from math import inf, nan, sqrt
from typing import NamedTuple

import numpy as np

from ccd.annotations import Floats
from ccd.batch import Bodies
from ccd.bezier_shoot import recursive_shoot
from ccd.compiling import kernel
from ccd.frame_culling import plane_holds, spheres_meet
from ccd.grid import empty_grid, fill_grid, touch
from ccd.motion import RationalMotion
from ccd.motion.tensors import Tensors, interpolated_tensors, rigid_tensors
from ccd.rotation import body_axes, load_quaternion
from ccd.separation import balance, best_plane, semi_axis_vectors, shape_matrix, support
from ccd.status import Status
from ccd.tolerances import EXACT, TOUCHING
from ccd.vectors import add, add_scaled, dot, load, scale, store, subtract

INTERPOLANTS = ("rigid", "affine")
DEGREE = {True: 10, False: 5}               # of F in t, eq. (23), for rigid and affine motions
ROW = 17                                    # semi-axes, centre and quaternion at the start, centre and quaternion at the end


class Outcome(IntEnum):
    """What became of a pair in a frame."""

    SPHERES_APART = 0           # removed by the bounding spheres
    PLANE_HOLDS = 1             # removed by the separating plane
    OVERLAPPING = 2             # when the frame starts
    NO_CONTACT = 3              # solved: none within the frame, or none before the earliest contact known by then
    CONTACT = 4
    UNRESOLVED = 5


SPHERES_APART, PLANE_HOLDS, OVERLAPPING, NO_CONTACT, CONTACT, UNRESOLVED = (int(outcome) for outcome in Outcome)
SOLVED = {Status.NO_CONTACT: NO_CONTACT, Status.CONTACT: CONTACT, Status.OVERLAPPING: OVERLAPPING, Status.UNRESOLVED: UNRESOLVED}
OUTCOME_OF = tuple(SOLVED[status] for status in Status)         # by the number of the Status


class Counts(NamedTuple):
    """How many pairs there were, and what became of them; solved: for how many the CCD equation was solved."""

    pairs: int
    spheres_apart: int
    plane_holds: int
    overlapping: int
    solved: int
    contacts: int


class FrameContact(NamedTuple):
    """The earliest contact in a frame.

    status: CONTACT, NO_CONTACT, OVERLAPPING (a pair does so when the frame starts: time 0) or UNRESOLVED (some pair could not be told, and
    no other touches before). time from 0 to 1, inf for none; pair (i, j), (-1, -1) for none; point and normal, from A to B, nan unless
    CONTACT. outcomes (n_a, n_b): Outcome of every pair; times (n_a, n_b): contact times, inf for none.
    """

    status: Status
    time: float
    pair: tuple
    point: np.ndarray
    normal: np.ndarray
    counts: Counts
    outcomes: np.ndarray
    times: np.ndarray


@dataclass(frozen=True, eq=False)
class Group:
    """n ellipsoids at the start and at the end of a frame: ccd.Bodies of the same semi-axes. Their velocities are not used."""

    start: Bodies
    end: Bodies
    rows: Floats = field(init=False, repr=False)            # of each: semi-axes, poses at the start and at the end

    def __post_init__(self):
        for name in ("start", "end"):
            if not isinstance(getattr(self, name), Bodies):
                raise ValueError(f"{name} = {getattr(self, name)!r}: expected ccd.Bodies")
        if not np.array_equal(self.start.semi_axes, self.end.semi_axes):
            raise ValueError("end.semi_axes: expected the same bodies with the same semi-axes as start")
        turned = (self.start.orientation * self.end.orientation).sum(axis=1, keepdims=True)
        shorter = np.where(turned < 0, -self.end.orientation, self.end.orientation)
        rows = np.hstack([self.start.semi_axes, self.start.center, self.start.orientation, self.end.center, shorter])
        object.__setattr__(self, "rows", rows)

    def __len__(self):
        return len(self.start)

    def motion(self, k: int) -> RationalMotion:
        """The rigid interpolant of one body, t from 0 to 1."""
        row = self.rows[k]
        return RationalMotion(np.stack([row[6:10], row[13:17] - row[6:10]], axis=1), np.stack([row[3:6], row[10:13] - row[3:6]], axis=1))


def first_contact(group_a: Group, group_b: Group, interpolant: str = "rigid", planes: bool | None = None,
                  running_bound: bool = True) -> FrameContact:
    """The earliest contact between a body of one group and a body of the other within a frame (paper, Sec. 4.1). -> FrameContact

    interpolant: how bodies move in between: "rigid" (linear quaternion curve and translation) or "affine" (Appendix D, relative to the
    body of group A). Pairs whose bounding spheres do not meet are left out; with planes (default: for "rigid", where it is defined)
    also those that keep to both sides of a plane carried along with B; with running_bound contacts are sought only up to the earliest
    one known. "affine" gives point and normal in the lab by the rigid pose of A.
    """
    for name, group in (("group_a", group_a), ("group_b", group_b)):
        if not isinstance(group, Group):
            raise ValueError(f"{name} = {group!r}: expected a ccd.scene.Group")
    if interpolant not in INTERPOLANTS:
        raise ValueError(f"interpolant = {interpolant!r}: expected 'rigid' or 'affine'")
    rigid = interpolant == "rigid"
    if planes and not rigid:
        raise ValueError("planes = True: a plane can be carried along with interpolant='rigid' only")
    planes = rigid if planes is None else bool(planes)
    outcomes, times = np.empty((len(group_a), len(group_b)), dtype=np.int8), np.full((len(group_a), len(group_b)), inf)
    space = _space(len(group_a), len(group_b), rigid)
    time, pair, point, normal = _frame(group_a.rows, group_b.rows, (rigid, planes, bool(running_bound)), outcomes, times, space)
    tally = np.bincount(outcomes.ravel(), minlength=len(Outcome)).tolist()
    apart, held, overlapping, *solved = tally
    counts = Counts(outcomes.size, apart, held, overlapping, sum(solved), tally[Outcome.CONTACT])
    return FrameContact(_status(time, pair, outcomes, times), time, pair, np.array(point), np.array(normal), counts, outcomes, times)


def _status(time, pair, outcomes, times):
    if (times[outcomes == Outcome.UNRESOLVED] < time).any():
        return Status.UNRESOLVED
    if pair[0] < 0:
        return Status.NO_CONTACT
    return Status.OVERLAPPING if outcomes[pair] == Outcome.OVERLAPPING else Status.CONTACT


class _Space(NamedTuple):
    """What a frame needs to work in: the tensors of the bodies (one after the other), which of them are there already, one grid."""

    a: Tensors
    b: Tensors
    ready_a: np.ndarray
    ready_b: np.ndarray
    grid: np.ndarray
    tall: np.ndarray
    wide: np.ndarray


def _stack(n, q, p, det, mu, path):
    return Tensors(np.empty((n, q + 1, 6)), np.empty((n, p + 1, 6)), np.empty((n, det + 1)), np.empty((n, mu + 1)), np.ones((n, 1)),
                   np.empty((n, path + 1, 3)))


def _space(n_a, n_b, rigid):
    if rigid:
        a, b = _stack(n_a, 4, 4, 4, 4, 1), _stack(n_b, 4, 4, 4, 4, 1)
    else:                               # relative motions belong to a pair: one at a time
        a, b = _stack(1, 0, 0, 0, 0, 0), _stack(1, 2, 1, 0, 3, 1)
    degree = DEGREE[rigid]
    return _Space(a, b, np.zeros(n_a, dtype=np.bool_), np.zeros(n_b, dtype=np.bool_), empty_grid(degree),
                  np.empty((degree + 1, 15)), np.empty((12, degree + 1)))


@kernel
def _member(stack, k):
    return Tensors(stack.q[k], stack.p[k], stack.det[k], stack.mu[k], stack.v[k], stack.path[k])


@kernel
def _into(axes, v):
    """A vector in the frame whose axes are given."""
    return (dot(axes[0], v), dot(axes[1], v), dot(axes[2], v))


@kernel
def _out_of(axes, v):
    """A vector given in the frame of some axes, in the lab."""
    return add_scaled(add_scaled(scale(v[0], axes[0]), v[1], axes[1]), v[2], axes[2])


@kernel
def _pose_between(row, t):
    """Axes and centre of a body under the rigid interpolant."""
    p, q = load_quaternion(row, 6), load_quaternion(row, 13)
    w, x, y, z = p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1]), p[2] + t * (q[2] - p[2]), p[3] + t * (q[3] - p[3])
    length = sqrt(w * w + x * x + y * y + z * z)
    axes = body_axes((w / length, x / length, y / length, z / length))
    return axes, add_scaled(load(row, 3), t, subtract(load(row, 10), load(row, 3)))


@kernel
def _rigid_member(stack, ready, k, row, work):
    """The tensors of a body under the rigid interpolant, made when they are first asked for."""
    tensors = _member(stack, k)
    if not ready[k]:
        ready[k] = True
        tall, wide = work
        rotation, translation, one = wide[0:4, :2], wide[4:7, :2], wide[7, :1]
        one[0] = 1.0
        for i in range(4):
            rotation[i, 0], rotation[i, 1] = row[6 + i], row[13 + i] - row[6 + i]
        for i in range(3):
            translation[i, 0], translation[i, 1] = row[3 + i], row[10 + i] - row[3 + i]
        rigid_tensors(tensors, load(row, 0), (rotation, translation, one), (0.0, 1.0), (tall, wide[8:]))
    return tensors


@kernel
def _affine_pair(a, b, row_a, row_b, work):
    """The tensors of a pair under the affine interpolant, as seen from the canonical frame of A (paper, Appendix D)."""
    inverses, centers = work[:2, :6], work[2:4, :3]
    size_a, size_b = load(row_a, 0), load(row_b, 0)
    for end in range(2):
        axes_a, axes_b = body_axes(load_quaternion(row_a, 6 + 7 * end)), body_axes(load_quaternion(row_b, 6 + 7 * end))
        t = (scale(1 / size_b[0], _into(axes_a, axes_b[0])), scale(1 / size_b[1], _into(axes_a, axes_b[1])),
             scale(1 / size_b[2], _into(axes_a, axes_b[2])))
        inverse = shape_matrix(t)
        center = _into(axes_a, subtract(load(row_b, 3 + 7 * end), load(row_a, 3 + 7 * end)))
        for k in range(6):
            inverses[end, k] = inverse[k]
        store(centers[end], 0, center)
    squares = size_a[0]**2, size_a[1]**2, size_a[2]**2
    for k in range(3):
        a.q[0, k], a.q[0, k + 3], a.p[0, k + 3], a.path[0, k] = squares[k], 0.0, 0.0, 0.0
        a.p[0, k] = squares[(k + 1) % 3] * squares[(k + 2) % 3]
    a.det[0], a.mu[0] = squares[0] * squares[1] * squares[2], 1.0
    interpolated_tensors(b, inverses, centers, (0.0, 1.0))


@kernel
def _pair(row_a, row_b, pair, options, bound, space):
    """One pair of a frame, up to a bound on the time. -> outcome, time, u"""
    i, j = pair
    rigid, planes = options
    s_a = semi_axis_vectors(load(row_a, 0), body_axes(load_quaternion(row_a, 6)))
    s_b = semi_axis_vectors(load(row_b, 0), body_axes(load_quaternion(row_b, 6)))
    r_start, r_end = subtract(load(row_b, 3), load(row_a, 3)), subtract(load(row_b, 10), load(row_a, 10))
    n, x, converged = best_plane(s_a, s_b, r_start, balance(shape_matrix(s_a), shape_matrix(s_b)), EXACT)
    h_a, h_b = support(s_a, n), support(s_b, n)
    if dot(r_start, r_start) == 0.0 or dot(n, r_start) - h_a - h_b < -TOUCHING * (h_a + h_b):
        return OVERLAPPING, 0.0, 0.5
    if not converged:
        return UNRESOLVED, 0.0, 0.5
    work = (space.tall, space.wide)
    if rigid:
        a, b = _rigid_member(space.a, space.ready_a, i, row_a, work), _rigid_member(space.b, space.ready_b, j, row_b, work)
        if planes:
            q_start, q_end = load_quaternion(row_b, 6), load_quaternion(row_b, 13)
            m = _into(body_axes(q_start), n)
            if plane_holds((m, h_b), (q_start, q_end), (r_start, r_end), a, bound, space.wide):
                return PLANE_HOLDS, inf, 0.5
    else:
        a, b = _member(space.a, 0), _member(space.b, 0)
        _affine_pair(a, b, row_a, row_b, space.wide)
    fill_grid(space.grid, a, b, 1, work)
    status, time, u, _ = recursive_shoot(space.grid, 1 - x, bound, space.wide)
    return OUTCOME_OF[status], time, u


@kernel
def _frame(rows_a, rows_b, options, outcomes, times, space):
    """Every pair of a frame. options: (rigid, planes, running bound). -> time of the earliest contact, its pair, point and normal."""
    rigid, planes, running_bound = options
    earliest, first_i, first_j, best_u = inf, -1, -1, 0.5
    for i in range(rows_a.shape[0]):
        row_a = rows_a[i]
        axes_start, axes_end = body_axes(load_quaternion(row_a, 6)), body_axes(load_quaternion(row_a, 13))
        for j in range(rows_b.shape[0]):
            row_b = rows_b[j]
            bound = min(earliest, 1.0) if running_bound else 1.0
            reach = max(load(row_a, 0)) + max(load(row_b, 0))
            r_start, r_end = subtract(load(row_b, 3), load(row_a, 3)), subtract(load(row_b, 10), load(row_a, 10))
            if not rigid:
                r_start, r_end = _into(axes_start, r_start), _into(axes_end, r_end)
            if not spheres_meet(r_start, r_end, reach, bound):
                outcomes[i, j] = SPHERES_APART
                continue
            outcome, time, u = _pair(row_a, row_b, (i, j), (rigid, planes), bound, space)
            outcomes[i, j], times[i, j] = outcome, time
            if outcome in (CONTACT, OVERLAPPING) and time < earliest:
                earliest, first_i, first_j, best_u = time, i, j, u
    point = n = (nan, nan, nan)
    if first_i >= 0 and outcomes[first_i, first_j] == CONTACT:
        if rigid:
            a, b = _member(space.a, first_i), _member(space.b, first_j)
        else:
            a, b = _member(space.a, 0), _member(space.b, 0)
            _affine_pair(a, b, rows_a[first_i], rows_b[first_j], space.wide)
        point, n = touch(a, b, earliest, best_u)
        if not rigid:
            axes, center = _pose_between(rows_a[first_i], earliest)
            point, n = add(center, _out_of(axes, point)), _out_of(axes, n)
    return earliest, (first_i, first_j), point, n
