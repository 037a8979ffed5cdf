"""The bounds of a plane that turns: no body in flight goes beyond them, and they are exact to the order that they claim."""

from math import cos, isnan, nan, sin

import numpy as np
import pytest
from dense import Flights
from pairs import directions

from ccd.first_contact import meeting_window
from ccd.turning_plane import facing, first_root, following, holding_span, support_bend, support_series, swing
from ccd.vectors import add, dot, norm, scale

AXES = [(0.9, 1.1), (0.3, 2), (0.05, 3)]


def flying(rng, axes, spin, growth, n=60):
    return Flights(np.exp(rng.uniform(*np.log(axes), (n, 3))), np.zeros((n, 3)), rng.normal(size=(n, 4)), np.zeros((n, 3)),
                   spin * directions(rng, n), np.full(n, growth))


def kernel_vectors(axes):
    return tuple(map(tuple, axes.T.tolist()))


def parts(body, k, n, m):
    """series and swing of body k in the direction n + t m, as the shoot makes them."""
    s = kernel_vectors(body.pick([k]).at(np.zeros(1))[1][0])
    spin, growth = tuple(body.angular_velocity[k].tolist()), float(body.growth_rate[k])
    flight, rate = (1.0, spin, growth), norm(spin)
    face = facing(s, flight, tuple(n))
    return face, support_series(face, flight, tuple(n), tuple(m)), swing(s, scale(1 / max(rate, 1e-300), spin), rate)


def support(body, k, direction, time):
    """size * h (T,) in the directions (T, 3) at the times (T,)."""
    axes = body.pick(np.full(len(time), k)).at(time)[1]
    return np.linalg.norm(np.einsum("tij,ti->tj", axes, direction), axis=1)


@pytest.mark.parametrize("turning", [0.0, 0.5, 8.0])
@pytest.mark.parametrize(("spin", "growth"), [(0.0, 0.0), (1.0, 0.8), (6.0, 0.0), (6.0, -0.7)])
@pytest.mark.parametrize("axes", AXES)
def test_a_support_stays_below_its_bound_up_to_the_reach(axes, spin, growth, turning):
    rng = np.random.default_rng(1)
    body = flying(rng, axes, spin, growth)
    for k, (n, m) in enumerate(zip(directions(rng, 60), turning * directions(rng, 60))):
        m -= (m @ n) * n
        face, series, swung = parts(body, k, n.tolist(), m.tolist())
        longest = min(1.0, 0.5 / max(-series[4], 1e-9))
        for reach in longest * np.array([1.0, 0.3, 0.03]):
            bend = support_bend(series, swung, float(np.linalg.norm(m)), float(reach))
            time = np.linspace(0, reach, 60)
            h = support(body, k, n + time[:, None] * m, time)
            bound = face[0] + series[0] * time + 0.5 * bend * time**2
            assert (h <= bound + 1e-13 * (1 + h)).all()


@pytest.mark.parametrize("axes", AXES)
def test_the_bound_is_exact_to_second_order(axes):
    """At no reach the bend is the second derivative of the support, and `following` maximises that of the gap."""
    rng, dt = np.random.default_rng(2), 1e-4
    body = flying(rng, axes, 1.0, 0.4)
    for k, (n, m) in enumerate(zip(directions(rng, 60), directions(rng, 60))):
        m -= (m @ n) * n
        face, series, swung = parts(body, k, n.tolist(), m.tolist())
        if face[0] < 0.3:
            continue                                # differences in time are too blunt there
        time = np.array([-dt, 0, dt])
        low, middle, high = support(body, k, n + time[:, None] * m, time)
        assert series[0] == pytest.approx((high - low) / (2 * dt), rel=1e-5, abs=1e-5)
        assert support_bend(series, swung, 1.0, 0.0) == pytest.approx((high - 2 * middle + low) / dt**2, rel=1e-3, abs=1e-3)


def test_the_direction_that_is_followed_is_the_best_to_first_order():
    rng = np.random.default_rng(3)
    a, b = flying(rng, (0.4, 2), 2.0, 0.3), flying(rng, (0.4, 2), 2.0, -0.2)
    for k, n in enumerate(directions(rng, 60)):
        velocity = rng.normal(size=3)

        def bend_of_gap(m, k=k, n=n, velocity=velocity):
            bends = [support_bend(*parts(body, k, n.tolist(), m.tolist())[1:], 0.0, 0.0) for body in (a, b)]
            return 2 * m @ velocity - sum(bends)

        (face_a, *_), (face_b, *_) = (parts(body, k, n.tolist(), [0.0, 0.0, 0.0]) for body in (a, b))
        best, solved = following(face_a, face_b, 0.0, tuple(n.tolist()), add(tuple(velocity.tolist()), add(face_a[3], face_b[3])))
        best = np.array(best)
        assert solved
        assert abs(best @ n) < 1e-12 * (1 + np.linalg.norm(best))
        for other in directions(rng, 4):
            other = 0.1 * (other - (other @ n) * n)
            assert bend_of_gap(best + other) < bend_of_gap(best)


