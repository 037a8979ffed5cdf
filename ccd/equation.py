"""The CCD equation of two moving ellipsoids, and its solution (paper, Sec. 3)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ccd import checks
from ccd.annotations import Any, ArrayLike, Floats, Span
from ccd.answers import Contact, Interval
from ccd.bernstein import binomials
from ccd.bezier_shoot import best_certificate, recursive_shoot, state_of
from ccd.ellipsoid import Ellipsoid
from ccd.grid import condition, degrees, empty_grid, empty_work, fill_grid, quartic, touch
from ccd.intervals import PIECES, STACK, separation_intervals, tangent_instant
from ccd.intervals import empty_work as loop_work
from ccd.motion import AffineInterpolant, AffineMotion, FreeFlight, Motion, RationalMotion, approximate_flight
from ccd.motion.tensors import Tensors
from ccd.status import State, Status
from ccd.tolerances import CONDITION, CONTACT_EXCESS, EXTREME, HALVINGS, SMALLEST

NOWHERE = (np.nan,) * 3


class CCDEquation:
    """F(u, t) = 0 for two ellipsoids under rational motions (paper, Sec. 3.1). F > 0 for some u in (0, 1]: separate at t.

    a, b: Ellipsoid; motions: RationalMotion, AffineMotion, what ccd.interpolate_affine makes, Rest(), or FreeFlight without rotation.
    F is det((u - 1) A(t) - u B(t)) times a positive factor that clears the denominators. `minimal` (5, minimal_degree_t + 1) holds its
    Bernstein coefficients in u and, over t_span, in t, after every common factor that the kinds of motion imply is cancelled; `bernstein`
    (5, degree_t + 1) those of the paper's F, which carries the factors of eq. (24). It is solved at the minimal degree, or with
    degree="paper" at the paper's. ValueError for what is no motion of an ellipsoid within t_span: a denominator or quaternion
    polynomial that vanishes, a map that is singular. ArithmeticError where float64 cannot hold F (sizes some 1e40 apart).
    """

    def __init__(self, a: Ellipsoid, motion_a: Motion, b: Ellipsoid, motion_b: Motion, t_span: Span = (0.0, 1.0),
                 degree: str = "minimal") -> None:
        self.t_span = start, end = checks.time_span("t_span", t_span)
        if degree not in ("minimal", "paper"):
            raise ValueError(f"degree = {degree!r}: expected 'minimal' or 'paper'")
        self._bodies = _body("a", a, "motion_a", motion_a), _body("b", b, "motion_b", motion_b)
        self._whole = self._part(start, end - start)
        self._parts = list(self._well_conditioned(self._whole, HALVINGS))
        if degree == "paper":
            for part in self._parts:
                part.grid = self._raise(part.grid, part)

    @property
    def minimal_degree_t(self) -> int:
        """Degree of F in t after cancelling common factors, eq. (23)."""
        return self.minimal.shape[1] - 1

    @cached_property
    def degree_t(self) -> int:
        """Degree of F in t as the paper counts it, eq. (24)."""
        affine = sum(6 * motion.degree for _, _, motion in self._bodies if not isinstance(motion, RationalMotion))
        return max(self.minimal_degree_t + len(self._paper_factor(self._whole)) - 1, affine)

    @cached_property
    def minimal(self) -> Floats:
        """F (5, minimal_degree_t + 1) after cancelling common factors."""
        return _quartic(_grid(self._whole.a, self._whole.b))

    @cached_property
    def bernstein(self) -> Floats:
        """The paper's F (5, degree_t + 1)."""
        return _quartic(self._raise(_grid(self._whole.a, self._whole.b), self._whole))

    def __call__(self, u: ArrayLike, t: ArrayLike) -> Any:
        """F at u and t, arrays that broadcast: the polynomial of `bernstein`."""
        from scipy.interpolate import BPoly  # here, because it takes longer to import than everything else together

        u, t = np.broadcast_arrays(*(np.asarray(x, dtype=float) for x in (u, t)))
        rows = BPoly(self.bernstein.T[:, None], np.array(self.t_span))(t)
        basis = [choose * u**i * (1 - u)**(4 - i) for i, choose in enumerate((1, 4, 6, 4, 1))]
        return sum(rows[..., i] * basis[i] for i in range(5))

    def contact_intervals(self) -> list[Interval]:
        """All maximal separation and overlapping intervals in order of time (paper, Sec. 3.2). -> list of Interval"""
        pieces: list[list[Any]] = []                                  # [start, end, State], end to end over the time span
        for part in self._parts:
            here = part.pieces()
            if pieces and pieces[-1][2] == here[0][2]:
                if here[0][2] != State.TOUCHING and state_of(self._contact_at(part.start)[0]) == 0:
                    pieces.append([part.start, part.start, State.TOUCHING])
                else:
                    here[0][0] = pieces.pop()[0]
            pieces += here
        points = [self._contact_at(time)[1] for time in [start for start, _, _ in pieces] + [self.t_span[1]]]
        return [Interval(start, end, State(state), np.array(points[k]), np.array(points[k + 1]))
                for k, (start, end, state) in enumerate(pieces)]

    def first_contact(self) -> Contact:
        """The first contact by recursive Bézier shoots (paper, Sec. 3.3). -> Contact, as from ccd.first_contact"""
        shoots = 0
        for k, part in enumerate(self._parts):
            status, s, u, count = recursive_shoot(part.grid, 0.5, 1.0, loop_work(part.grid.shape[1] - 1))
            shoots += count
            if status == Status.OVERLAPPING and k > 0:      # rounding at the border of two parts: the shoot came here without contact
                status = Status.CONTACT
            if status != Status.NO_CONTACT:
                break
        if status == Status.NO_CONTACT:
            return Contact(Status.NO_CONTACT, np.inf, np.array(NOWHERE), np.array(NOWHERE), shoots)
        point, normal = touch(part.a, part.b, s, u)
        time = part.start + s * part.width
        reason = "" if status != Status.UNRESOLVED else f"at t = {time} the shoots neither arrive at a contact nor get on"
        return Contact(Status(status), time, np.array(point), np.array(normal), shoots, reason)

    def _contact_at(self, time):
        """f - 1, and where the bodies touch at one time; nowhere when they do not."""
        part = next((each for each in self._parts if time <= each.start + each.width), self._parts[-1])
        s = min((time - part.start) / part.width, 1.0)
        excess, u, _ = best_certificate(part.grid, s, 0.5)
        return excess, touch(part.a, part.b, s, u)[0] if abs(excess) <= CONTACT_EXCESS else NOWHERE

    def _part(self, start, width):
        tensors = []
        for name, body, motion in self._bodies:
            own, fault = motion.tensors(tuple(body.semi_axes.tolist()), (start, width))
            if fault:
                raise ValueError(f"{name}.{fault} within t_span = ({start}, {start + width})")
            tensors.append(own)
        grid = _grid(*tensors)
        small = self._bodies[0][1].semi_axes.max() < SMALLEST * self._bodies[1][1].semi_axes.max()
        if small or not (1 / EXTREME < grid[0, 0] < EXTREME and 1 / EXTREME < grid[3, 0] < EXTREME):     # nor nan
            sizes = " and ".join(str(body.semi_axes.tolist()) for _, body, _ in self._bodies)
            raise ArithmeticError(f"double precision cannot hold the equation of bodies of such sizes: {sizes}")
        first, second = tensors
        return _Part(start, width, first, second, grid)

    def _well_conditioned(self, part, halvings):
        """The span cut into parts on which the terms of F do not cancel by more than CONDITION."""
        if halvings == 0 or condition(part.grid, np.empty((2, part.grid.shape[1]))) <= CONDITION:
            yield part
        else:
            half = 0.5 * part.width
            for start in (part.start, part.start + half):
                yield from self._well_conditioned(self._part(start, half), halvings - 1)

    def _paper_factor(self, part):
        """The factor, weighted coefficients, by which the paper's F exceeds the minimal one for Euclidean motions, eq. (24)."""
        (_, _, motion_a), (_, _, motion_b) = self._bodies
        mu_a = part.a.mu if isinstance(motion_a, RationalMotion) else np.ones(1)
        mu_b = part.b.mu if isinstance(motion_b, RationalMotion) else np.ones(1)
        if len(part.a.v) == len(part.b.v) == 1:
            return _product(mu_a, mu_a, mu_b, mu_b, mu_b)
        return _product(*3 * [mu_a, mu_b, part.a.v, part.a.v, part.b.v, part.b.v])

    def _raise(self, minimal, part):
        """A grid of the minimal degree as that of the paper's F."""
        grid, factor = empty_grid(self.degree_t), self._paper_factor(part)
        grid[:7] = [_product(row, factor, binomials(self.degree_t + 2 - len(row) - len(factor))) for row in minimal[:7]]
        return grid


