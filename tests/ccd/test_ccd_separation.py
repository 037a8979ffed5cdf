"""Two ellipsoids at rest: contact function, state, gap, normal and contact point, against 50 digits and against closed forms."""

from math import cos, sin, sqrt

import numpy as np
import pytest
from cross_section import some_of
from distance import distance
from exact import separation as exact_separation
from pairs import directions, semi_axis_vectors

import ccd
from ccd import Ellipsoid, State

TILTED, OTHER = (0.9, -0.2, 0.3, 0.25), (0.1, 0.7, -0.4, 0.6)


def exact(a, b):
    return exact_separation(a.semi_axes, a.center, a.orientation, b.semi_axes, b.center, b.orientation)


def random_pair(rng, distance, low=0.2, high=3.0):
    axes = np.exp(rng.uniform(np.log(low), np.log(high), (2, 3)))
    center = rng.normal(size=3)
    return (Ellipsoid(axes[0], center, rng.normal(size=4)),
            Ellipsoid(axes[1], center + distance * directions(rng, 1)[0], rng.normal(size=4)))


def scaled_to_touching(a, b):
    """The same pair with both bodies grown or shrunk by the factor sqrt(f), about their own centres."""
    factor = sqrt(ccd.separation(a, b).contact_function)
    return Ellipsoid(a.semi_axes * factor, a.center, a.orientation), Ellipsoid(b.semi_axes * factor, b.center, b.orientation)


NASTY = {
    "needles crossed": (Ellipsoid((0.01, 0.01, 1)), Ellipsoid((1, 0.01, 0.01), (0.3, 0.025, 0.1))),
    "needles tip to tip": (Ellipsoid((0.01, 0.01, 1), (0, 0, 0), TILTED), Ellipsoid((0.01, 0.01, 1), (0.9, 1.1, 1.6), TILTED)),
    "needles nearly parallel": (Ellipsoid((0.01, 0.01, 1)), Ellipsoid((0.01, 0.01, 1), (0.021, 0, 0.3), (1, 1e-4, -2e-4, 0.3))),
    "plates face to face": (Ellipsoid((1, 1, 0.01)), Ellipsoid((1, 1, 0.01), (0.2, 0.1, 0.021), (1, 1e-3, 1e-3, 0))),
    "plates edge on face": (Ellipsoid((1, 1, 0.01)), Ellipsoid((1, 0.01, 1), (0.3, 0.2, 1.05), OTHER)),
    "tiny and huge": (Ellipsoid((1e-3, 2e-3, 3e-3), (0, 0, 0), TILTED), Ellipsoid((1e3, 2e3, 5e2), (4e2, -1e3, 1e3), OTHER)),
    "both tiny": (Ellipsoid((1e-6, 2e-6, 3e-6), (0, 0, 0), TILTED), Ellipsoid((2e-6, 1e-6, 1e-6), (4e-6, 1e-6, 0), OTHER)),
    "both huge": (Ellipsoid((1e6, 2e6, 3e6), (0, 0, 0), TILTED), Ellipsoid((2e6, 1e6, 1e6), (4e6, 1e6, 0), OTHER)),
    "far apart": (Ellipsoid((1, 2, 3), (0, 0, 0), TILTED), Ellipsoid((0.5, 0.1, 2), (6e5, -8e5, 1e5), OTHER)),
    "needle and a sphere": (Ellipsoid((0.01, 0.01, 1), (0, 0, 0), TILTED), Ellipsoid((5, 5, 5), (3, 4, 3))),
    "equal and parallel": (Ellipsoid((1, 2, 3), (0, 0, 0), TILTED), Ellipsoid((1, 2, 3), (2, 1, 0.5), TILTED)),
    "one inside the other": (Ellipsoid((3, 4, 5), (0, 0, 0), TILTED), Ellipsoid((0.1, 0.2, 0.3), (0.4, 0.1, -0.2), OTHER)),
    "nearly concentric": (Ellipsoid((1, 2, 3), (0, 0, 0), TILTED), Ellipsoid((3, 1, 0.5), (1e-9, 2e-9, 0), OTHER)),
}


@pytest.mark.parametrize("name", NASTY)
def test_nasty_pairs_agree_with_fifty_digits(name):
    a, b = NASTY[name]
    found, expected = ccd.separation(a, b), exact(a, b)
    # what float64 can give: the shape matrices carry the squares of the semi-axes
    aspect = max(body.semi_axes.max() / body.semi_axes.min() for body in (a, b))
    precision = 1e-15 * aspect**2 + 2e-14
    assert found.contact_function == pytest.approx(float(expected.contact_function), rel=precision)
    assert found.state == (State.SEPARATE if expected.contact_function > 1 else State.OVERLAPPING)
    size = np.linalg.norm(b.center - a.center) + a.semi_axes.max() + b.semi_axes.max()
    assert found.gap == pytest.approx(float(expected.gap), rel=0, abs=size * precision)
    np.testing.assert_allclose(found.normal, np.array(expected.normal, dtype=float), rtol=0, atol=10 * precision)
    assert found.pencil_parameter == pytest.approx(float(expected.pencil_parameter), rel=1e-8)


