"""Section 2 of the paper: the characteristic polynomial, Theorem 1 (state) and Theorem 2 (contact point), for rigid and affine poses.

Truth: determinants and Sturm sequences to 50 digits (oracles/roots.py), and the contact function of oracles/dense.py for many pairs.
"""

from math import cos, pi, sin, sqrt

import numpy as np
import pytest
import roots
from dense import contact_function_and_normal
from pairs import directions
from scipy.spatial.transform import Rotation

import ccd
from ccd import AffineEllipsoid, Bodies, Ellipsoid, State
from ccd.characteristic import UNCERTAIN, magnitudes, margin, polynomial, state_by_roots
from ccd.overlap import _pose
from ccd.quaternions import rotation_matrices
from ccd.separation import contact_function
from ccd.tolerances import EXACT, ROUNDING

TILTED, OTHER = (0.9, -0.2, 0.3, 0.25), (0.1, 0.7, -0.4, 0.6)
EXCESSES = np.array([1e-1, 1e-3, 1e-5, 1e-7, 1e-9, 1e-11])
N = 2000


def in_fifty_digits(a, b):
    def placed(body):
        if isinstance(body, Ellipsoid):
            return body.semi_axes, roots.rigid_map(body.orientation, body.center)
        return body.semi_axes, roots.affine_map(body.linear, body.translation)
    return roots.characteristic_polynomial(*placed(a), *placed(b))


def random_affine(rng, center=(0, 0, 0)):
    """Sheared and stretched, half of them mirrored; by no more than some factors of 10."""
    return AffineEllipsoid(rng.uniform(0.5, 2, 3), rng.choice([-1, 1]) * np.eye(3) + 0.4 * rng.normal(size=(3, 3)),
                           np.add(center, rng.normal(size=3)))


# Appendix A

@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("poses", ["rigid", "affine", "mixed"])
def test_the_coefficients_are_those_of_the_determinant(poses, seed):
    rng = np.random.default_rng(seed)
    rigid = [Ellipsoid(rng.uniform(0.5, 2, 3), rng.normal(size=3), rng.normal(size=4)) for _ in range(2)]
    affine = [random_affine(rng) for _ in range(2)]
    a, b = {"rigid": rigid, "affine": affine, "mixed": (rigid[0], affine[1])}[poses]
    found, expected = ccd.characteristic_polynomial(a, b), np.array(in_fifty_digits(a, b), dtype=float)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * abs(expected).max())
    np.testing.assert_allclose(found[[0, -1]], expected[[0, -1]], rtol=1e-13)


def test_for_rigid_poses_it_is_the_determinant_of_the_quadrics():
    a, b = Ellipsoid((1, 2, 0.5), (0.3, 0, 1), TILTED), Ellipsoid((0.7, 1.5, 1), (1, 2, -0.5), OTHER)
    for value in (-2.0, -0.3, 0.5, 3.0):
        expected = np.linalg.det(value * a.quadric - b.quadric)
        assert np.polyval(ccd.characteristic_polynomial(a, b), value) == pytest.approx(expected, rel=1e-12)


def test_example_1_of_the_paper_at_its_contact():
    """The errata give f = -(l - 4) (2 l + 1)^2 (9 l - 16) / 9216 and the contact point (sqrt 2, 0, sqrt 2)."""
    a, b = Ellipsoid((2, 4, 2)), Ellipsoid((1, 3, 4), (3 * sqrt(2), 0, 3 * sqrt(2)), (cos(pi / 8), 0, sin(pi / 8), 0))
    expected = -np.polymul(np.polymul([1, -4], [4, 4, 1]), [9, -16]) / 9216
    np.testing.assert_allclose(ccd.characteristic_polynomial(a, b), expected, rtol=1e-14)
    assert ccd.state(a, b) == State.TOUCHING
    np.testing.assert_allclose(ccd.contact_point(a, b), [sqrt(2), 0, sqrt(2)], rtol=0, atol=1e-14)
    np.testing.assert_allclose(ccd.contact_point(b, a), [sqrt(2), 0, sqrt(2)], rtol=0, atol=1e-14)


# Theorem 1: many pairs

def lengths(rng, low, high):
    return np.exp(rng.uniform(np.log(low), np.log(high), (N, 3)))


def turned(rng):
    return rng.normal(size=(N, 4))


