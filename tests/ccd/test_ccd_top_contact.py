"""First contacts of free bodies with any moments of inertia: none missed, none invented, and as at a constant rate where it is constant."""

import dense
import numpy as np
import pytest
import tops
from pairs import assert_touches_there, bodies, directions, meeting

import ccd
from ccd import Ellipsoid, FreeFlight, Rest, Status, top_contact


def free(flights, moments=None):
    """As the product takes them in a batch, turning freely; with the moments of the solids if none are given."""
    squares = flights.semi_axes**2
    moments = squares.sum(axis=1, keepdims=True) - squares if moments is None else moments
    return ccd.Bodies(flights.semi_axes, flights.center, flights.orientation, flights.velocity, flights.angular_velocity,
                      flights.growth_rate, moments)


def single(batch, k):
    return (Ellipsoid(batch.semi_axes[k], batch.center[k], batch.orientation[k]),
            FreeFlight(batch.velocity[k], batch.angular_velocity[k], batch.growth_rate[k], batch.moments[k]))


def integrated(batch, t_max):
    """As the dense oracle takes them."""
    courses = dense.free_courses(batch.orientation, batch.angular_velocity, batch.moments, t_max)
    return dense.FreeFlights(batch.semi_axes, batch.center, batch.orientation, batch.velocity, batch.angular_velocity, batch.growth_rate,
                             batch.moments, courses)


def same(found, expected, precision):
    (time, status), (expected_time, expected_status) = found, expected
    np.testing.assert_array_equal(status, expected_status)
    hit = np.isfinite(expected_time)
    np.testing.assert_allclose(time[hit], expected_time[hit], rtol=0, atol=precision)


@pytest.mark.parametrize(("seed", "axes", "spin", "growth"), [(31, (0.3, 2), 6, 0.0), (32, (0.8, 1.2), 6, 0.3), (33, (0.1, 2), 3, -0.3)])
def test_random_tops_miss_no_contact_and_invent_none(seed, axes, spin, growth):
    a, b = (free(each) for each in meeting(np.random.default_rng(seed), 24, axes, spin, growth=abs(growth)))
    expected, depth = dense.first_contact(integrated(a, 1.0), integrated(b, 1.0), 1.0, samples=200)
    assert 5 < np.isfinite(expected).sum() < 22
    assert (np.abs(depth - 1) > 1e-6).all()                                  # nothing that the oracle cannot tell
    status = np.where(expected == 0, Status.OVERLAPPING, np.where(np.isfinite(expected), Status.CONTACT, Status.NO_CONTACT))
    same(ccd.batch.first_contact(a, b), (expected, status), 1e-9)


@pytest.mark.parametrize(("seed", "axes", "growth"), [(41, (0.15, 3), 0.0), (42, (0.05, 2), 0.3), (43, (0.8, 1.2), -0.2)])
def test_equal_moments_meet_as_at_a_constant_rate(seed, axes, growth):
    a, b = meeting(np.random.default_rng(seed), 400, axes, growth=abs(growth))
    expected = ccd.batch.first_contact(bodies(a), bodies(b))
    same(ccd.batch.first_contact(free(a, np.ones((400, 3))), free(b, np.full((400, 3), 7.0))), expected, 1e-11)
    same(ccd.batch.first_contact(bodies(a), free(b, np.ones((400, 3)))), expected, 1e-11)


@pytest.mark.parametrize("long", [0.2, 3.0])
def test_solids_of_revolution_meet_as_by_their_precession(long):
    rng = np.random.default_rng(44)
    a, b = meeting(rng, 60, (0.5, 1))
    for flights in (a, b):
        flights.semi_axes[:, 1] = flights.semi_axes[:, 0]
        flights.semi_axes[:, 2] = long * flights.semi_axes[:, 0]
    tops = free(a), free(b)
    time, status = ccd.batch.first_contact(*tops)
    assert 10 < (status == Status.CONTACT).sum() < 55
    for k in range(60):
        (one, flight), (two, other) = single(tops[0], k), single(tops[1], k)
        found = ccd.first_contact(one, FreeFlight.of_solid(one, flight.velocity, flight.angular_velocity),
                                  two, FreeFlight.of_solid(two, other.velocity, other.angular_velocity))
        same((time[k:k + 1], status[k:k + 1]), (np.array([found.time]), [found.status]), 1e-11)