@pytest.mark.parametrize("seed", range(8))
def test_random_pairs_agree_with_fifty_digits(seed):
    a, b = random_pair(np.random.default_rng(seed), 2.5)
    found, expected = ccd.separation(a, b), exact(a, b)
    assert found.contact_function == pytest.approx(float(expected.contact_function), rel=2e-14)
    assert found.gap == pytest.approx(float(expected.gap), rel=0, abs=2e-13)
    np.testing.assert_allclose(found.normal, np.array(expected.normal, dtype=float), rtol=0, atol=1e-12)


@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize("ratio", [1e1, 1e3, 1e5, 1e6, 1e8, 1e12, 1e20])
def test_bodies_of_very_different_sizes(ratio, swapped):
    """The maximiser lies within 1 / ratio of an end of (0, 1): it must be found there, not merely approached."""
    a = Ellipsoid((1, 2, 3), (0, 0, 0), TILTED)
    b = Ellipsoid(np.array([1, 2, 0.5]) * ratio, np.array([0.4, -1, 1]) * ratio, OTHER)
    if swapped:
        a, b = b, a
    found, expected = ccd.separation(a, b), exact(a, b)
    assert found.contact_function == pytest.approx(float(expected.contact_function), rel=1e-12)
    np.testing.assert_allclose(found.normal, np.array(expected.normal, dtype=float), rtol=0, atol=1e-12)
    assert found.gap == pytest.approx(float(expected.gap), rel=1e-12)


@pytest.mark.parametrize("excess", [1e-2, 1e-6, 1e-10, -1e-10, -1e-6, -1e-2])
@pytest.mark.parametrize("seed", range(4))
def test_the_state_is_told_right_down_to_nearly_touching(seed, excess):
    a, b = scaled_to_touching(*random_pair(np.random.default_rng(seed), 3.0))
    b = Ellipsoid(b.semi_axes, a.center + (b.center - a.center) * sqrt(1 + excess), b.orientation)
    found = ccd.separation(a, b)
    assert found.contact_function - 1 == pytest.approx(excess, rel=1e-4)
    assert found.state == (State.SEPARATE if excess > 0 else State.OVERLAPPING)
    assert np.sign(found.gap) == np.sign(excess)


@pytest.mark.parametrize("seed", range(6))
def test_touching_pairs_are_called_touching(seed):
    found = ccd.separation(*scaled_to_touching(*random_pair(np.random.default_rng(seed), 3.0)))
    assert found.state == State.TOUCHING
    assert abs(found.gap) < 1e-13


@pytest.mark.parametrize("orientation", [(1, 0, 0, 0), TILTED])
@pytest.mark.parametrize(("radius_a", "radius_b"), [(1, 1), (2, 0.5), (1e-3, 10)])
def test_spheres_in_closed_form(radius_a, radius_b, orientation):
    a, b = Ellipsoid([radius_a] * 3, (1, 2, 3), orientation), Ellipsoid([radius_b] * 3, (1 + 9, 2 + 12, 3 + 20), OTHER)
    found = ccd.separation(a, b)
    unit = np.array([9, 12, 20]) / 25
    assert found.contact_function == pytest.approx((25 / (radius_a + radius_b)) ** 2, rel=1e-14)
    assert found.gap == pytest.approx(25 - radius_a - radius_b, rel=1e-14)
    assert found.pencil_parameter == pytest.approx(radius_a / (radius_a + radius_b), rel=1e-9)
    np.testing.assert_allclose(found.normal, unit, rtol=0, atol=1e-15)
    np.testing.assert_allclose(found.point, a.center + 0.5 * (radius_a + 25 - radius_b) * unit, rtol=1e-14)


@pytest.mark.parametrize("seed", range(4))
def test_parallel_congruent_ellipsoids_are_stretched_unit_spheres(seed):
    rng = np.random.default_rng(seed)
    axes, orientation, r = rng.uniform(0.2, 3, 3), rng.normal(size=4), rng.normal(size=3) * 4
    a, b = Ellipsoid(axes, (0, 0, 0), orientation), Ellipsoid(axes * 1.5, r, orientation)
    stretched = (a.rotation_matrix.T @ r) / axes
    assert ccd.separation(a, b).contact_function == pytest.approx(stretched @ stretched / 2.5**2, rel=1e-14)


def test_concentric_ellipsoids_overlap_and_have_no_normal():
    found = ccd.separation(Ellipsoid((1, 2, 3), (1, 1, 1)), Ellipsoid((3, 1, 2), (1, 1, 1), TILTED))
    assert found.state == State.OVERLAPPING
    assert (found.contact_function, found.gap) == (0, -np.inf)
    assert np.isnan(found.normal).all()
    assert np.isnan(found.point).all()