def pose_pairs(rng, axes_a, axes_b, orientation_a=None, orientation_b=None):
    """N pairs some way apart: half of them separate."""
    a = Bodies(np.broadcast_to(axes_a, (N, 3)), rng.normal(size=(N, 3)), turned(rng) if orientation_a is None else orientation_a)
    far = (a.semi_axes.max(axis=1) + np.max(np.broadcast_to(axes_b, (N, 3)), axis=1))[:, None]
    b = Bodies(np.broadcast_to(axes_b, (N, 3)), a.center + far * rng.uniform(0.1, 1, (N, 1)) * directions(rng, N),
               turned(rng) if orientation_b is None else orientation_b)
    return a, b


def parallel(rng, same):
    orientation, axes = turned(rng), lengths(rng, 0.3, 3)
    return pose_pairs(rng, axes, axes if same else lengths(rng, 0.3, 3), orientation, orientation)


def resized(pair, length):
    return [Bodies(body.semi_axes * length, body.center * length, body.orientation) for body in pair]


def placed(pair, distance):
    """The same bodies, the second at `distance` (of the sum of the longest semi-axes) from the first in some direction."""
    a, b = pair
    far = (a.semi_axes.max(axis=1) + b.semi_axes.max(axis=1))[:, None] * distance
    return a, Bodies(b.semi_axes, a.center + far * directions(np.random.default_rng(9), N), b.orientation)


def random_pairs(rng, low=0.3, high=3.0):
    return pose_pairs(rng, lengths(rng, low, high), lengths(rng, low, high))


KINDS = {
    "random": random_pairs,
    "needles": lambda rng: pose_pairs(rng, (0.01, 0.01, 1), (0.01, 0.01, 1)),
    "plates": lambda rng: pose_pairs(rng, (1, 1, 0.01), (1, 1, 0.01)),
    "needle and plate": lambda rng: pose_pairs(rng, (0.01, 0.01, 1), (1, 1, 0.01)),
    "spheroids": lambda rng: pose_pairs(rng, (1, 1, 2), (1, 1, 2)),
    "spheres": lambda rng: pose_pairs(rng, lengths(rng, 0.3, 3)[:, :1] * np.ones(3), lengths(rng, 0.3, 3)[:, :1] * np.ones(3)),
    "equal and parallel": lambda rng: parallel(rng, same=True),
    "aligned": lambda rng: parallel(rng, same=False),
    "sphere and ellipsoid": lambda rng: pose_pairs(rng, (1, 1, 1), lengths(rng, 0.3, 3)),
    "very different sizes": lambda rng: pose_pairs(rng, lengths(rng, 0.5, 2) * 1e-4, lengths(rng, 0.5, 2) * 1e2),
    "tiny": lambda rng: resized(random_pairs(rng), 1e-6),
    "huge": lambda rng: resized(random_pairs(rng), 1e6),
    "far apart": lambda rng: placed(random_pairs(rng), 1e6),
    "one inside the other": lambda rng: placed(pose_pairs(rng, lengths(rng, 2, 3), lengths(rng, 0.1, 0.5)), 0.2),
    "nearly concentric": lambda rng: placed(random_pairs(rng), 1e-9),
    "concentric": lambda rng: placed(random_pairs(rng), 0.0),
}


def vectors_of(bodies):
    return rotation_matrices(bodies.orientation) * bodies.semi_axes[:, None, :]


def dense_contact_function(a, b):
    return contact_function_and_normal(b.center - a.center, vectors_of(a), vectors_of(b))[0]


def to_excess(a, b, excess):
    """The first body at the origin, the second moved along the line of centres until f - 1 is `excess`, to about 1e-14."""
    r = b.center - a.center
    f = ccd.batch.contact_function(a, b)
    return (Bodies(a.semi_axes, np.zeros_like(r), a.orientation),
            Bodies(b.semi_axes, r * np.sqrt((1 + excess) / f)[:, None], b.orientation))


@pytest.mark.parametrize("kind", KINDS)
def test_the_state_is_the_sign_of_the_contact_function_less_one(kind):
    a, b = KINDS[kind](np.random.default_rng(1))
    f = dense_contact_function(a, b)
    clear = abs(f - 1) > 1e-6
    assert clear.mean() > 0.99
    np.testing.assert_array_equal(ccd.batch.state(a, b)[clear], np.sign(f - 1)[clear])


@pytest.mark.parametrize("kind", [kind for kind in KINDS if "concentric" not in kind])
def test_the_state_is_told_right_down_to_nearly_touching(kind):
    """On both sides of the contact, from 1e-1 to 1e-11. What the dense oracle cannot tell is left to the fifty digits below."""
    rng = np.random.default_rng(2)
    excess = rng.choice(np.concatenate([EXCESSES, -EXCESSES]), N)
    a, b = to_excess(*KINDS[kind](rng), excess)
    f = dense_contact_function(a, b)
    told = abs(f - 1) > 1e-9
    assert told.mean() > 0.7
    states = ccd.batch.state(a, b)
    np.testing.assert_array_equal(states[told], np.sign(f - 1)[told])
    np.testing.assert_array_equal(states, np.sign(excess))


