"""Symmetries of the contact of two ellipsoids: what must not matter does not. Poses and motions are hypothesis's, rotations scipy's."""

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import ccd
from ccd import Ellipsoid, FreeFlight, State, Status

modest = settings(derandomize=True, deadline=None, max_examples=60,
                  suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much])


def vectors(low, high):
    return st.tuples(*[st.floats(low, high)] * 3).map(np.array)


LENGTHS = st.floats(-1.2, 1.2).map(lambda x: 10.0**x)
QUATERNIONS = st.tuples(*[st.floats(-1, 1)] * 4).map(np.array).filter(lambda q: np.linalg.norm(q) > 0.1)
ELLIPSOIDS = st.builds(Ellipsoid, st.tuples(LENGTHS, LENGTHS, LENGTHS), vectors(-6, 6), QUATERNIONS)
MOTIONS = st.builds(FreeFlight, vectors(-8, 8), vectors(-4, 4), st.floats(-0.3, 0.3))


def rotation_of(body):
    return Rotation.from_quat(np.roll(body.orientation, -1))


def quaternion(rotation):
    return np.roll(rotation.as_quat(), 1)


def carried(body, rotation, shift):
    return Ellipsoid(body.semi_axes, rotation.as_matrix() @ body.center + shift, quaternion(rotation * rotation_of(body)))


def pose_at(body, motion, time):
    turned = Rotation.from_rotvec(motion.angular_velocity * time) * rotation_of(body)
    return Ellipsoid(body.semi_axes * (1 + motion.growth_rate * time), body.center + motion.velocity * time, quaternion(turned))


def same_separation(found, expected, rotation=None, length=1.0):
    size = abs(expected.gap) + length
    assert found.contact_function == pytest.approx(expected.contact_function, rel=1e-10, abs=1e-12)
    assert found.gap == pytest.approx(expected.gap, rel=1e-9, abs=1e-8 * size)
    normal = expected.normal if rotation is None else rotation.apply(expected.normal)
    np.testing.assert_allclose(found.normal, normal, rtol=0, atol=1e-7)


def clear(contact):
    """Neither at the very start or end, nor a graze, where rounding may decide."""
    return contact.status == Status.NO_CONTACT or 1e-9 < contact.time < 1 - 1e-9


def same_contact(found, expected, scale=1.0):
    if found.status == expected.status == Status.CONTACT:
        assert found.time == pytest.approx(expected.time * scale, rel=1e-8, abs=1e-8 * scale)
    return found.status == expected.status


@modest
@given(ELLIPSOIDS, ELLIPSOIDS)
def test_it_does_not_matter_who_is_called_first(a, b):
    assume(np.linalg.norm(a.center - b.center) > 1e-3)
    ab, ba = ccd.separation(a, b), ccd.separation(b, a)
    assert ba.contact_function == pytest.approx(ab.contact_function, rel=1e-11)
    assert ba.gap == pytest.approx(ab.gap, rel=1e-9, abs=1e-9)
    assert ba.pencil_parameter == pytest.approx(1 - ab.pencil_parameter, abs=1e-8)
    np.testing.assert_allclose(ba.normal, -ab.normal, rtol=0, atol=1e-7)
    np.testing.assert_allclose(ba.point, ab.point, rtol=0, atol=1e-6)


def clearly(a, b):
    """The state of a pair whose rounding, in the pose or in its image, cannot matter."""
    found = ccd.separation(a, b)
    assume(abs(found.contact_function - 1) > 1e-9)
    return found.state


@modest
@given(ELLIPSOIDS, ELLIPSOIDS)
def test_the_polynomial_read_backwards_is_that_of_the_pair_swapped(a, b):
    assert ccd.state(a, b) == ccd.state(b, a) == clearly(a, b)
    ab, ba = ccd.characteristic_polynomial(a, b), ccd.characteristic_polynomial(b, a)
    exact = [np.linalg.det(value * b.quadric - a.quadric) for value in (-1.0, 1.0)]
    assume(min(abs(value) for value in exact) > 1e-6 * abs(ab).max())
    np.testing.assert_allclose(ba[[0, -1]], ab[[-1, 0]], rtol=1e-11)
    np.testing.assert_allclose([np.polyval(ba, value) for value in (-1.0, 1.0)], [np.polyval(ab, value) for value in (-1.0, 1.0)],
                               rtol=0, atol=1e-7 * abs(ab).max())


@modest
@given(ELLIPSOIDS, ELLIPSOIDS, QUATERNIONS, vectors(-10, 10), st.sampled_from([1e-6, 1.0, 1e6]))
def test_the_state_looks_alike_from_anywhere_and_in_any_unit(a, b, q, shift, unit):
    expected = clearly(a, b)
    seen = [carried(body, Rotation.from_quat(q), shift) for body in (a, b)]
    assert ccd.state(*(Ellipsoid(body.semi_axes * unit, body.center * unit, body.orientation) for body in seen)) == expected


