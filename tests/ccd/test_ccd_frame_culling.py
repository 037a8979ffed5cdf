"""The two culling tests of a frame against looking at many times: both are exact, not only safe. Rotations are scipy's."""

import numpy as np
import pytest
from pairs import directions
from scipy.spatial.transform import Rotation
from scipy.stats import binom

import ccd
from ccd.bernstein import without_root_at_start
from ccd.bezier_shoot import best_certificate, slope
from ccd.frame_culling import plane_holds, spheres_meet

TIMES = np.linspace(0, 1, 4001)


def turned(first, last):
    """The rotations (T,) of a linear quaternion curve, which need not be unit."""
    return Rotation.from_quat(np.roll((1 - TIMES)[:, None] * first + TIMES[:, None] * last, -1, axis=1))


def random_turn(rng, angle):
    first = rng.normal(size=4)
    first /= np.linalg.norm(first)
    last = Rotation.from_rotvec(directions(rng, 1)[0] * angle) * Rotation.from_quat(np.roll(first, -1))
    last = np.roll(last.as_quat(), 1)
    return first, last * np.sign(first @ last)


def test_a_carried_plane_holds_exactly_when_it_misses_the_other_body_at_all_times():
    held = [held for seed in range(150) for held in planes(np.random.default_rng(seed))]
    assert 0.2 < np.mean(held) < 0.8


def planes(rng):
    """Whether a random plane holds for the whole frame and for a part of it, each compared with the truth."""
    size_a, size_b = np.exp(rng.uniform(-1, 1, (2, 3)))
    (a_first, a_last), (b_first, b_last) = random_turn(rng, 0.8), random_turn(rng, 0.8)
    m, h = directions(rng, 1)[0], np.linalg.norm(size_b * directions(rng, 1)[0])
    at_a, at_b = turned(a_first, a_last), turned(b_first, b_last)
    normals = at_b.apply(m)
    supports = np.linalg.norm(at_a.inv().apply(normals) * size_a, axis=1)
    start = (supports[0] + h + rng.uniform(0.02, 0.5)) * normals[0] + np.cross(normals[0], rng.normal(size=3))
    end = start + 0.5 * rng.normal(size=3)
    centers = (1 - TIMES)[:, None] * start + TIMES[:, None] * end
    clearance = (normals * centers).sum(axis=1) - h - supports
    a, fault = ccd.RationalMotion(np.stack([a_first, a_last - a_first], axis=1), [[0]] * 3).tensors(tuple(size_a), (0.0, 1.0))
    assert fault is None
    for until in (1.0, rng.uniform(0.1, 0.9)):
        smallest = clearance[until >= TIMES].min()
        if abs(smallest) > 1e-3:
            found = plane_holds((tuple(m), h), (tuple(b_first), tuple(b_last)), (tuple(start), tuple(end)), a, until, np.empty((4, 11)))
            assert found == (smallest > 0)
            yield found


@pytest.mark.parametrize("seed", range(40))
def test_moving_spheres_meet_exactly_when_their_centres_come_within_reach(seed):
    rng = np.random.default_rng(seed)
    start, end, reach, until = 2 * rng.normal(size=3), 2 * rng.normal(size=3), rng.uniform(0.2, 2), rng.uniform(0.2, 1)
    times = np.linspace(0, until, 20001)[:, None]
    distance = np.linalg.norm((1 - times) * start + times * end, axis=1).min()
    if abs(distance - reach) > 1e-6:
        assert spheres_meet(tuple(start), tuple(end), reach, until) == (distance < reach)


# what shoots and tangents are made of

@pytest.mark.parametrize("roots", [[0.0, 0.3, 0.8], [0.0, 0.0, 0.5, 2.0], [0.0, -1.0]])
def test_a_root_at_the_start_is_divided_out(roots):
    power = np.polynomial.polynomial.polyfromroots(roots)
    n = len(power) - 1
    points = np.linalg.solve(bernstein_matrix(n), np.polynomial.polynomial.polyval(np.linspace(0, 1, n + 1), power))
    points[0] += 1e-9                                                   # what stands there is not used
    without_root_at_start(points)
    expected = np.polynomial.polynomial.polyval(np.linspace(0, 1, n), power[1:])
    np.testing.assert_allclose(bernstein_matrix(n - 1) @ points[:n], expected, atol=1e-12)


def bernstein_matrix(n):
    return np.array([binom.pmf(np.arange(n + 1), n, s) for s in np.linspace(0, 1, n + 1)])


@pytest.mark.parametrize("t", [0.0, 0.2, 0.45, 0.55, 0.8, 1.0])
def test_the_slope_has_the_sign_of_the_gap_that_opens_or_closes(t):
    """A sphere that comes and goes along a parabola, nearest at t = 0.6."""
    path = [[2.5 + 0.36, -1.2, 1.0][k] for k in range(3)]
    equation = ccd.CCDEquation(ccd.Ellipsoid((1, 1, 1)), ccd.Rest(), ccd.Ellipsoid((1, 2, 1)), ccd.RationalMotion(
        [[1], [0], [0], [0]], [path, [0, 0, 0], [0, 0, 0]]))
    grid = equation._parts[0].grid
    _, u, _ = best_certificate(grid, t, 0.5)
    assert np.sign(slope(grid, u, t, np.empty((2, grid.shape[1])))) == np.sign(t - 0.6)