def test_concentric_pairs_have_contact_function_zero_in_a_batch_too():
    a, b = KINDS["concentric"](np.random.default_rng(1))
    assert not ccd.batch.contact_function(a, b).any()
    mixed = Bodies(b.semi_axes, np.where(np.arange(N)[:, None] % 2, b.center, b.center + 50.0), b.orientation)
    np.testing.assert_array_equal(ccd.batch.contact_function(a, mixed) > 1, np.arange(N) % 2 == 0)


def one(a, b, k):
    return tuple(Ellipsoid(body.semi_axes[k], body.center[k], body.orientation[k]) for body in (a, b))


@pytest.mark.parametrize("kind", [kind for kind in KINDS if "concentric" not in kind])
def test_the_state_agrees_with_sturm_in_fifty_digits(kind):
    rng = np.random.default_rng(3)
    excess = np.resize(np.concatenate([-EXCESSES, EXCESSES]), N)
    a, b = to_excess(*KINDS[kind](rng), excess)
    for k in range(len(EXCESSES) * 2):
        pair = one(a, b, k)
        negative = roots.distinct_negative_roots(in_fifty_digits(*pair))
        assert ccd.state(*pair) == {2: State.SEPARATE, 0: State.OVERLAPPING}[negative], excess[k]


@pytest.mark.parametrize("kind", ["random", "needles", "plates", "spheres", "equal and parallel", "aligned"])
def test_the_two_ways_to_the_state_never_differ(kind):
    """Within and about the band where pairs are called touching; a batch of any length gives what single calls give."""
    rng = np.random.default_rng(4)
    excess = 10.0 ** rng.uniform(-14, -10, N) * rng.choice([-1, 1], N)
    excess[::10] = 0
    a, b = to_excess(*KINDS[kind](rng), excess)
    states = ccd.batch.state(a, b)
    assert set(states) == {-1, 0, 1}
    for k in range(150):
        pair = one(a, b, k)
        assert ccd.state(*pair) == ccd.separation(*pair).state == states[k]
    for n in (0, 1, 127, 128, 129, 300):
        part = [Bodies(body.semi_axes[:n], body.center[:n], body.orientation[:n]) for body in (a, b)] if n else [
            Bodies(np.empty((0, 3)), np.empty((0, 3)), np.empty((0, 4)))] * 2
        np.testing.assert_array_equal(ccd.batch.state(*part), states[:n])


@pytest.mark.parametrize("kind", ["random", "plates", "very different sizes"])
def test_block_and_single_pair_take_the_same_steps(kind):
    """To the last bit: else the edge of the band of touching pairs would not be the same for both."""
    a, b = to_excess(*KINDS[kind](np.random.default_rng(11)), 0.0)
    f = ccd.batch.contact_function(a, b)
    for k in range(100):
        g, t, _ = _pose(*one(a, b, k))
        assert contact_function(g, t, EXACT)[0] == f[k]


def answer_of_the_roots(a, b):
    g, t, det = _pose(a, b)
    return state_by_roots(polynomial(g, t, det), magnitudes(g, t), margin(b.semi_axes.max() / b.semi_axes.min()))


def test_the_roots_say_when_they_cannot_tell():
    """Touching pairs, in the band that only the contact function may call, and pairs whose Sturm remainders vanish."""
    rng = np.random.default_rng(5)
    for kind in ("random", "needles", "spheroids"):
        a, b = to_excess(*KINDS[kind](rng), 1e-12 * rng.uniform(-1, 1, N))
        assert {answer_of_the_roots(*one(a, b, k)) for k in range(200)} == {UNCERTAIN}
    a, b = to_excess(*KINDS["equal and parallel"](rng), 0.1)
    assert {answer_of_the_roots(*one(a, b, k)) for k in range(200)} == {UNCERTAIN}