@pytest.mark.parametrize("depth", [1e-8])
def test_grazing_tops_are_told_apart(depth):
    a, b = (integrated(free(each), 1.0) for each in meeting(np.random.default_rng(45), 10, (0.5, 1.5), 4))
    for sign in (1, -1):
        moved, time = dense.graze(a, b, 1.0, np.full(10, sign * depth), samples=80)
        there = np.abs(dense.deepest(a, moved, 1.0, samples=80)[1] - (1 - sign * depth)) < 1e-3 * depth
        there &= (time > 0.05) & (time < 0.95)
        assert there.sum() > 3
        one, two = a.pick(there), moved.pick(there)
        _, status = ccd.batch.first_contact(free(one, one.moments), free(two, two.moments))
        assert (status == (Status.CONTACT if sign > 0 else Status.NO_CONTACT)).all()


@pytest.mark.parametrize("axes", [(1.25, 1, 0.8), (0.02, 0.3, 2), (0.02, 2, 1.5)])
def test_a_support_stays_below_its_parabola_as_long_as_it_promises(axes):
    """Needles and plates seen from all sides: their h falls to a small part of what it was, and rises again."""
    n, rng, axes = 60, np.random.default_rng(51), np.array(axes)
    spin, seen = 3 * directions(rng, n), directions(rng, n) / axes**0.6
    q, inverse = rng.normal(size=(n, 4)), np.tile(1 / (np.sum(axes**2) - axes**2), (n, 1))
    q /= np.linalg.norm(q, axis=1)[:, None]
    momentum = tops.rotated(q, tops.in_body(q, spin) / inverse).astype(float)
    fixed = tops.rotated(q, seen / np.linalg.norm(seen, axis=1)[:, None]).astype(float)
    value, rate, bend, reach = np.empty((4, n))
    for k in range(n):
        turning = [tuple(each[k].tolist()) for each in (q, np.zeros((n, 3)), spin, inverse)]
        flight = (tuple(axes.tolist()), (0.0, 0.0, 0.0), *turning, 0.0)
        body, bent = top_contact._launched(flight)
        s, w = top_contact._posed(body, 0.0)
        (value[k], rate[k], bend[k]), reach[k] = top_contact._support(s, w, bent, tuple(fixed[k].tolist()))
    local, reach = np.isfinite(reach), np.minimum(reach, 0.7)
    assert axes.min() > 0.1 or local.sum() > 20
    for share in np.linspace(0, 1, 7):
        turned, _ = tops.turned(q, momentum, inverse, share * reach)
        h = np.linalg.norm((axes * tops.in_body(turned, fixed)).astype(float), axis=1)
        bound = value + share * reach * (rate + 0.5 * share * reach * bend)
        assert (h <= bound + 1e-14).all()


def test_the_parabola_of_a_needle_ends_before_it_swings_past_its_thin_side():
    """Semi-axes 2 and 0.02, turning at 1: h is |(2 sin(0.3 - t), 0.02 cos(0.3 - t))|, all but straight until 0.3, where it turns round."""
    body, bent = top_contact._launched(((2.0, 0.02, 0.02), (0.0,) * 3, (1.0, 0.0, 0.0, 0.0), (0.0,) * 3, (0.0, 0.0, 1.0), (1.0,) * 3, 0.0))
    (value, rate, bend), reach = top_contact._support(*top_contact._posed(body, 0.0), bent, (np.sin(0.3), -np.cos(0.3), 0.0))
    assert 0.1 < reach < 0.3
    time = np.linspace(0, reach, 100)
    assert (np.hypot(2 * np.sin(0.3 - time), 0.02 * np.cos(0.3 - time)) <= value + rate * time + 0.5 * bend * time**2 + 1e-15).all()