@pytest.mark.parametrize("seed", range(12))
def test_where_they_touch_both_surfaces_have_the_normal(seed):
    a, b = scaled_to_touching(*random_pair(np.random.default_rng(seed), 3.0))
    found = ccd.separation(a, b)
    outward = []
    for body in (a, b):
        x, matrix = found.point - body.center, np.linalg.inv(body.shape_matrix)
        assert x @ matrix @ x == pytest.approx(1, abs=1e-10)
        outward.append(matrix @ x / np.linalg.norm(matrix @ x))
    np.testing.assert_allclose(outward[0], found.normal, rtol=0, atol=1e-9)
    np.testing.assert_allclose(outward[1], -found.normal, rtol=0, atol=1e-9)


@pytest.mark.parametrize("seed", some_of(range(12), range(5)))
def test_the_gap_is_a_certificate_below_the_distance(seed):
    a, b = random_pair(np.random.default_rng(seed), 3.0 + 0.5 * (seed % 4))
    found = ccd.separation(a, b)
    if found.state != State.SEPARATE:
        assert found.gap < 0
        return
    upper, on_a, on_b = distance(semi_axis_vectors(a), a.center, semi_axis_vectors(b), b.center)
    assert 0 < found.gap <= upper * (1 + 1e-13)
    # the two planes that bound the bodies: none of many points of a surface is beyond its own
    points = directions(np.random.default_rng(0), 4000)
    beyond_a = (points @ semi_axis_vectors(a).T + a.center) @ found.normal
    beyond_b = (points @ semi_axis_vectors(b).T + b.center) @ found.normal
    assert beyond_b.min() - beyond_a.max() >= found.gap - 1e-13
    assert (on_b - on_a) @ found.normal > 0


def test_the_gap_becomes_the_distance_as_they_come_to_touch():
    a, b = scaled_to_touching(*random_pair(np.random.default_rng(4), 3.0))
    normal = ccd.separation(a, b).normal
    for apart in (1e-2, 1e-3):
        moved = Ellipsoid(b.semi_axes, b.center + apart * normal, b.orientation)
        gap = ccd.separation(a, moved).gap
        assert apart - 3 * apart**2 < gap <= distance(semi_axis_vectors(a), a.center, semi_axis_vectors(moved), moved.center)[0]


def test_a_batch_gives_the_contact_functions_of_its_pairs():
    rng = np.random.default_rng(5)
    pairs = [random_pair(rng, 2.5) for _ in range(50)]
    a, b = (ccd.Bodies(*(np.array([getattr(pair[side], name) for pair in pairs]) for name in ("semi_axes", "center", "orientation")))
            for side in (0, 1))
    np.testing.assert_array_max_ulp(ccd.batch.contact_function(a, b), np.array([ccd.separation(*p).contact_function for p in pairs]), 16)


# the solid itself

def test_an_ellipsoid_knows_its_volume_inertia_and_surface():
    body = Ellipsoid((1, 2, 3), (0.5, -1, 2), (cos(0.3), 0, 0, sin(0.3)))
    assert body.volume == pytest.approx(8 * np.pi, rel=1e-15)
    np.testing.assert_allclose(body.inertia(5), [13, 10, 5], rtol=1e-15)
    rotation = np.array([[cos(0.6), -sin(0.6), 0], [sin(0.6), cos(0.6), 0], [0, 0, 1]])
    np.testing.assert_allclose(body.rotation_matrix, rotation, rtol=0, atol=1e-15)
    np.testing.assert_allclose(body.shape_matrix, rotation @ np.diag([1, 4, 9]) @ rotation.T, rtol=0, atol=1e-14)
    surface = directions(np.random.default_rng(1), 100) @ (rotation * [1, 2, 3]).T + body.center
    points = np.column_stack([surface, np.ones(100)])
    np.testing.assert_allclose(np.einsum("ni,ij,nj->n", points, body.quadric, points), 0, rtol=0, atol=1e-13)
    assert np.append(body.center, 1) @ body.quadric @ np.append(body.center, 1) == pytest.approx(-1, rel=1e-14)
    np.testing.assert_array_equal(body.quadric, body.quadric.T)


def test_inertia_is_the_second_moment_of_the_solid():
    rng = np.random.default_rng(2)
    axes = np.array([0.5, 1.2, 2.0])
    inside = directions(rng, 200_000) * rng.random((200_000, 1)) ** (1 / 3) * axes
    squares = (inside**2).mean(axis=0)
    np.testing.assert_allclose(Ellipsoid(axes).inertia(2.0), 2.0 * (squares.sum() - squares), rtol=5e-3)


def test_an_ellipsoid_cannot_be_changed_behind_its_back():
    axes = np.array([1.0, 2.0, 3.0])
    body = Ellipsoid(axes)
    axes[0] = 7
    assert body.semi_axes.tolist() == [1, 2, 3]
    with pytest.raises(ValueError, match="read-only"):
        body.semi_axes[0] = 7
    with pytest.raises(AttributeError):
        body.center = (0, 0, 1)
