"""The oracles agree with closed forms, and with each other: they are trusted only because they share nothing."""

import numpy as np
import pytest
import reference
from dense import Flights, contact_function_and_normal, deepest, first_contact, graze
from distance import distance
from exact import separation


def flights(rng, n, distance_from_origin=0.0):
    direction = rng.normal(size=(n, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    return Flights(rng.uniform(0.3, 2, (n, 3)), distance_from_origin * direction, rng.normal(size=(n, 4)), rng.normal(size=(n, 3)),
                   2 * rng.normal(size=(n, 3)), rng.uniform(-0.2, 0.2, n))


def test_three_ways_to_the_contact_function_agree():
    rng = np.random.default_rng(1)
    a, b = flights(rng, 8), flights(rng, 8, 3.0)
    (_, axes_a), (_, axes_b) = a.at(np.zeros(8)), b.at(np.zeros(8))
    f, n = contact_function_and_normal(b.center, axes_a, axes_b)
    for k in range(8):
        f_reference, _, n_reference, _ = reference.pw(axes_a[k] @ axes_a[k].T, axes_b[k] @ axes_b[k].T, b.center[k])
        exact = separation(a.semi_axes[k], a.center[k], a.orientation[k], b.semi_axes[k], b.center[k], b.orientation[k])
        assert f[k] == pytest.approx(f_reference, rel=1e-13)
        assert f[k] == pytest.approx(float(exact.contact_function), rel=1e-13)
        np.testing.assert_allclose(n[k] / np.linalg.norm(n[k]), n_reference, rtol=0, atol=1e-12)
        np.testing.assert_allclose(np.array(exact.normal, dtype=float), n_reference, rtol=0, atol=1e-12)


def test_exact_separation_of_spheres():
    exact = separation([1, 1, 1], [0, 0, 0], [1, 0, 0, 0], [2, 2, 2], [3, 4, 12], [1, 2, 3, 4])
    assert abs(exact.contact_function * 9 - 169) < 1e-45
    assert abs(exact.gap - 10) < 1e-45
    assert abs(exact.pencil_parameter * 3 - 1) < 1e-40


def test_first_contact_of_spheres_is_the_root_of_a_quadratic():
    rng = np.random.default_rng(2)
    a, b = flights(rng, 100), flights(rng, 100, 4.0)
    a.semi_axes[:], b.semi_axes[:] = 1.0, 0.5
    a.growth_rate[:] = b.growth_rate[:] = 0
    b.velocity = a.velocity - 2 * b.center + rng.normal(size=(100, 3))
    time, smallest = first_contact(a, b, 1.0, samples=50)
    for k in range(100):
        roots = np.roots([((b.velocity[k] - a.velocity[k]) ** 2).sum(), 2 * b.center[k] @ (b.velocity[k] - a.velocity[k]), 16 - 1.5**2])
        expected = roots.real.min() if abs(roots[0].imag) < 1e-14 and 0 < roots.real.min() < 1 else np.inf
        assert time[k] == pytest.approx(expected, abs=1e-11)
        assert (smallest[k] < 1) == np.isfinite(expected)


def test_a_constructed_graze_is_as_deep_as_asked():
    rng = np.random.default_rng(3)
    a, b = flights(rng, 20), flights(rng, 20, 4.0)
    b.velocity = a.velocity - 2 * b.center
    b, _ = graze(a, b, 1.0, depth=np.full(20, 1e-6))
    np.testing.assert_allclose(deepest(a, b, 1.0)[1], 1 - 1e-6, rtol=0, atol=1e-12)


def test_distance_of_spheres_and_of_boxed_ellipsoids():
    assert distance(np.eye(3), np.zeros(3), 2 * np.eye(3), np.array([3, 4, 12.0]))[0] == pytest.approx(10, rel=1e-13)
    assert distance(np.diag([1, 2, 0.5]), np.zeros(3), np.diag([3, 1, 0.2]), np.array([6.0, 0, 0]))[0] == pytest.approx(2, rel=1e-9)