def test_a_batch_is_its_pairs_one_by_one_bit_for_bit():
    a, b = (free(each) for each in meeting(np.random.default_rng(46), 100, growth=0.2))
    time, status = ccd.batch.first_contact(a, b, 0.9)
    for k in range(100):
        found = ccd.first_contact(*single(a, k), *single(b, k), (0, 0.9))
        assert (found.status, found.time) == (status[k], time[k])


def test_the_window_may_start_and_end_anywhere():
    a, b = (free(each) for each in meeting(np.random.default_rng(47), 60, growth=0.2))
    times, status = ccd.batch.first_contact(a, b)
    k = int(((status == Status.CONTACT) & (times > 0.2)).argmax())
    pair = *single(a, k), *single(b, k)
    for window in ((0.1, 1), (times[k] - 0.01, times[k] + 0.01), (-0.2, 1)):
        assert ccd.first_contact(*pair, window).time == pytest.approx(times[k], abs=1e-12)
    assert ccd.first_contact(*pair, (0, times[k] - 1e-9)).status == Status.NO_CONTACT
    assert ccd.first_contact(*pair, (times[k] + 1e-9, 2)).status == Status.OVERLAPPING


def test_at_a_contact_the_bodies_touch_there():
    a, b = (free(each) for each in meeting(np.random.default_rng(48), 30, (0.5, 2), 4))
    courses, seen = [integrated(each, 1.0) for each in (a, b)], 0
    for k in range(30):
        found = ccd.first_contact(*single(a, k), *single(b, k))
        if found.status != Status.CONTACT:
            continue
        seen += 1
        assert_touches_there(found, courses, k, 1e-8, 1e-6)
    assert seen > 8


def test_concentric_and_overlapping_bodies_are_said_and_not_searched():
    top = FreeFlight((1, 0, 0), (0, 1, 2), moments=(1, 2, 2.5))
    assert ccd.first_contact(Ellipsoid((1, 2, 3)), top, Ellipsoid((2, 1, 1)), Rest()).status == Status.OVERLAPPING
    found = ccd.first_contact(Ellipsoid((1, 2, 3)), top, Ellipsoid((1, 1, 1), (1.5, 0, 0)), Rest(), (0.25, 1))
    assert (found.status, found.time) == (Status.OVERLAPPING, 0.25)


def test_only_the_ratios_of_the_moments_matter():
    a, b = meeting(np.random.default_rng(49), 50)
    moments = 1 + np.random.default_rng(50).random((50, 3))
    expected = ccd.batch.first_contact(free(a, moments), free(b, moments))
    same(ccd.batch.first_contact(free(a, 1e-40 * moments), free(b, 1e30 * moments)), expected, 1e-12)


@pytest.mark.parametrize(("moments", "words"), [((1, 2), "^moments.*three positive moments"), ((1, 0, 2), "^moments.*expected positive"),
                                                ((1, np.inf, 2), "^moments.*finite")])
def test_moments_that_no_body_has_are_refused(moments, words):
    with pytest.raises(ValueError, match=words):
        FreeFlight((0, 0, 0), (0, 0, 1), moments=moments)
    with pytest.raises(ValueError, match=r"^moments"):
        ccd.Bodies((1, 2, 3), np.zeros((2, 3)), np.tile([1, 0, 0, 0], (2, 1)), moments=np.tile(moments, (2, 1)))


def test_a_top_has_no_rational_motion():
    with pytest.raises(ValueError, match=r"flight\.moments.*constant angular velocity"):
        ccd.approximate_flight(Ellipsoid((1, 2, 3)), FreeFlight((0, 0, 0), (0, 0, 1), moments=(1, 2, 2.5)))
