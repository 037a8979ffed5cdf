"""Intervals of separation and overlap of rational motions: those of the paper's Example 1, and those that dense sampling finds."""

from itertools import pairwise

import numpy as np
import pytest
from cross_section import cross_section
from determinants import changes_at, rigid
from paths import overlaps, speed
from rational_pairs import EXAMPLE_1, ROOT2, SHAPES, affine, crossing, interpolated, pair, resting, shifted, turning
from rational_pairs import rigid as random_rigid

import ccd
from ccd import Ellipsoid, RationalMotion, Rest, State

SEPARATE, OVERLAPPING = State.SEPARATE, State.OVERLAPPING


def states(found):
    return [interval.state for interval in found]


def changes(found):
    return np.array([interval.start for interval in found[1:]])


def agree(found, expected, tolerance=1e-9):
    """The intervals are the oracle's: as many, of the same states, at the same times."""
    first = OVERLAPPING if expected.overlap_at_start else SEPARATE
    assert states(found) == [first * (-1) ** k for k in range(len(expected.changes) + 1)]
    np.testing.assert_allclose(changes(found), expected.changes, rtol=0, atol=tolerance)


def end_to_end(found, span=(0.0, 1.0)):
    assert (found[0].start, found[-1].end) == span
    for one, next_one in pairwise(found):
        assert one.end == next_one.start
        assert one.state != next_one.state
        np.testing.assert_array_equal(one.end_point, next_one.start_point)


def residual(axes, point, center):
    """How far a point is from the surface, relative to the body's size; axes: semi-axis vectors as columns."""
    return abs(np.linalg.norm(np.linalg.solve(axes, point - center)) - 1)


def test_example_1_overlaps_once_between_0_and_1():
    found = ccd.contact_intervals(*EXAMPLE_1)
    assert states(found) == [SEPARATE, OVERLAPPING, SEPARATE]
    np.testing.assert_allclose(changes(found), [0.5, 0.9008011319237], rtol=0, atol=1e-12)
    np.testing.assert_allclose(found[1].start_point, [ROOT2, 0, ROOT2], rtol=0, atol=1e-12)
    end_to_end(found)


def test_example_1_overlaps_once_more_between_minus_2_and_3():
    found = ccd.contact_intervals(*EXAMPLE_1, t_span=(-2, 3))
    assert states(found) == [SEPARATE, OVERLAPPING, SEPARATE, OVERLAPPING, SEPARATE]
    np.testing.assert_allclose(changes(found), [-0.2439303679, -0.1859966702, 0.5, 0.9008011319237], rtol=0, atol=1e-10)
    np.testing.assert_allclose(found[3].start_point, [ROOT2, 0, ROOT2], rtol=0, atol=1e-11)
    end_to_end(found, (-2.0, 3.0))


def test_example_1_agrees_with_fifty_digits():
    a, motion_a, b, motion_b = EXAMPLE_1
    paths = [rigid(motion.rotation, motion.translation) for motion in (motion_a, motion_b)]
    for time in changes(ccd.contact_intervals(*EXAMPLE_1, t_span=(-2, 3))):
        assert changes_at(a.semi_axes, paths[0], b.semi_axes, paths[1], time, 1e-12)


KINDS = {
    "both turn": lambda rng, n, shape: (random_rigid(rng, n, 2, 1, shape=shape), random_rigid(rng, n, 2, 3, shape=shape)),
    "degrees 4 and 2, rational paths": lambda rng, n, shape: (random_rigid(rng, n, 4, 3, 2, shape), random_rigid(rng, n, 2, 2, 1, shape)),
    "degree 6": lambda rng, n, shape: (random_rigid(rng, n, 6, 6, 4, shape), random_rigid(rng, n, 2, 1, shape=shape)),
    "one at rest": lambda rng, n, shape: (random_rigid(rng, n, 0, 0, shape=shape), random_rigid(rng, n, 4, 2, shape=shape)),
    "affine": lambda rng, n, shape: (affine(rng, n, 1, 0, shape=shape), affine(rng, n, 2, 3, 1, shape=shape)),
    "affine and rigid": lambda rng, n, shape: (affine(rng, n, 2, 2, shape=shape), random_rigid(rng, n, 2, 2, 2, shape=shape)),
}


