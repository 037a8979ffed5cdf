"""How do bodies move and turn in time? Mean squared displacements along and across their axes, and what is left of an orientation."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from analysis.axes import unit_vectors
from analysis.frames import FrameAnalysis
from ccd import checks
from ccd.annotations import Any, Array, ArrayLike, Floats

if TYPE_CHECKING:
    from MDAnalysis import AtomGroup

SAME_LAG = 1e-9                 # relative to the whole time: lags that differ by less are one
AT_ONCE = 200_000               # displacements held in memory at a time


def time_lags(times: ArrayLike, longest: float | None = None, bins: ArrayLike | None = None) -> list[tuple[float, Array, Array]]:
    """The pairs of frames in groups of equal lag: a list of (lag, first (m,), second (m,)), m pairs t[second] - t[first], by lag, 0 first.

    `times` (frames,), growing. Frames at equal intervals give as many groups as frames; others up to one a pair. `bins`, edges of lags that
    grow, put what lies between two of them into one group, whose lag is the mean of its pairs. `longest`: no lag beyond it.
    """
    times = checks.real_array("times", times, (None,), "times (frames,)")
    if len(times) == 0 or not (np.diff(times) > 0).all():
        raise ValueError(f"times = {times}: expected at least one, each later than the one before")
    first, second = np.triu_indices(len(times))
    lag = times[second] - times[first]
    if bins is None:
        kept = lag <= (np.inf if longest is None else longest * (1 + SAME_LAG))
        order = np.argsort(lag[kept], kind="stable")
        group = np.cumsum(np.diff(lag[kept][order], prepend=0.0) > SAME_LAG * (times[-1] - times[0]))
    else:
        bins = checks.real_array("bins", bins, (None,), "edges of lags, growing")
        within = np.searchsorted(bins, lag, side="right")
        kept = (within > 0) & (within < len(bins)) & (lag <= (np.inf if longest is None else longest))
        order = np.argsort(within[kept], kind="stable")
        group = within[kept][order]
    first, second, lag = first[kept][order], second[kept][order], lag[kept][order]
    starts = np.flatnonzero(np.diff(group, prepend=-1))
    return [(float(part.mean()), i, j) for part, i, j in zip(*(np.split(values, starts[1:]) for values in (lag, first, second)))] \
        if len(group) else []


def mean_over_lags(groups, n, quantity):
    """The mean over the pairs of frames of each group and the n bodies of the q rows that quantity(first, second) (q, pairs, n) has.

    -> means (q, m) and their standard errors (q, m), from how the n bodies differ, each a mean over its pairs; nan for a single body.
    """
    means, errors = [], []
    for _, first, second in groups:
        parts = max(1, len(first) * n // AT_ONCE)
        sums = sum(quantity(i, j).sum(axis=1) for i, j in zip(np.array_split(first, parts), np.array_split(second, parts)))
        bodies = sums / len(first)
        means.append(bodies.mean(axis=1))
        errors.append(bodies.std(axis=1, ddof=1) / np.sqrt(n) if n > 1 else np.full(len(bodies), np.nan))
    return np.array(means).T, np.array(errors).T


def mean_squared_displacement(positions: ArrayLike, axes: ArrayLike, times: ArrayLike, longest: float | None = None,
                              bins: ArrayLike | None = None) -> tuple[Floats, Floats, Floats, Floats]:
    """Mean squared displacement, whole, along and across the axis that each body had at the start of the interval.

    <|d|^2>, <(d.u(0))^2> and their difference, the two directions across together, with d = r(t) - r(0), over bodies and time origins.
    `positions` (frames, n, 3) unwrapped, `axes` (frames, n, 3) unit vectors, `times` (frames,); groups of lags as `time_lags`. At first
    v^2 t^2, in ratio 1 : 2 at equal temperature; once the axis is forgotten 2 D t and 4 D t. A common drift is not taken away. Returns
    (lag (m,), total (m,), parallel (m,), perpendicular (m,)).
    """
    lags, (total, parallel, perpendicular), _ = squared_displacements(positions, axes, times, longest, bins)
    return lags, total, parallel, perpendicular


def squared_displacements(positions, axes, times, longest, bins):
    """The lags (m,), `mean_squared_displacement` as rows (3, m), and the standard errors (3, m)."""
    positions = checks.real_array("positions", positions, (None, None, 3), "unwrapped positions (frames, n, 3)")
    axes = unit_vectors("axes", axes, positions.shape, f"unit vectors {positions.shape}")
    groups = groups_of(positions, times, longest, bins)

    def squares(first, second):
        moved = positions[second] - positions[first]
        total, parallel = np.sum(moved**2, axis=2), np.sum(moved * axes[first], axis=2)**2
        return np.array([total, parallel, total - parallel])

    return np.array([lag for lag, *_ in groups]), *mean_over_lags(groups, positions.shape[1], squares)


def orientational_correlation(axes: ArrayLike, times: ArrayLike, longest: float | None = None,
                              bins: ArrayLike | None = None) -> tuple[Floats, Floats, Floats]:
    """C1 = <u(0).u(t)> and C2 = <P2(u(0).u(t))>, P2(x) = (3 x^2 - 1) / 2: what is left of an orientation after a time.

    1 at first, 0 when it is forgotten (in a nematic, the square of the order). C1 tells the two ends of a body apart, C2 does not.
    `axes` (frames, n, 3) unit vectors, `times` (frames,); groups of lags as `time_lags`. Returns (lag (m,), c1 (m,), c2 (m,)).
    """
    lags, (c1, c2), _ = axis_correlations(axes, times, longest, bins)
    return lags, c1, c2


def axis_correlations(axes, times, longest, bins):
    """The lags (m,), `orientational_correlation` as rows (2, m), and the standard errors (2, m)."""
    axes = unit_vectors("axes", axes, (None, None, 3), "unit vectors (frames, n, 3)")
    groups = groups_of(axes, times, longest, bins)

    def legendre(first, second):
        cosine = np.sum(axes[first] * axes[second], axis=2)
        return np.array([cosine, 1.5 * cosine**2 - 0.5])

    return np.array([lag for lag, *_ in groups]), *mean_over_lags(groups, axes.shape[1], legendre)


def groups_of(frames, times, longest, bins):
    """The groups of `time_lags`; ValueError unless there is a time for every frame, and a pair of frames."""
    if np.shape(times) != (len(frames),):
        raise ValueError(f"times has shape {np.shape(times)}: expected ({len(frames)},), one for each frame")
    groups = time_lags(times, longest, bins)
    if not groups:
        raise ValueError(f"bins = {bins}, longest = {longest}: no pair of frames has such a lag")
    return groups


class LagAnalysis(FrameAnalysis):
    """Frames are gathered (all stay in memory), and lags between them averaged at the end, in the groups of `time_lags`.

    MEANS: their names, in `results` each (m,) and, as NAME_error, its standard error (m,).
    """

    MEANS: tuple[str, ...] = ()

    def __init__(self, atomgroup: AtomGroup, longest: float | None = None, bins: ArrayLike | None = None, **kwargs: Any) -> None:
        super().__init__(atomgroup, **kwargs)
        self.longest, self.bins = longest, bins

    def _conclude(self):
        super()._conclude()
        gathered = [self.results.pop(name) for name in self.SERIES]
        self.results.lag, means, errors = self._over_lags(*gathered, self.times, self.longest, self.bins)
        for name, mean, error in zip(self.MEANS, means, errors, strict=True):
            self.results[name], self.results[f"{name}_error"] = mean, error


class MeanSquaredDisplacement(LagAnalysis):
    """Mean squared displacements of the atoms: `MeanSquaredDisplacement(u.atoms).run()`.

    `results.lag`, `results.total`, `results.parallel`, `results.perpendicular` (m,), as `mean_squared_displacement` of the unwrapped
    positions in float64 about the `body_axes`; `results.total_error` and so on (m,): standard errors over the bodies, each a mean over its
    time origins (what neighbours have in common makes them a little too small). MDAnalysis' `EinsteinMSD` gives the total in float32, after
    `analysis.unwrap`.
    """

    SERIES = ("positions", "axes")
    MEANS = ("total", "parallel", "perpendicular")
    _over_lags = staticmethod(squared_displacements)

    def _frame(self):
        return self.atomgroup.unwrapped_positions, self.axes


class OrientationalCorrelation(LagAnalysis):
    """Orientational correlation functions of the atoms: `OrientationalCorrelation(u.atoms).run()`.

    `results.lag`, `results.c1`, `results.c2` (m,), as `orientational_correlation` of the `body_axes`; `results.c1_error` and
    `results.c2_error` (m,): standard errors over the bodies, each a mean over its time origins.
    """

    SERIES = ("axes",)
    MEANS = ("c1", "c2")
    _over_lags = staticmethod(axis_correlations)

    def _frame(self):
        return (self.axes,)
