"""Motions as matrices: Appendix B of the paper, interpolants between poses, and free flight made rational."""

from math import factorial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rational_pairs import affine, crossing, denominators, poses, rigid, single, turning
from scipy.spatial.transform import Rotation

import ccd
from ccd import AffineMotion, Ellipsoid, FreeFlight, RationalMotion

modest = settings(derandomize=True, deadline=None, max_examples=80)
SEEDS, TIMES = st.integers(0, 10**6), st.floats(-2, 3)


def appendix_b(e):
    e0, e1, e2, e3 = e
    return np.array([[e0**2 + e1**2 - e2**2 - e3**2, 2 * e1 * e2 - 2 * e0 * e3, 2 * e0 * e2 + 2 * e1 * e3],
                     [2 * e0 * e3 + 2 * e1 * e2, e0**2 - e1**2 + e2**2 - e3**2, 2 * e2 * e3 - 2 * e0 * e1],
                     [-2 * e0 * e2 + 2 * e1 * e3, 2 * e0 * e1 + 2 * e2 * e3, e0**2 - e1**2 - e2**2 + e3**2]]) / (e**2).sum()


def value(coefficients, t):
    return np.asarray(coefficients) @ t ** np.arange(np.shape(coefficients)[-1])


@modest
@given(SEEDS, TIMES)
def test_a_rational_motion_is_that_of_appendix_b_and_rigid(seed, t):
    rng = np.random.default_rng(seed)
    motion = RationalMotion(turning(rng, 1, 4)[0], crossing(rng, 1, 3)[0], denominators(rng, 1, 2)[0])
    matrix = motion.matrix(t)
    np.testing.assert_allclose(matrix[:3, :3], appendix_b(value(motion.rotation, t)), rtol=0, atol=1e-12)
    np.testing.assert_allclose(matrix[:3, 3], value(motion.translation, t) / value(motion.denominator, t), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(matrix[:3, :3] @ matrix[:3, :3].T, np.eye(3), rtol=0, atol=1e-13)
    assert np.linalg.det(matrix[:3, :3]) == pytest.approx(1, abs=1e-13)
    assert matrix[3].tolist() == [0, 0, 0, 1]


@modest
@given(SEEDS, TIMES)
def test_an_affine_motion_is_its_coefficients(seed, t):
    motion = single(affine(np.random.default_rng(seed), 1, 2, 3, 1), 0)[1]
    under = value(motion.denominator, t)
    np.testing.assert_allclose(motion.matrix(t)[:3, :3] * under, value(motion.linear, t), rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(motion.matrix(t)[:3, 3] * under, value(motion.translation, t), rtol=1e-10, atol=1e-10)
    assert motion.matrix(t)[3].tolist() == [0, 0, 0, 1]


def test_highest_powers_that_are_zero_do_not_count():
    rng = np.random.default_rng(0)
    body, motion = single(rigid(rng, 1, 2, 2, 1), 0)
    padded = RationalMotion(*(np.pad(x, [(0, 0)] * (x.ndim - 1) + [(0, 3)])
                              for x in (motion.rotation, motion.translation, motion.denominator)))
    assert padded.degree == motion.degree == 2
    degrees = [ccd.CCDEquation(body, each, body, ccd.Rest()).minimal_degree_t for each in (padded, motion)]
    assert degrees[0] == degrees[1]
    _, changing = single(affine(rng, 1, 2, 1), 0)
    assert AffineMotion(np.pad(changing.linear, ((0, 0), (0, 0), (0, 4))), changing.translation).degree == 2


def test_coefficients_cannot_be_changed_afterwards():
    given_one = np.array([[1.0, 0], [0, 1], [0, 0], [0, 0]])
    motion = RationalMotion(given_one, np.zeros((3, 1)))
    given_one[0, 0] = 7
    assert motion.rotation[0, 0] == 1
    with pytest.raises(ValueError, match="read-only"):
        motion.rotation[0, 0] = 2


def ellipsoid(rng, axes=(1.0, 0.4, 2.0)):
    center, turn = poses(rng, 1, 3)
    return Ellipsoid(axes, center[0], np.roll(turn.as_quat()[0], 1) * rng.choice([-1, 1]))


@modest
@given(SEEDS)
def test_the_rigid_interpolant_hits_both_poses_by_the_shorter_way(seed):
    rng = np.random.default_rng(seed)
    start, end = ellipsoid(rng), ellipsoid(rng)
    motion = ccd.interpolate_rigid(start, end)
    for t, pose in ((0, start), (1, end)):
        np.testing.assert_allclose(motion.matrix(t)[:3, :3], pose.rotation_matrix, rtol=0, atol=1e-14)
        np.testing.assert_allclose(motion.matrix(t)[:3, 3], pose.center, rtol=0, atol=1e-14)
    np.testing.assert_allclose(motion.matrix(0.25)[:3, 3], 0.75 * start.center + 0.25 * end.center, rtol=0, atol=1e-14)
    turns = [Rotation.from_matrix(motion.matrix(t)[:3, :3]) for t in np.linspace(0, 1, 21)]
    way = sum((b * a.inv()).magnitude() for a, b in zip(turns, turns[1:]))          # noqa: RUF007
    assert way == pytest.approx((turns[-1] * turns[0].inv()).magnitude(), abs=1e-9)


@modest
@given(SEEDS)
def test_the_affine_interpolant_hits_both_relative_poses(seed):
    """X^-1 and the centre are linear in between, as seen from A."""
    rng = np.random.default_rng(seed)
    a_start, a_end, b_start, b_end = ellipsoid(rng), ellipsoid(rng), ellipsoid(rng, (0.5, 1.5, 0.8)), ellipsoid(rng, (0.5, 1.5, 0.8))
    motion = ccd.interpolate_affine(a_start, a_end, b_start, b_end)

    def seen(t):
        s = motion.matrix(t)[:3, :3] * b_start.semi_axes
        return np.linalg.inv(s @ s.T), motion.matrix(t)[:3, 3]
    for t, a, b in ((0, a_start, b_start), (1, a_end, b_end)):
        into = a.rotation_matrix.T
        inverse, center = seen(t)
        np.testing.assert_allclose(inverse, np.linalg.inv(into @ b.shape_matrix @ into.T), rtol=0, atol=1e-12)
        np.testing.assert_allclose(center, into @ (b.center - a.center), rtol=0, atol=1e-13)
    for k in (0, 1):
        np.testing.assert_allclose(seen(0.375)[k], 0.625 * seen(0)[k] + 0.375 * seen(1)[k], rtol=0, atol=1e-11)


def angle_between(motion, body, spin, t):
    true = Rotation.from_rotvec(spin * t) * Rotation.from_quat(np.roll(body.orientation, -1))
    return (Rotation.from_matrix(motion.matrix(t)[:3, :3]) * true.inv()).magnitude()


@pytest.mark.parametrize("degree", [1, 2, 3, 4])
@pytest.mark.parametrize("angle", [0.1, 0.3, 0.6, 1.0])
def test_the_angle_of_an_approximated_flight_errs_by_the_law_of_pade(degree, angle):
    """theta^(2 k + 1) k!^2 / ((2 k)! (2 k + 1)!) at an angle theta since the middle of the span, and less inside."""
    rng = np.random.default_rng(degree)
    law = angle ** (2 * degree + 1) * factorial(degree) ** 2 / (factorial(2 * degree) * factorial(2 * degree + 1))
    for span in ((0.0, 1.0), (-3.0, 1.0), (7.0, 7.5)):
        body, spin = ellipsoid(rng), rng.normal(size=3)
        spin *= angle / (0.5 * (span[1] - span[0])) / np.linalg.norm(spin)
        motion = ccd.approximate_flight(body, FreeFlight((1, 2, 3), spin), span, degree)
        for t in span:
            assert angle_between(motion, body, spin, t) == pytest.approx(law, rel=0.35, abs=3e-14)
        assert angle_between(motion, body, spin, 0.5 * sum(span)) < 1e-14 * (1 + abs(sum(span)) * np.linalg.norm(spin))
        for t in np.linspace(*span, 7):
            assert angle_between(motion, body, spin, t) < 1.35 * law + 3e-14
            np.testing.assert_allclose(motion.matrix(t)[:3, 3], body.center + np.array([1, 2, 3]) * t, rtol=0, atol=1e-13)
        assert motion.rotation.shape == (4, degree + 1)


def test_a_flight_without_rotation_is_exact_and_of_degree_1():
    body = ellipsoid(np.random.default_rng(1))
    motion = ccd.approximate_flight(body, FreeFlight((1, -2, 3)), (0, 5), degree=4)
    assert motion.degree == 1
    for t in (0, 1.7, 5):
        np.testing.assert_allclose(motion.matrix(t)[:3, :3], body.rotation_matrix, rtol=0, atol=1e-15)
        np.testing.assert_allclose(motion.matrix(t)[:3, 3], body.center + np.array([1, -2, 3]) * t, rtol=0, atol=1e-14)


@pytest.mark.parametrize("growth", [0.5, -0.3])
def test_a_body_that_grows_is_an_affine_motion(growth):
    rng = np.random.default_rng(2)
    body, spin = ellipsoid(rng), np.array([0.2, -0.4, 0.3])
    motion = ccd.approximate_flight(body, FreeFlight((1, 0, -1), spin, growth), (0, 2), degree=4)
    assert isinstance(motion, AffineMotion)
    for t in (0, 0.7, 2):
        true = Rotation.from_rotvec(spin * t).as_matrix() @ body.rotation_matrix * (1 + growth * t)
        np.testing.assert_allclose(motion.matrix(t)[:3, :3], true, rtol=0, atol=1e-9)
        np.testing.assert_allclose(motion.matrix(t)[:3, 3], body.center + np.array([1, 0, -1]) * t, rtol=0, atol=1e-12)


def test_growing_bodies_touch_when_the_certified_shoot_says():
    rng = np.random.default_rng(3)
    contacts = 0
    for _ in range(60):
        a, b = ellipsoid(rng), ellipsoid(rng, (0.6, 0.8, 0.3))
        apart = 4 * b.center / np.linalg.norm(b.center)
        b = Ellipsoid(b.semi_axes, a.center + apart, b.orientation)
        flights = [FreeFlight(v, 0.4 * rng.normal(size=3), rng.uniform(-0.3, 0.5)) for v in (rng.normal(size=3), -apart)]
        true = ccd.first_contact(a, flights[0], b, flights[1])
        found = ccd.first_contact(a, ccd.approximate_flight(a, flights[0], degree=4), b, ccd.approximate_flight(b, flights[1], degree=4))
        assert found.status == true.status
        assert found.time == pytest.approx(true.time, abs=1e-8)
        contacts += np.isfinite(true.time)
    assert contacts > 20