@modest
@given(ELLIPSOIDS, ELLIPSOIDS, st.tuples(*[vectors(-2, 2)] * 3).map(np.array), vectors(-10, 10))
def test_a_common_affine_map_changes_no_state(a, b, linear, shift):
    assume(np.linalg.cond(linear) < 1e3)
    images = [ccd.AffineEllipsoid(body.semi_axes, linear @ body.rotation_matrix, linear @ body.center + shift) for body in (a, b)]
    assert ccd.state(*images) == clearly(a, b)


@modest
@given(ELLIPSOIDS, ELLIPSOIDS, st.tuples(*[vectors(-2, 2)] * 3).map(np.array), vectors(-10, 10))
def test_the_contact_point_goes_where_an_affine_map_takes_it(a, b, linear, shift):
    assume(np.linalg.norm(a.center - b.center) > 1e-3 and np.linalg.cond(linear) < 1e2)
    size = np.sqrt(ccd.separation(a, b).contact_function)
    a, b = (Ellipsoid(body.semi_axes * size, body.center, body.orientation) for body in (a, b))
    images = [ccd.AffineEllipsoid(body.semi_axes, linear @ body.rotation_matrix, linear @ body.center + shift) for body in (a, b)]
    np.testing.assert_allclose(ccd.contact_point(*images), linear @ ccd.contact_point(a, b) + shift, rtol=0, atol=1e-6)


@modest
@given(ELLIPSOIDS, MOTIONS, ELLIPSOIDS, MOTIONS)
def test_it_does_not_matter_who_is_called_first_in_flight(a, motion_a, b, motion_b):
    ab, ba = ccd.first_contact(a, motion_a, b, motion_b), ccd.first_contact(b, motion_b, a, motion_a)
    assert same_contact(ba, ab)
    if ab.status == Status.CONTACT:
        np.testing.assert_allclose(ba.normal, -ab.normal, rtol=0, atol=1e-6)
        np.testing.assert_allclose(ba.point, ab.point, rtol=0, atol=1e-6)


@modest
@given(ELLIPSOIDS, ELLIPSOIDS, QUATERNIONS, vectors(-10, 10))
def test_a_common_rigid_motion_carries_the_answer_along(a, b, q, shift):
    assume(np.linalg.norm(a.center - b.center) > 1e-3)
    rotation, before = Rotation.from_quat(q), ccd.separation(a, b)
    after = ccd.separation(carried(a, rotation, shift), carried(b, rotation, shift))
    same_separation(after, before, rotation)
    np.testing.assert_allclose(after.point, rotation.apply(before.point) + shift, rtol=0, atol=1e-6)


@modest
@given(ELLIPSOIDS, MOTIONS, ELLIPSOIDS, MOTIONS, QUATERNIONS, vectors(-10, 10), vectors(-10, 10))
def test_flights_look_alike_from_any_inertial_frame(a, motion_a, b, motion_b, q, shift, boost):
    rotation, before = Rotation.from_quat(q), ccd.first_contact(a, motion_a, b, motion_b)
    matrix = rotation.as_matrix()

    def seen(motion):
        return FreeFlight(matrix @ motion.velocity + boost, matrix @ motion.angular_velocity, motion.growth_rate)

    after = ccd.first_contact(carried(a, rotation, shift), seen(motion_a), carried(b, rotation, shift), seen(motion_b))
    assert same_contact(after, before)
    if before.status == Status.CONTACT:
        np.testing.assert_allclose(after.normal, rotation.apply(before.normal), rtol=0, atol=1e-6)


@modest
@given(ELLIPSOIDS, ELLIPSOIDS, st.sampled_from([1e-6, 1e-3, 1e3, 1e6]))
def test_the_unit_of_length_does_not_matter(a, b, unit):
    assume(np.linalg.norm(a.center - b.center) > 1e-3)
    before = ccd.separation(a, b)
    after = ccd.separation(*(Ellipsoid(body.semi_axes * unit, body.center * unit, body.orientation) for body in (a, b)))
    assert after.state == before.state
    assert after.contact_function == pytest.approx(before.contact_function, rel=1e-11)
    assert after.gap == pytest.approx(before.gap * unit, rel=1e-9, abs=1e-9 * unit)
    np.testing.assert_allclose(after.normal, before.normal, rtol=0, atol=1e-7)


@modest
@given(ELLIPSOIDS, MOTIONS, ELLIPSOIDS, MOTIONS, st.sampled_from([1e-6, 1e6]), st.sampled_from([1e-6, 1.0, 1e6]))
def test_the_units_of_length_and_time_do_not_matter(a, motion_a, b, motion_b, length, time):
    before = ccd.first_contact(a, motion_a, b, motion_b)
    (a, motion_a), (b, motion_b) = ((Ellipsoid(body.semi_axes * length, body.center * length, body.orientation),
                                     FreeFlight(motion.velocity * length / time, motion.angular_velocity / time,
                                                motion.growth_rate / time)) for body, motion in ((a, motion_a), (b, motion_b)))
    assert same_contact(ccd.first_contact(a, motion_a, b, motion_b, (0, time)), before, time)


