"""Quaternions and turning at a constant rate, against scipy."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ccd import quaternions, rotation


def random_quaternions(seed, n):
    q = np.random.default_rng(seed).normal(size=(n, 4))
    return q / np.linalg.norm(q, axis=1)[:, None]


def scipy(q):
    return Rotation.from_quat(np.roll(q, -1, axis=-1))


def same_rotation(found, expected, precision):
    found, expected = np.asarray(found), np.roll(expected.as_quat(), 1, axis=-1)
    sign = np.sign((found * expected).sum(axis=-1, keepdims=True))
    np.testing.assert_allclose(found, sign * expected, rtol=0, atol=precision)


def test_matrices_turn_body_into_lab():
    q = random_quaternions(1, 50)
    np.testing.assert_allclose(quaternions.rotation_matrices(q), scipy(q).as_matrix(), rtol=0, atol=1e-15)
    quarter = np.sqrt([[0.5, 0, 0, 0.5]])                  # about z: the body's x axis lies along y in the lab
    np.testing.assert_allclose(quaternions.rotation_matrices(quarter)[0, :, 0], (0, 1, 0), rtol=0, atol=1e-15)


def test_vectors_of_the_body_in_the_lab():
    q, v = random_quaternions(2, 50), np.random.default_rng(3).normal(size=(50, 3))
    np.testing.assert_allclose(quaternions.to_lab(q, v), scipy(q).apply(v), rtol=0, atol=1e-14)


def test_products_are_rotations_one_after_the_other():
    p, q = random_quaternions(4, 50), random_quaternions(5, 50)
    same_rotation(quaternions.products(p, q), scipy(p) * scipy(q), 1e-15)
    for k in range(5):
        same_rotation(rotation.multiply(tuple(p[k]), tuple(q[k])), scipy(p[k]) * scipy(q[k]), 1e-15)


@pytest.mark.parametrize("size", [0.0, 1e-300, 1e-9, 0.1, 3.0, 40.0])
def test_rotations_about_vectors(size):
    v = size * np.random.default_rng(6).normal(size=(30, 3))
    same_rotation(quaternions.rotations(v), Rotation.from_rotvec(v), 1e-14)


# the half-angle 0.5 is where the series gives way to the library: angles on both sides, and far beyond

@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-3, 0.5, 0.999, 1 - 1e-12, 1 + 1e-12, 1.001, 2.0, 3.2, 6.28, 12.0, 500.0, 1e6, -0.7, -5.0])
def test_turning_at_a_constant_rate(angle):
    for k, q in enumerate(random_quaternions(7, 10)):
        axis = np.random.default_rng(k).normal(size=3)
        axis /= np.linalg.norm(axis)
        time = 0.37
        for turned in (rotation.turn(tuple(q.tolist()), tuple((angle / time * axis).tolist()), time),
                       rotation.turn_about(tuple(q.tolist()), tuple(axis.tolist()), angle)):
            same_rotation(turned, Rotation.from_rotvec(angle * axis) * scipy(q), 2e-15 + 2e-16 * abs(angle))


def test_turning_keeps_a_quaternion_unit_over_many_steps():
    q = (1.0, 0.0, 0.0, 0.0)
    for _ in range(20_000):
        q = rotation.turn(q, (0.1, -0.2, 0.3), 0.7)
    assert sum(c * c for c in q) == pytest.approx(1, abs=4e-16)
    same_rotation(q, Rotation.from_rotvec(np.array([0.1, -0.2, 0.3]) * 0.7 * 20_000), 1e-11)


def test_body_axes_are_the_columns_of_the_matrix():
    for q in random_quaternions(8, 10):
        np.testing.assert_allclose(np.transpose(rotation.body_axes(tuple(q.tolist()))), scipy(q).as_matrix(), rtol=0, atol=1e-15)