@pytest.mark.parametrize("kind", ["random", "needles", "plates", "needle and plate", "very different sizes", "far apart"])
def test_the_coefficients_err_by_less_than_the_roots_allow_for(kind):
    a, b = KINDS[kind](np.random.default_rng(10))
    for k in range(12):
        pair = one(a, b, k)
        g, t, det = _pose(*pair)
        scale = float(pair[0].semi_axes.prod()) ** 2
        exact = [float(c * scale) for c in in_fifty_digits(*pair)[1:]]
        bounds = ROUNDING * pair[1].semi_axes.max() / pair[1].semi_axes.min() * np.array([*magnitudes(g, t), det**2])
        assert (abs(np.array(polynomial(g, t, det)) - exact) <= bounds).all()


def test_the_roots_are_certain_of_nearly_all_pairs():
    a, b = random_pairs(np.random.default_rng(6))
    answers = np.array([answer_of_the_roots(*one(a, b, k)) for k in range(N)])
    assert (answers == UNCERTAIN).mean() < 1e-3
    f = dense_contact_function(a, b)
    known = answers != UNCERTAIN
    np.testing.assert_array_equal(answers[known], np.sign(f - 1)[known])


# affine poses

@pytest.mark.parametrize("seed", range(20))
def test_affine_poses_are_judged_like_the_ellipsoids_they_make(seed):
    """The singular value decomposition of the semi-axis vectors gives the principal axes of the same body."""
    rng = np.random.default_rng(seed)
    a, b = random_affine(rng), random_affine(rng, 2.5 * directions(rng, 1)[0])
    made = []
    for body in (a, b):
        axes, lengths, _ = np.linalg.svd(body.semi_axis_vectors)
        quaternion = Rotation.from_matrix(axes * np.sign(np.linalg.det(axes))).as_quat()
        made.append(Ellipsoid(lengths, body.center, np.roll(quaternion, 1)))
    expected = ccd.separation(*made)
    assert ccd.state(a, b) == ccd.state(a, made[1]) == ccd.state(made[0], b) == expected.state
    assert roots.distinct_negative_roots(in_fifty_digits(a, b)) == (2 if expected.state == State.SEPARATE else 0)


# Theorem 2

@pytest.mark.parametrize("kind", ["random", "needles", "plates", "spheres", "equal and parallel", "very different sizes", "tiny", "huge"])
def test_the_contact_point_lies_on_both_surfaces(kind):
    rng = np.random.default_rng(7)
    a, b = to_excess(*KINDS[kind](rng), 0.0)
    for k in range(40):
        pair = one(a, b, k)
        point = ccd.contact_point(*pair)
        size, apart = min(body.semi_axes.max() for body in pair), np.linalg.norm(pair[1].center)
        np.testing.assert_allclose(point, ccd.contact_point(*pair[::-1]), rtol=0, atol=1e-9 * size + 1e-13 * apart)
        np.testing.assert_allclose(point, ccd.separation(*pair).point, rtol=0, atol=1e-7 * size)
        for body in pair:
            depth = np.linalg.norm(np.linalg.solve(body.semi_axis_vectors, point - body.center)) - 1
            assert abs(depth) < 1e-13 * (1 + apart / body.semi_axes.min())


def test_nearly_touching_pairs_have_a_point_and_others_do_not():
    a, b = (bodies for bodies in to_excess(*random_pairs(np.random.default_rng(8)), np.resize([9e-7, -9e-7, 2e-6, -2e-6, 1, -0.5], N)))
    for k in range(60):
        pair = one(a, b, k)
        if k % 6 < 2:
            scale = sqrt(ccd.separation(*pair).contact_function)
            grown = [Ellipsoid(body.semi_axes * scale, body.center, body.orientation) for body in pair]
            np.testing.assert_allclose(ccd.contact_point(*pair), ccd.contact_point(*grown), rtol=0, atol=1e-12)
        else:
            with pytest.raises(ValueError, match=r"do not touch: their contact function is .*1e-06"):
                ccd.contact_point(*pair)


def test_affine_poses_in_batch_are_told_as_one_by_one():
    rng = np.random.default_rng(12)
    singles = [(random_affine(rng), random_affine(rng, 1.2 * rng.normal(size=3))) for _ in range(400)]
    a, b = (ccd.AffineBodies(*(np.array([getattr(pair[k], name) for pair in singles]) for name in ("semi_axes", "linear", "translation")))
            for k in (0, 1))
    expected = [ccd.state(*pair) for pair in singles]
    assert {State.SEPARATE, State.OVERLAPPING} == set(expected)
    np.testing.assert_array_equal(ccd.batch.state(a, b), expected)
    truth, _ = contact_function_and_normal(b.center - a.center, a.semi_axis_vectors, b.semi_axis_vectors)
    np.testing.assert_allclose(ccd.batch.contact_function(a, b), truth, rtol=1e-10)        # some maps are nearly singular