@pytest.mark.parametrize(("kind", "shape"), cross_section(KINDS, SHAPES))
def test_random_pairs_have_the_intervals_that_sampling_finds(kind, shape):
    """130 pairs of each kind; 4550 with all shapes and the interpolants: none missed, none invented, none UNRESOLVED."""
    a, b = KINDS[kind](np.random.default_rng(list(map(ord, kind + shape))), 130, shape)
    for k, expected in enumerate(overlaps(a, b)):
        if expected.clearance > 1e-7:
            agree(ccd.contact_intervals(*pair(a, b, k)), expected)


@pytest.mark.parametrize("shape", SHAPES)
def test_affine_interpolants_have_the_intervals_that_sampling_finds(shape):
    a, b, corners = interpolated(np.random.default_rng(len(shape)), 130, shape)
    for k, expected in enumerate(overlaps(a, b)):
        motion = ccd.interpolate_affine(*corners[k])
        agree(ccd.contact_intervals(Ellipsoid(a.semi_axes[k]), Rest(), Ellipsoid(b.semi_axes[k]), motion), expected)


def test_every_kind_of_pair_does_touch_in_these_samples():
    """So that the tests above can fail."""
    touching, twice = 0, 0
    for kind, pairs in KINDS.items():
        for answer in overlaps(*pairs(np.random.default_rng(list(map(ord, kind + "any"))), 130, "any")):
            touching, twice = touching + (len(answer.changes) > 0), twice + (len(answer.changes) > 2)
    assert touching > 300
    assert twice >= 1


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_lengths_of_any_size(scale):
    rng = np.random.default_rng(3)
    a, b = random_rigid(rng, 100, 2, 2), random_rigid(rng, 100, 4, 1, 1)
    for path in (a, b):
        path.semi_axes *= scale
        path.translation *= scale
    for k, expected in enumerate(overlaps(a, b)):
        agree(ccd.contact_intervals(*pair(a, b, k)), expected)


def test_far_from_the_origin():
    """At 1e6 from it positions are good to 1e-10, and so are the times."""
    rng = np.random.default_rng(4)
    a, b = random_rigid(rng, 100, 2, 2), random_rigid(rng, 100, 2, 1)
    near = overlaps(a, b)
    away = np.tile([[1e6, -3e5, 2e5]], (100, 1))
    far_a, far_b = shifted(a, away), shifted(b, away)
    for k, expected in enumerate(near):
        if expected.clearance > 1e-5:
            slowest = min(speed(a.pick([k] * len(expected.changes)), b.pick([k] * len(expected.changes)), expected.changes), default=1)
            agree(ccd.contact_intervals(*pair(far_a, far_b, k)), expected, 3e-9 / slowest)


def test_bodies_that_never_come_near_are_separate():
    rng = np.random.default_rng(5)
    a, b = random_rigid(rng, 50, 2, 2, shape="needle"), random_rigid(rng, 50, 4, 3, 1, shape="plate")
    b = shifted(b, np.tile([[1e6, 0, 0]], (50, 1)))
    for k in range(50):
        assert states(ccd.contact_intervals(*pair(a, b, k))) == [SEPARATE]


@pytest.mark.parametrize("shape", ["any", "equal", "sphere", "plate"])
def test_centres_that_coincide_on_the_way(shape):
    rng = np.random.default_rng(6)
    a, b = random_rigid(rng, 60, 2, 0, shape=shape), random_rigid(rng, 60, 4, 3, shape=shape)
    a.translation[:] = 0
    middle = np.array([[0.5], [0.375]] * 30)                # exactly: the paths pass through 0 there
    b.translation[:] = 0
    velocity = 10 * rng.integers(1, 5, (60, 3))
    b.translation[:, :, 1], b.translation[:, :, 0] = velocity, -velocity * middle
    for k, expected in enumerate(overlaps(a, b, samples=201)):
        assert len(expected.changes) >= 2
        agree(ccd.contact_intervals(*pair(a, b, k)), expected)