@dataclass
class _Part:
    """A part of the time span: the bodies' tensors and the grid of the equation, with time counted from 0 to 1."""

    start: float
    width: float
    a: Tensors
    b: Tensors
    grid: np.ndarray

    def pieces(self):
        """[start, end, State] end to end; a tangential contact is an instant."""
        found, work = np.empty(PIECES), loop_work(self.grid.shape[1] - 1)
        pieces = found[:separation_intervals(self.grid, found, np.empty(STACK), work)].tolist()
        for k, (start, end, state) in enumerate(pieces):
            if state == State.TOUCHING and (instant := tangent_instant(self.grid, start, end, work)) >= 0:
                pieces[k][:2] = instant, instant
                if k > 0:
                    pieces[k - 1][1] = instant
                if k + 1 < len(pieces):
                    pieces[k + 1][0] = instant
        return [[self.start + self.width * start, self.start + self.width * end, state] for start, end, state in pieces]


def _body(name, body, motion_name, motion):
    """The body and its motion as one with polynomial tensors, and the motion's name for errors."""
    if not isinstance(body, Ellipsoid):
        raise ValueError(f"{name} = {body!r}: expected a ccd.Ellipsoid")
    if isinstance(motion, FreeFlight):
        if motion.angular_velocity.any():
            raise ValueError(f"{motion_name}: a free flight with rotation is not rational; ccd.approximate_flight makes it so")
        motion = approximate_flight(body, motion, degree=1)
    elif not isinstance(motion, (RationalMotion, AffineMotion, AffineInterpolant)):
        raise ValueError(f"{motion_name} = {motion!r}: expected a ccd.RationalMotion, ccd.AffineMotion, ccd.FreeFlight or ccd.Rest()")
    return motion_name, body, motion


def _grid(a, b):
    degree_r, rows = degrees(a, b)
    grid = empty_grid(max(rows))
    fill_grid(grid, a, b, degree_r, empty_work(max(rows)))
    return grid


def _quartic(grid):
    out = np.empty((5, grid.shape[1]))
    quartic(grid, 1.0, out)
    return out


def _product(first, *others):
    for each in others:
        first = np.convolve(first, each)
    return first
