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
    """The mean over the pairs of frames of each group and the n bodies of each of the rows that quantity(first, second) has."""
    means = []
    for _, first, second in groups:
        parts = max(1, len(first) * n // AT_ONCE)
        sums = sum(quantity(i, j) for i, j in zip(np.array_split(first, parts), np.array_split(second, parts)))
        means.append(sums / (len(first) * n))
    return np.array(means).T


def mean_squared_displacement(positions: ArrayLike, axes: ArrayLike, times: ArrayLike, longest: float | None = None,
                              bins: ArrayLike | None = None) -> tuple[Floats, Floats, Floats, Floats]:
    """Mean squared displacement, whole, along and across the axis that each body had at the start of the interval.

    <|d|^2>, <(d.u(0))^2> and their difference, the two directions across together, with d = r(t) - r(0), over bodies and time origins.
    `positions` (frames, n, 3) unwrapped, `axes` (frames, n, 3) unit vectors, `times` (frames,); groups of lags as `time_lags`. At first
    v^2 t^2, in ratio 1 : 2 at equal temperature; once the axis is forgotten 2 D t and 4 D t. A common drift is not taken away. Returns
    (lag (m,), total (m,), parallel (m,), perpendicular (m,)).
    """
    positions = checks.real_array("positions", positions, (None, None, 3), "unwrapped positions (frames, n, 3)")
    axes = unit_vectors("axes", axes, positions.shape, f"unit vectors {positions.shape}")
    groups = groups_of(positions, times, longest, bins)

    def squares(first, second):
        moved = positions[second] - positions[first]
        return np.array([np.sum(moved**2), np.sum(np.sum(moved * axes[first], axis=2)**2)])

    total, parallel = mean_over_lags(groups, positions.shape[1], squares)
    return np.array([lag for lag, *_ in groups]), total, parallel, total - parallel


def orientational_correlation(axes: ArrayLike, times: ArrayLike, longest: float | None = None,
                              bins: ArrayLike | None = None) -> tuple[Floats, Floats, Floats]:
    """C1 = <u(0).u(t)> and C2 = <P2(u(0).u(t))>, P2(x) = (3 x^2 - 1) / 2: what is left of an orientation after a time.

    1 at first, 0 when it is forgotten (in a nematic, the square of the order). C1 tells the two ends of a body apart, C2 does not.
    `axes` (frames, n, 3) unit vectors, `times` (frames,); groups of lags as `time_lags`. Returns (lag (m,), c1 (m,), c2 (m,)).
    """
    axes = unit_vectors("axes", axes, (None, None, 3), "unit vectors (frames, n, 3)")
    groups = groups_of(axes, times, longest, bins)

    def legendre(first, second):
        cosine = np.sum(axes[first] * axes[second], axis=2)
        return np.array([np.sum(cosine), np.sum(1.5 * cosine**2 - 0.5)])

    c1, c2 = mean_over_lags(groups, axes.shape[1], legendre)
    return np.array([lag for lag, *_ in groups]), c1, c2


def groups_of(frames, times, longest, bins):
    """The groups of `time_lags`; ValueError unless there is a time for every frame, and a pair of frames."""
    if np.shape(times) != (len(frames),):
        raise ValueError(f"times has shape {np.shape(times)}: expected ({len(frames)},), one for each frame")
    groups = time_lags(times, longest, bins)
    if not groups:
        raise ValueError(f"bins = {bins}, longest = {longest}: no pair of frames has such a lag")
    return groups


class LagAnalysis(FrameAnalysis):
    """Frames are gathered (all stay in memory), and lags between them averaged at the end, in the groups of `time_lags`."""

    def __init__(self, atomgroup: AtomGroup, longest: float | None = None, bins: ArrayLike | None = None, **kwargs: Any) -> None:
        super().__init__(atomgroup, **kwargs)
        self.longest, self.bins = longest, bins

    def _gathered(self):
        super()._conclude()
        return [self.results.pop(name) for name in self.SERIES]


class MeanSquaredDisplacement(LagAnalysis):
    """Mean squared displacements of the atoms: `MeanSquaredDisplacement(u.atoms).run()`.

    `results.lag`, `results.total`, `results.parallel`, `results.perpendicular` (m,), as `mean_squared_displacement` of the unwrapped
    positions in float64 about the `body_axes`. MDAnalysis' `EinsteinMSD` gives the total in float32, after `analysis.unwrap`.
    """

    SERIES = ("positions", "axes")

    def _frame(self):
        return self.atomgroup.unwrapped_positions, self.axes

    def _conclude(self):
        positions, axes = self._gathered()
        results = mean_squared_displacement(positions, axes, self.times, self.longest, self.bins)
        self.results.lag, self.results.total, self.results.parallel, self.results.perpendicular = results


class OrientationalCorrelation(LagAnalysis):
    """Orientational correlation functions of the atoms: `OrientationalCorrelation(u.atoms).run()`.

    `results.lag`, `results.c1`, `results.c2` (m,), as `orientational_correlation` of the `body_axes`.
    """

    SERIES = ("axes",)

    def _frame(self):
        return (self.axes,)

    def _conclude(self):
        axes, = self._gathered()
        results = orientational_correlation(axes, self.times, self.longest, self.bins)
        self.results.lag, self.results.c1, self.results.c2 = results