@modest
@given(ELLIPSOIDS, MOTIONS, ELLIPSOIDS, MOTIONS)
def test_a_flight_without_contact_has_none_backwards(a, motion_a, b, motion_b):
    """The way back from t = 1, from poses that scipy turned; also by a window before t = 0."""
    forth = ccd.first_contact(a, motion_a, b, motion_b)
    assume(forth.status == Status.NO_CONTACT)

    def back(body, motion):
        return (pose_at(body, motion, 1.0),
                FreeFlight(-motion.velocity, -motion.angular_velocity, -motion.growth_rate / (1 + motion.growth_rate)))

    assert ccd.first_contact(*back(a, motion_a), *back(b, motion_b)).status == Status.NO_CONTACT
    mirrored = [FreeFlight(-m.velocity, -m.angular_velocity, -m.growth_rate) for m in (motion_a, motion_b)]
    assert ccd.first_contact(a, mirrored[0], b, mirrored[1], (-1, 0)).status == Status.NO_CONTACT


@modest
@given(ELLIPSOIDS, MOTIONS, ELLIPSOIDS, MOTIONS, st.floats(0.1, 0.9))
def test_a_window_cut_in_two_holds_the_same_first_contact(a, motion_a, b, motion_b, cut):
    whole = ccd.first_contact(a, motion_a, b, motion_b)
    assume(clear(whole) and abs(whole.time - cut) > 1e-9)
    first = ccd.first_contact(a, motion_a, b, motion_b, (0, cut))
    if whole.time < cut:
        assert same_contact(first, whole)
    else:
        assert first.status == Status.NO_CONTACT
        assert same_contact(ccd.first_contact(a, motion_a, b, motion_b, (cut, 1)), whole)


@modest
@given(ELLIPSOIDS, MOTIONS, ELLIPSOIDS, MOTIONS)
def test_the_state_changes_at_the_contact_and_not_before(a, motion_a, b, motion_b):
    found = ccd.first_contact(a, motion_a, b, motion_b)
    assume(found.status != Status.OVERLAPPING)
    last = min(found.time, 1.0)
    for time in np.linspace(0, last, 12)[:-1]:
        if last - time > 1e-9:
            assert ccd.separation(pose_at(a, motion_a, time), pose_at(b, motion_b, time)).state == State.SEPARATE
    if found.status == Status.CONTACT:
        touching = ccd.separation(pose_at(a, motion_a, found.time), pose_at(b, motion_b, found.time))
        assert touching.contact_function == pytest.approx(1, abs=1e-9)


@modest
@given(ELLIPSOIDS, ELLIPSOIDS, st.sampled_from([-1.0, 2.0, 1e-5, -1e5]))
def test_sign_and_length_of_a_quaternion_do_not_matter(a, b, factor):
    assume(np.linalg.norm(a.center - b.center) > 1e-3)
    again = Ellipsoid(b.semi_axes, b.center, b.orientation * factor)
    np.testing.assert_allclose(again.shape_matrix, b.shape_matrix, rtol=0, atol=1e-12 * b.semi_axes.max() ** 2)
    same_separation(ccd.separation(a, again), ccd.separation(a, b))


@modest
@given(ELLIPSOIDS, MOTIONS, ELLIPSOIDS, MOTIONS)
def test_renaming_the_axes_does_not_matter(a, motion_a, b, motion_b):
    """(a, b, c) becomes (b, c, a) in a frame turned by 120 degrees about (1, 1, 1); flipping two axes is no change either."""
    cyclic = Rotation.from_matrix([[0, 0, 1], [1, 0, 0], [0, 1, 0]])     # new x is old y, and so on
    flipped = Rotation.from_rotvec([np.pi, 0, 0])
    renamed = Ellipsoid(np.roll(b.semi_axes, -1), b.center, quaternion(rotation_of(b) * cyclic))
    np.testing.assert_allclose(renamed.shape_matrix, b.shape_matrix, rtol=0, atol=1e-12 * b.semi_axes.max() ** 2)
    turned = Ellipsoid(b.semi_axes, b.center, quaternion(rotation_of(b) * flipped))
    expected = ccd.first_contact(a, motion_a, b, motion_b)
    assert same_contact(ccd.first_contact(a, motion_a, renamed, motion_b), expected)
    assert same_contact(ccd.first_contact(a, motion_a, turned, motion_b), expected)


@modest
@given(ELLIPSOIDS, MOTIONS, ELLIPSOIDS, MOTIONS)
def test_larger_bodies_meet_earlier(a, motion_a, b, motion_b):
    small = ccd.first_contact(a, motion_a, b, motion_b)
    large = ccd.first_contact(Ellipsoid(a.semi_axes * 1.1, a.center, a.orientation), motion_a, b, motion_b)
    if small.status == Status.OVERLAPPING:
        assert large.status == Status.OVERLAPPING
    elif small.status == Status.CONTACT:
        assert large.time < small.time
