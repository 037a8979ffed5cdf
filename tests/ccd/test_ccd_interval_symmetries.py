"""What must not matter to the intervals does not: who is first, where one stands, how time and length are counted."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.polynomial import Polynomial
from rational_pairs import affine, pair, rigid
from scipy.spatial.transform import Rotation

import ccd
from ccd import AffineMotion, Ellipsoid, RationalMotion

modest = settings(derandomize=True, deadline=None, max_examples=60)
SEEDS = st.integers(0, 10**6)
SHAPES = st.sampled_from(["any", "needle", "plate", "sphere", "equal"])


def rigid_pair(seed, shape):
    rng = np.random.default_rng(seed)
    degrees = rng.choice([2, 4], 2)
    return pair(rigid(rng, 1, degrees[0], int(rng.integers(1, 4)), int(rng.integers(0, 3)), shape),
                rigid(rng, 1, degrees[1], int(rng.integers(1, 4)), 0, shape), 0)


def affine_pair(seed, shape):
    rng = np.random.default_rng(seed)
    return pair(affine(rng, 1, 1, 1, 1, shape), affine(rng, 1, 2, 2, 0, shape), 0)


def intervals(bodies, span=(0.0, 1.0)):
    """Clear of grazes, where rounding decides."""
    found = ccd.contact_intervals(*bodies, t_span=span)
    assume(all(i.end - i.start > 1e-5 for i in found))
    return found


def same(found, expected, image=lambda time: time, backwards=False, points=None, error=1e-9):
    expected = expected[::-1] if backwards else expected
    assert [i.state for i in found] == [i.state for i in expected]
    for mine, theirs in zip(found, expected):
        start, end = (theirs.end, theirs.start) if backwards else (theirs.start, theirs.end)
        assert mine.start == pytest.approx(image(start), abs=error)
        assert mine.end == pytest.approx(image(end), abs=error)
        if points:
            np.testing.assert_allclose(mine.end_point, points(theirs.start_point if backwards else theirs.end_point), rtol=1e-5, atol=1e-5)


def composed(motion, low, width):
    """The motion in a time s with t = low + width s."""
    def each(name):
        value = getattr(motion, name)
        flat = value.reshape(-1, value.shape[-1])
        rows = [Polynomial(row)(Polynomial([low, width])).coef for row in flat]
        rows = [np.pad(row, (0, value.shape[-1] - len(row))) for row in rows]
        return np.array(rows).reshape(value.shape)
    first = "rotation" if isinstance(motion, RationalMotion) else "linear"
    return type(motion)(each(first), each("translation"), each("denominator"))


def carried(motion, turn, shift):
    """The rigid motion seen from elsewhere."""
    w, x, y, z = np.roll(turn.as_quat(), 1)
    left = np.array([[w, -x, -y, -z], [x, w, -z, y], [y, z, w, -x], [z, -y, x, w]])
    return RationalMotion(left @ motion.rotation, *moved(motion, turn.as_matrix(), shift))


def moved(motion, linear, shift):
    size = max(motion.translation.shape[1], len(motion.denominator))
    translation = np.pad(linear @ motion.translation, ((0, 0), (0, size - motion.translation.shape[1])))
    translation[:, :len(motion.denominator)] += shift[:, None] * motion.denominator
    return translation, motion.denominator


@modest
@given(SEEDS, SHAPES, st.sampled_from([rigid_pair, affine_pair]))
def test_it_does_not_matter_which_body_is_first(seed, shape, make):
    a, motion_a, b, motion_b = make(seed, shape)
    same(intervals((b, motion_b, a, motion_a)), intervals((a, motion_a, b, motion_b)), points=lambda p: p)
    one, other = ccd.first_contact(a, motion_a, b, motion_b), ccd.first_contact(b, motion_b, a, motion_a)
    assert one.status == other.status
    np.testing.assert_allclose(one.normal, -other.normal, rtol=0, atol=1e-5)


@modest
@given(SEEDS, SHAPES)
def test_where_one_stands_does_not_matter(seed, shape):
    a, motion_a, b, motion_b = rigid_pair(seed, shape)
    turn, shift = Rotation.random(random_state=seed), np.random.default_rng(seed).normal(size=3) * 5
    same(intervals((a, carried(motion_a, turn, shift), b, carried(motion_b, turn, shift))), intervals((a, motion_a, b, motion_b)),
         points=lambda p: turn.apply(p) + shift)


@modest
@given(SEEDS, SHAPES)
def test_an_affine_map_of_both_does_not_matter(seed, shape):
    a, motion_a, b, motion_b = affine_pair(seed, shape)
    rng = np.random.default_rng(seed)
    linear = Rotation.random(random_state=seed).as_matrix() * rng.uniform(0.4, 2.5, 3) + 0.2 * rng.normal(size=(3, 3))
    shift = rng.normal(size=3)
    images = [AffineMotion(np.einsum("ij,jkn->ikn", linear, m.linear), *moved(m, linear, shift)) for m in (motion_a, motion_b)]
    same(intervals((a, images[0], b, images[1])), intervals((a, motion_a, b, motion_b)), points=lambda p: linear @ p + shift)


@modest
@given(SEEDS, SHAPES, st.sampled_from([rigid_pair, affine_pair]))
def test_time_backwards(seed, shape, make):
    a, motion_a, b, motion_b = make(seed, shape)
    same(intervals((a, composed(motion_a, 1, -1), b, composed(motion_b, 1, -1))), intervals((a, motion_a, b, motion_b)),
         image=lambda t: 1 - t, backwards=True, points=lambda p: p)


@modest
@given(SEEDS, SHAPES, st.floats(-3, 3), st.floats(-1.5, 1.5))
def test_another_clock(seed, shape, low, exponent):
    a, motion_a, b, motion_b = rigid_pair(seed, shape)
    width = 10.0**exponent
    span = (-low / width, (1 - low) / width)
    same(intervals((a, composed(motion_a, low, width), b, composed(motion_b, low, width)), span), intervals((a, motion_a, b, motion_b)),
         image=lambda t: (t - low) / width, error=1e-8 / width)


@modest
@given(SEEDS, SHAPES, st.floats(-8, 8))
def test_the_unit_of_length_does_not_matter(seed, shape, exponent):
    a, motion_a, b, motion_b = rigid_pair(seed, shape)
    size = 10.0**exponent
    larger = [RationalMotion(m.rotation, size * m.translation, m.denominator) for m in (motion_a, motion_b)]
    same(intervals((Ellipsoid(a.semi_axes * size), larger[0], Ellipsoid(b.semi_axes * size), larger[1])),
         intervals((a, motion_a, b, motion_b)), points=lambda p: p * size)


@modest
@given(SEEDS, SHAPES, st.floats(0.1, 0.9))
def test_a_span_cut_in_two_has_the_same_intervals(seed, shape, cut):
    bodies = rigid_pair(seed, shape)
    whole = intervals(bodies)
    assume(all(abs(i.end - cut) > 1e-5 for i in whole))
    left, right = intervals(bodies, (0.0, cut)), intervals(bodies, (cut, 1.0))
    assert left[-1].state == right[0].state
    joined = left[:-1] + [left[-1]._replace(end=right[0].end, end_point=right[0].end_point)] + right[1:]
    same(joined, whole)


@modest
@given(SEEDS, st.sampled_from([1e-100, 1e-7, -3.0, 1e100]), st.sampled_from([1e-100, -1e3, 1e100]))
def test_the_length_of_the_quaternion_and_of_the_denominator_do_not_matter(seed, quaternion, denominator):
    a, motion_a, b, motion_b = rigid_pair(seed, "any")
    other = RationalMotion(quaternion * motion_a.rotation, denominator * motion_a.translation, denominator * motion_a.denominator)
    same(intervals((a, other, b, motion_b)), intervals((a, motion_a, b, motion_b)))
    np.testing.assert_allclose(other.matrix(0.3), motion_a.matrix(0.3), rtol=1e-13, atol=1e-13)
