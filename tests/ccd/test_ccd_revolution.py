"""Bodies of revolution by their axis alone, against what turns and measures their semi-axis vectors."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from ccd.first_contact import support_course
from ccd.revolution import course_of_axis, facing_of_axis, shape_of_axis, turning_axis
from ccd.separation import shape_matrix
from ccd.turning_plane import facing


def drawn(seed):
    """A turned body of revolution, flat or long: semi-axis vectors, axis, squares of the semi-axes across and along; spin; a direction."""
    rng = np.random.default_rng(seed)
    across, along = np.exp(rng.uniform(-2.5, 2.5, 2))
    turn = Rotation.random(random_state=seed)
    vectors = tuple(tuple(v) for v in (turn.as_matrix() * [across, across, along]).T)
    n = rng.normal(size=3)
    return vectors, tuple(turn.apply([0, 0, 1.0])), (across**2, along**2), tuple(rng.normal(size=3)), tuple(n / np.linalg.norm(n))


@settings(derandomize=True, max_examples=200, deadline=None)
@given(st.integers(0, 10**6))
def test_supports_are_those_of_the_semi_axis_vectors(seed):
    vectors, u, squares, spin, n = drawn(seed)
    square = float(np.dot(spin, spin))
    axis = turning_axis(u, spin, square, 0.0)
    found = course_of_axis(axis, (*squares, square), 3.0, 2.0, n)
    expected = support_course(vectors, (spin, (0.0, 0.0, 0.0), 0.0, 3.0, 0.0, 2.0), n)
    scale = max(squares) / min(squares)**0.5 * np.array([1e-15, 1e-14, 1e-13, 1e-13, 1e-13, 1e-15]) * max(square, 1)**1.5
    assert (abs(np.subtract(found, expected)) <= 40 * scale).all()
    np.testing.assert_allclose(shape_of_axis(u, *squares), shape_matrix(vectors), atol=1e-14 * max(squares))
    flight = (1.3, spin, 0.2)
    for this, that in zip(facing_of_axis(u, *squares, flight, n), facing(vectors, flight, n)):
        np.testing.assert_allclose(this, that, rtol=1e-11, atol=1e-12 * max(squares)**1.5 / min(squares) * max(square, 1))


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.3, 0.99, 1.01, 3.0, 40.0])
def test_an_axis_that_turns(angle):
    """With its derivatives, against a rotation of all three."""
    _, u, _, spin, _ = drawn(1)
    square, time = float(np.dot(spin, spin)), angle / np.linalg.norm(spin)
    turn = Rotation.from_rotvec(np.multiply(spin, time))
    first = np.cross(spin, u)
    for found, start in zip(turning_axis(u, spin, square, time), (u, first, np.cross(spin, first))):
        np.testing.assert_allclose(found, turn.apply(start), atol=1e-14 * max(1, angle))
