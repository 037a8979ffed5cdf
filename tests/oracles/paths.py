"""Oracle: when two ellipsoids on given paths overlap, by looking at the touching scale at many times. Slow and plain, K pairs at once.

A path has `pick(index)` and `at(time)`, as Flights of dense.py; here are those of the rational motions: the coefficients are evaluated,
nothing is multiplied out. Every extreme of the touching scale mu near 1 is refined by golden section, every crossing of 1 is bisected.
"""

from dataclasses import dataclass

import numpy as np
from dense import GOLDEN, touching_scale
from scipy.spatial.transform import Rotation


def powers(coefficients, time):
    """Polynomials (K, ..., n + 1), lowest power first, each at its own time (K,)."""
    total = np.zeros(coefficients.shape[:-1])
    time = time.reshape(-1, *[1] * (total.ndim - 1))
    for k in range(coefficients.shape[-1] - 1, -1, -1):
        total = total * time + coefficients[..., k]
    return total


class Path:
    def __len__(self):
        return len(self.semi_axes)

    def pick(self, index):
        return type(self)(*(getattr(self, name)[index] for name in self.__dataclass_fields__))


@dataclass
class Rigid(Path):
    """K bodies under rational Euclidean motions: semi_axes (K, 3), rotation (K, 4, .), translation (K, 3, .), denominator (K, .)."""

    semi_axes: np.ndarray
    rotation: np.ndarray
    translation: np.ndarray
    denominator: np.ndarray

    def at(self, time):
        turned = Rotation.from_quat(np.roll(powers(self.rotation, time), -1, axis=1)).as_matrix()
        return powers(self.translation, time) / powers(self.denominator, time)[:, None], turned * self.semi_axes[:, None, :]


@dataclass
class Affine(Path):
    """K bodies under rational affine motions: linear (K, 3, 3, .), translation (K, 3, .), denominator (K, .)."""

    semi_axes: np.ndarray
    linear: np.ndarray
    translation: np.ndarray
    denominator: np.ndarray

    def at(self, time):
        under = powers(self.denominator, time)[:, None]
        return powers(self.translation, time) / under, powers(self.linear, time) / under[:, None] * self.semi_axes[:, None, :]


@dataclass
class Interpolated(Path):
    """K bodies whose X^-1 (K, 2, 3, 3) and centre (K, 2, 3) go linearly from t = 0 to 1."""

    semi_axes: np.ndarray
    inverses: np.ndarray
    centers: np.ndarray

    def at(self, time):
        t = time[:, None]
        x = np.linalg.inv((1 - t[..., None]) * self.inverses[:, 0] + t[..., None] * self.inverses[:, 1])
        return (1 - t) * self.centers[:, 0] + t * self.centers[:, 1], np.linalg.cholesky(x)


@dataclass
class Answer:
    """Of one pair: the times at which the state changes, whether the bodies overlap at the start, and how far from 1 mu stays where it
    has an extreme or the span an end: what is near 0 there is a tangential contact."""

    changes: np.ndarray
    overlap_at_start: bool
    clearance: float


def _extreme(a, b, low, high, sign):
    """Time (N,) and value (N,) of the minimum (sign 1) or maximum (sign -1) of mu between low and high (N,), by golden section."""
    left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_left, at_right = sign * touching_scale(a, b, left), sign * touching_scale(a, b, right)
    for _ in range(40):
        first = at_left < at_right
        low, high = np.where(first, low, left), np.where(first, right, high)
        new = np.where(first, high - GOLDEN * (high - low), low + GOLDEN * (high - low))
        at_new = sign * touching_scale(a, b, new)
        left, right, at_left, at_right = (np.where(first, new, right), np.where(first, left, new),
                                          np.where(first, at_new, at_right), np.where(first, at_left, at_new))
    return np.where(at_left < at_right, left, right), sign * np.minimum(at_left, at_right)


def overlaps(a, b, span=(0.0, 1.0), samples=100):
    """-> list of Answer, one a pair."""
    n, times = len(a), np.linspace(*span, samples)
    rows = np.repeat(np.arange(n), samples)
    mu = touching_scale(a.pick(rows), b.pick(rows), np.tile(times, n)).reshape(n, samples)
    ahead, behind = np.hstack([mu[:, 1:], mu[:, -1:]]), np.hstack([mu[:, :1], mu[:, :-1]])
    reach = 3 * np.maximum(abs(ahead - mu), abs(behind - mu)) + 1e-6            # how far an extreme may go beyond its sample
    sign = np.where(mu >= 1, 1.0, -1.0)
    turns = (sign * mu <= sign * ahead) & (sign * mu <= sign * behind) & (abs(mu - 1) < reach)
    pair, k = np.nonzero(turns)
    when, value = _extreme(a.pick(pair), b.pick(pair), times[np.maximum(k - 1, 0)], times[np.minimum(k + 1, samples - 1)], sign[pair, k])
    everything = np.concatenate([rows, pair]), np.concatenate([np.tile(times, n), when]), np.concatenate([mu.ravel(), value])
    order = np.lexsort(everything[1::-1])
    rows, when, value_at = (each[order] for each in everything)
    change = np.flatnonzero((rows[1:] == rows[:-1]) & ((value_at[1:] < 1) != (value_at[:-1] < 1)))
    low, high, over = when[change], when[change + 1], value_at[change] < 1
    its_a, its_b = a.pick(rows[change]), b.pick(rows[change])
    for _ in range(52):
        middle = 0.5 * (low + high)
        same = (touching_scale(its_a, its_b, middle) < 1) == over
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    clearance = np.minimum(abs(mu[:, 0] - 1), abs(mu[:, -1] - 1))
    np.minimum.at(clearance, pair, abs(value - 1))
    changes, owner = 0.5 * (low + high), rows[change]
    return [Answer(changes[owner == j], bool(mu[j, 0] < 1), clearance[j]) for j in range(n)]


def speed(a, b, time, step=1e-6):
    """|d mu / dt| of the pairs, each at its own time (K,): small where a contact is nearly tangential."""
    return abs(touching_scale(a, b, time + step) - touching_scale(a, b, time - step)) / (2 * step)