@pytest.mark.parametrize("guess", [1e-6, 0.05, 1.0, 0.0])
def test_a_plane_separates_the_bodies_for_its_span(guess):
    """However the first look at the reach is chosen."""
    rng = np.random.default_rng(4)
    a, b = flying(rng, (0.2, 2), 3.0, 0.2), flying(rng, (0.2, 2), 3.0, -0.3)
    for k, n in enumerate(directions(rng, 60)):
        (face_a, _, swing_a), (face_b, _, swing_b) = (parts(body, k, n.tolist(), [0.0, 0.0, 0.0]) for body in (a, b))
        gap, velocity = 0.2, -n + rng.normal(size=3)
        r = (gap + face_a[0] + face_b[0]) * n + 0.3 * np.cross(n, rng.normal(size=3))
        m, _ = following(face_a, face_b, gap, tuple(n.tolist()), add(tuple(velocity.tolist()), add(face_a[3], face_b[3])))
        (_, series_a, _), (_, series_b, _) = (parts(body, k, n.tolist(), m) for body in (a, b))
        rate = float(n @ velocity + m @ r) - series_a[0] - series_b[0]
        plane = (gap, rate, 2 * dot(m, tuple(velocity.tolist())), norm(m))
        span = holding_span(plane, (series_a, swing_a), (series_b, swing_b), 1.0, guess)
        time = np.linspace(0, min(span, 1.0), 80)
        direction = n + time[:, None] * np.array(m)
        apart = (direction * (r + time[:, None] * velocity)).sum(axis=1)
        assert span > 0
        assert (apart - support(a, k, direction, time) - support(b, k, direction, time) > -1e-13).all()


def test_a_body_of_revolution_that_spins_about_its_axis_does_not_swing():
    s = ((2.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    assert max(swing(s, (1.0, 0.0, 0.0), 3.0)) < 1e-3
    assert min(swing(s, (cos(1 / 30), sin(1 / 30), 0.0), 3.0)) > 0.9
    assert swing(s, (0.0, 0.0, 0.0), 0.0) == (0, 0, 0)


@pytest.mark.parametrize(("gap", "rate", "bend", "root"), [
    (1, -1, 0, 1), (1, 0, 2, 1), (1, 3, 8, 1), (1, -3, -4, 0.5), (1, -1, -2, np.inf),
    (0, 1, 2, 1), (0, -1, 3, 0), (1, 1, -1, np.inf), (1, 0, 0, np.inf)])
def test_the_first_root_of_a_parabola(gap, rate, bend, root):
    assert first_root(float(gap), float(rate), float(bend)) == pytest.approx(root, rel=1e-15)


def test_what_float64_cannot_hold_is_never_taken_for_a_time():
    assert all(isnan(first_root(*each)) for each in [(nan, 1.0, 1.0), (1.0, nan, 1.0), (1.0, 1.0, nan), (1.0, -1.0, nan)])


@pytest.mark.parametrize("far", [1, 1e3, 1e7])
def test_the_window_is_that_of_the_bounding_spheres(far):
    rng = np.random.default_rng(5)
    seen = 0
    for r, v, growing in zip(rng.normal(size=(400, 3)), rng.normal(size=(400, 3)), rng.uniform(-1, 1, 400)):
        meet = rng.uniform(0.2, 0.8)
        start = r - far * meet * v
        begin, end = meeting_window(tuple(start.tolist()), tuple((far * v).tolist()), 1.5, float(growing), 1.0)
        time = np.concatenate([np.linspace(0, 1, 2000), meet + np.linspace(-4, 4, 2001) / far])
        time = time[(time >= 0) & (time <= 1)]
        inside = np.linalg.norm(start + time[:, None] * (far * v), axis=1) < 1.5 + growing * time
        assert not inside[(time < begin) | (time > end)].any()
        seen += inside.any()
        for edge in (begin, end):
            if 0 < edge < 1:                            # no wider than it must be
                assert np.linalg.norm(start + edge * (far * v)) == pytest.approx(1.5 + growing * edge, abs=1e-6)
    assert seen > 100