def test_a_small_body_that_flies_through_the_inside_of_a_large_one():
    rng = np.random.default_rng(7)
    a, b = random_rigid(rng, 60, 2, 0), random_rigid(rng, 60, 4, 2)
    a.translation[:] *= 0.1
    b.semi_axes *= 0.02
    b.translation *= 0.3
    seen = 0
    for k, expected in enumerate(overlaps(a, b, samples=300)):
        if expected.clearance > 1e-7:
            agree(ccd.contact_intervals(*pair(a, b, k)), expected)
            seen += len(expected.changes) > 1
    assert seen > 20


def test_a_body_that_stays_inside_another_overlaps_all_the_time():
    rng = np.random.default_rng(8)
    a, b = random_rigid(rng, 40, 2, 0), random_rigid(rng, 40, 6, 1)
    a.semi_axes = 3 + a.semi_axes
    a.translation[:] = 0
    b.semi_axes *= 0.3
    b.translation[:] *= 0.1
    for k in range(40):
        assert states(ccd.contact_intervals(*pair(a, b, k))) == [OVERLAPPING]


def test_intervals_meet_and_contact_points_lie_on_both_surfaces():
    rng = np.random.default_rng(9)
    a, b = random_rigid(rng, 150, 2, 2, 2), affine(rng, 150, 2, 2, 1)
    contacts = 0
    for k in range(150):
        found = ccd.contact_intervals(*pair(a, b, k))
        end_to_end(found)
        for interval in found[1:]:
            for path in (a, b):
                center, axes = path.pick([k]).at(np.array([interval.start]))
                assert residual(axes[0], interval.start_point, center[0]) < 1e-9
            contacts += 1
        assert np.isnan(found[0].start_point).all()
        assert np.isnan(found[-1].end_point).all()
    assert contacts > 100


def test_many_intervals_of_a_path_that_comes_back():
    """A unit sphere on T_9 x 3 against another: it passes nine times."""
    wave = np.polynomial.chebyshev.cheb2poly([0] * 9 + [1])
    to_span = sum(c * np.polynomial.Polynomial([-1, 2]) ** k for k, c in enumerate(3 * wave)).coef
    path = np.zeros((3, 10))
    path[0] = to_span
    found = ccd.contact_intervals(Ellipsoid((1, 1, 1)), Rest(), Ellipsoid((1, 1, 1)), RationalMotion([[1], [0], [0], [0]], path))
    inner = np.concatenate([np.cos((np.arccos(s * 2 / 3) + 2 * np.pi * np.arange(9)) / 9) for s in (1, -1)])
    outer = np.concatenate([np.cos((2 * np.pi * np.arange(10) - np.arccos(s * 2 / 3)) / 9) for s in (1, -1)])
    expected = np.unique(np.round(0.5 + 0.5 * np.concatenate([inner, outer]), 11))
    expected = expected[(expected > 0) & (expected < 1)]
    assert len(expected) == 18
    assert states(found) == [SEPARATE, OVERLAPPING] * 9 + [SEPARATE]
    np.testing.assert_allclose(changes(found), expected, rtol=0, atol=1e-10)


def test_a_regular_contact_of_slender_or_very_different_bodies_is_told():
    """The loop test must look at strips of u where the hull of the control points gives nothing away: this was UNRESOLVED."""
    rng = np.random.default_rng(10)
    rotation_a, rotation_b, path = turning(rng, 60, 4), turning(rng, 60, 4), crossing(rng, 60, 2)
    for k in range(60):
        sizes = np.exp(rng.uniform(-4, 1, 6))
        bodies = (Ellipsoid(sizes[:3]), RationalMotion(rotation_a[k], np.zeros((3, 1))), Ellipsoid(sizes[3:]),
                  RationalMotion(rotation_b[k], path[k]))
        assert State.UNRESOLVED not in states(ccd.contact_intervals(*bodies))


@pytest.mark.parametrize("degree", [0, 2, 4, 8, 12])
def test_bodies_at_rest_and_bodies_of_high_degree(degree):
    rng = np.random.default_rng(degree)
    a, b = resting(np.array([[1.0, 0.4, 2.0]] * 20)), random_rigid(rng, 20, degree, min(degree, 4))
    for k, expected in enumerate(overlaps(a, b, samples=300)):
        if expected.clearance > 1e-7:
            agree(ccd.contact_intervals(*pair(a, b, k)), expected)
