"""A free rigid body with any moments of inertia turns as Euler's equations say, to the last digits, and never faster than is promised."""

import itertools

import mpmath
import numpy as np
import pytest
import reference
import tops
from cross_section import cross_section
from pairs import directions
from scipy.integrate import solve_ivp

from ccd import free_top, rotation
from ccd.first_contact import support_course, support_motion

SOLID = (1.64, 2.2025, 2.5625)                  # of the ellipsoid with semi-axes 1.25, 1 and 0.8
FAMILIES = {
    "solid": SOLID,
    "other order": (2.5625, 1.64, 2.2025),
    "far from equal": (1, 1.4, 2.3),
    "equal": (2, 2, 2),
    "prolate": (2, 2, 1),
    "oblate": (1, 1.9, 1),
    "nearly equal": (1, 1 + 1e-9, 1 - 1e-9),
    "nearly prolate": (2, 1, 2 - 1e-9),
    "flat": (1, 1.5, 2.5),
}


def bodies(family, n=12, seed=1):
    """Random orientations, momenta and inverse moments of n bodies, and their angular velocity now, in size."""
    rng = np.random.default_rng(seed)
    q, x = rng.normal(size=(n, 4)), rng.normal(size=(n, 3))
    q /= np.linalg.norm(q, axis=1)[:, None]
    moments = np.tile(np.array(FAMILIES.get(family, SOLID)), (n, 1))
    if family == "needle":
        moments = np.array([1, 1.0001, 1e-4]) * np.ones((n, 1))
    elif family == "needle without spin":
        moments, x = np.array([1, 1.0001, 1e-4]) * np.ones((n, 1)), x * [1, 1, 1e-4]
    elif family == "plate":
        moments = np.array([1, 1 + 1e-4, 2]) * np.ones((n, 1))
    elif family == "separatrix":                # L^2 = 2 E I of the middle axis
        j = 1 / moments
        x[:, 0] = np.sqrt((j[:, 1] - j[:, 2]) / (j[:, 0] - j[:, 1])) * x[:, 2]
    elif family == "axis":
        x = np.eye(3)[np.arange(n) % 3]
    elif family == "almost an axis":
        x = np.eye(3)[np.arange(n) % 3] + 1e-5 * x
    momentum = tops.rotated(q, x).astype(float)
    return q, momentum, 1 / moments, np.linalg.norm(tops.in_body(q, momentum).astype(float) / moments, axis=1)


def turned(q, momentum, inverse_moments, time):
    return np.array([free_top.turn_freely(*(tuple(a[k].tolist()) for a in (q, momentum, inverse_moments)), float(time[k]))
                     for k in range(len(q))])


def precision(angle):
    return 1e-15 + 4e-15 * abs(angle) + tops.PRECISION * abs(angle)


# against the oracle

@pytest.mark.parametrize(("family", "angle"), cross_section(FAMILIES, [0.01, 0.3, 1, -1, 10]))
def test_bodies_turn_as_the_series_of_eulers_equations_say(family, angle):
    q, momentum, inverse, w = bodies(family)
    error = tops.distance(turned(q, momentum, inverse, angle / w), tops.turned(q, momentum, inverse, angle / w)[0])
    assert error.max() < precision(angle) if abs(angle) > 0.3 else error.max() < 6e-16 + tops.PRECISION


@pytest.mark.parametrize("family", ["solid", "prolate", "nearly prolate"])
def test_a_hundred_radians_are_one_step(family):
    q, momentum, inverse, w = bodies(family, 3)
    error = tops.distance(turned(q, momentum, inverse, 100 / w), tops.turned(q, momentum, inverse, 100 / w)[0])
    assert error.max() < precision(100)


@pytest.mark.parametrize(("family", "angle"), cross_section(["needle", "needle without spin", "plate", "axis"], [0.01, 0.3, -1, 3]))
def test_needles_plates_and_turns_about_an_axis(family, angle):
    """Rounding of a momentum across a needle makes it spin at L over the smallest moment times the rounding: that counts."""
    q, momentum, inverse, w = bodies(family, 3)
    error = tops.distance(turned(q, momentum, inverse, angle / w), tops.turned(q, momentum, inverse, angle / w)[0])
    assert (error < precision(angle * np.linalg.norm(momentum, axis=1) * inverse.max(axis=1) / w)).all()


@pytest.mark.parametrize(("family", "angle"), cross_section(["separatrix", "almost an axis"], [0.3, 3, 10, 30]))
def test_near_the_separatrix_rounding_grows_no_faster_than_the_motion_makes_it(family, angle):
    q, momentum, inverse, w = bodies(family, 9)
    time = angle / w
    error = tops.distance(turned(q, momentum, inverse, time), tops.turned(q, momentum, inverse, time)[0])
    low, middle, high = np.sort(inverse[0])
    growth = np.exp(np.linalg.norm(momentum, axis=1) * np.sqrt((middle - low) * (high - middle)) * time)
    assert (error < precision(angle) * growth).all()


def test_the_oracle_agrees_with_mpmath():
    q, momentum, inverse, w = bodies("far from equal", 1)
    x = [mpmath.mpf(float(v)) for v in tops.in_body(q, momentum).astype(float)[0]]
    with mpmath.workdps(25):
        j = [mpmath.mpf(v) for v in inverse[0]]

        def rates(_, y):
            a, b, c = j[0] * y[4], j[1] * y[5], j[2] * y[6]
            return [(-y[1] * a - y[2] * b - y[3] * c) / 2, (y[0] * a + y[2] * c - y[3] * b) / 2, (y[0] * b + y[3] * a - y[1] * c) / 2,
                    (y[0] * c + y[1] * b - y[2] * a) / 2, y[5] * c - y[6] * b, y[6] * a - y[4] * c, y[4] * b - y[5] * a]

        start = [mpmath.mpf(v) for v in (1, 0, 0, 0)] + x
        end = np.array([[tops.EXTENDED(mpmath.nstr(v, 24)) for v in mpmath.odefun(rates, 0, start)(2 / w[0])[:4]]])
    found, _ = tops.turned([[1, 0, 0, 0]], np.array([x], dtype=float), inverse, 2 / w)
    assert tops.distance(found, end)[0] < 1e-18 + 4 * tops.PRECISION
    product = free_top.turn_freely((1.0, 0.0, 0.0, 0.0), tuple(map(float, x)), tuple(inverse[0].tolist()), 2 / w[0])
    assert tops.distance([product], end)[0] < precision(2)


@pytest.mark.parametrize("family", ["solid", "far from equal"])
def test_bodies_turn_as_a_runge_kutta_method_says(family):
    q, momentum, inverse, w = bodies(family, 3, seed=2)
    for k in range(3):
        def rates(_, p, k=k):
            matrix = reference.quat_to_R(p)
            a, b, c = matrix @ (inverse[k] * (matrix.T @ momentum[k]))
            return 0.5 * np.array([-a * p[1] - b * p[2] - c * p[3], a * p[0] + b * p[3] - c * p[2], b * p[0] + c * p[1] - a * p[3],
                                   c * p[0] + a * p[2] - b * p[1]])
        end = solve_ivp(rates, (0, 20 / w[k]), q[k], method="DOP853", rtol=1e-13, atol=1e-15).y[:, -1]
        found = turned(q[k:k + 1], momentum[k:k + 1], inverse[k:k + 1], 20 / w[k:k + 1])
        assert tops.distance(found, [end / np.linalg.norm(end)])[0] < 1e-11


# closed forms

def test_the_angular_velocity_in_the_body_is_that_of_jacobis_functions():
    q, momentum, inverse, w = bodies("solid", 10, seed=3)
    later = turned(q, momentum, inverse, 7 / w)
    for k in range(10):
        spin = tops.in_body(q[k:k + 1], momentum[k:k + 1]).astype(float)[0] * inverse[k]
        expected = reference.free_triaxial_omega(1 / inverse[k], spin, 7 / w[k])
        np.testing.assert_allclose(tops.in_body(later[k:k + 1], momentum[k:k + 1])[0] * inverse[k], expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("family", ["prolate", "oblate"])
def test_the_axis_of_a_body_of_revolution_precesses_about_the_momentum(family):
    q, momentum, inverse, w = bodies(family, 10)
    later, axis = turned(q, momentum, inverse, 40 / w), {"prolate": 2, "oblate": 1}[family]
    for k in range(10):
        matrix = reference.quat_to_R(q[k])
        spin = matrix @ (inverse[k] * (matrix.T @ momentum[k]))
        along, _ = reference.free_spheroid(1 / inverse[k, axis - 1], 1 / inverse[k, axis], matrix[:, axis], spin, 40 / w[k])
        np.testing.assert_allclose(reference.quat_to_R(later[k])[:, axis], along, rtol=0, atol=1e-13)


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("angle", [0.2, 4.0, 1e4])
def test_turning_about_a_principal_axis_is_steady_even_about_the_middle_one(axis, angle):
    inverse, momentum = tuple(1 / np.array(SOLID)), tuple(np.eye(3)[axis].tolist())
    found = free_top.turn_freely((1.0, 0.0, 0.0, 0.0), momentum, inverse, angle / inverse[axis])
    expected = np.concatenate([[np.cos(angle / 2)], np.sin(angle / 2) * np.eye(3)[axis]])
    assert tops.distance([found], [expected])[0] < 4e-16 * max(1, angle)


def test_equal_moments_turn_at_a_constant_rate():
    q, momentum, inverse, w = bodies("equal", 10)
    for k in range(10):
        spin = tuple((momentum[k] * inverse[k]).tolist())
        expected = rotation.turn(tuple(q[k].tolist()), spin, 3 / w[k])
        assert tops.distance(turned(q[k:k + 1], momentum[k:k + 1], inverse[k:k + 1], 3 / w[k:k + 1]), [expected])[0] < 4e-15


@pytest.mark.parametrize("time", [0.0, 0.3, 1e9])
def test_what_has_no_momentum_stays_as_it_is(time):
    q = (0.5, -0.5, 0.5, 0.5)
    assert free_top.turn_freely(q, (0.0, 0.0, 0.0), (1.0, 0.7, 0.3), time) == q


def test_no_time_is_no_turn():
    q, momentum, inverse, _ = bodies("solid")
    assert tops.distance(turned(q, momentum, inverse, np.zeros(12)), q).max() < 3e-16


# symmetries

@pytest.mark.parametrize("family", ["solid", "needle", "plate", "separatrix", "nearly prolate"])
@pytest.mark.parametrize("angle", [0.2, 2.0])
def test_two_flights_are_one_and_the_way_back_leads_back(family, angle):
    q, momentum, inverse, w = bodies(family, 20, seed=4)
    half = turned(q, momentum, inverse, 0.5 * angle / w)
    whole = turned(q, momentum, inverse, angle / w)
    assert tops.distance(turned(half, momentum, inverse, 0.5 * angle / w), whole).max() < 3 * precision(angle)
    assert tops.distance(turned(whole, momentum, inverse, -angle / w), q).max() < 3 * precision(angle)


@pytest.mark.parametrize(("length", "mass", "time"), [(1e-9, 1e-20, 1e-12), (1e6, 1e30, 1e7), (1, 1e-40, 1e-30)])
@pytest.mark.parametrize("angle", [0.2, 20.0])
def test_units_do_not_matter(length, mass, time, angle):
    q, momentum, inverse, w = bodies("solid")
    moment = mass * length**2
    scaled = turned(q, momentum * moment / time, inverse / moment, time * angle / w)
    assert tops.distance(scaled, turned(q, momentum, inverse, angle / w)).max() < 2 * precision(angle)


@pytest.mark.parametrize("family", ["solid", "prolate", "separatrix", "almost an axis", "needle", "nearly equal"])
def test_flights_longer_than_float64_can_resolve_still_end_in_an_orientation(family):
    q, momentum, inverse, w = bodies(family)
    for angle in (1e4, 1e9, 1e20, 1e100):
        assert np.abs((turned(q, momentum, inverse, angle / w)**2).sum(axis=1) - 1).max() < 1e-15


# angular velocity and momentum

def test_angular_velocity_and_momentum_belong_together():
    q, momentum, inverse, _ = bodies("far from equal")
    for k in range(12):
        given = [tuple(a[k].tolist()) for a in (q, momentum, inverse)]
        w = free_top.angular_velocity(*given)
        matrix = reference.quat_to_R(q[k])
        np.testing.assert_allclose(w, matrix @ (inverse[k] * (matrix.T @ momentum[k])), rtol=0, atol=2e-15)
        np.testing.assert_allclose(free_top.angular_momentum(given[0], w, given[2]), momentum[k], rtol=0, atol=4e-15)


@pytest.mark.parametrize("family", ["far from equal", "prolate", "equal"])
def test_turning_by_the_axes_is_that_by_the_quaternion_and_its_rate_eulers(family):
    """I dw/dt = L x w, in the frame of the body."""
    q, momentum, inverse, _ = bodies(family)
    for k in range(12):
        given, matrix = tuple(tuple(a[k].tolist()) for a in (momentum, inverse)), reference.quat_to_R(q[k])
        w, rate = free_top.turning_of(tuple(map(tuple, matrix.T)), *given)
        np.testing.assert_allclose(w, free_top.angular_velocity(tuple(q[k]), *given), rtol=0, atol=4e-15)
        torque = np.cross(matrix.T @ momentum[k], matrix.T @ w)
        np.testing.assert_allclose(matrix.T @ rate, inverse[k] * torque, rtol=0, atol=1e-14)


# bounds

def course(family, n=3, turns=20.0, samples=120):
    """w (samples, n, 3) and dw/dt in the frames of the bodies, over a long time, by the oracle."""
    q, momentum, inverse, w = bodies(family, n)
    x, step = tops.in_body(q, momentum), turns / w / samples
    spins, rates = [], []
    for _ in range(samples):
        spins.append((inverse * x).astype(float))
        rates.append(inverse * np.cross(x.astype(float), spins[-1]))
        _, x = tops.turned(np.tile([1, 0, 0, 0], (n, 1)), x, inverse, step)
    return (q, momentum, inverse), np.linalg.norm(spins, axis=2).max(axis=0), np.linalg.norm(rates, axis=2).max(axis=0)


def fastest_turning(q, momentum, inverse):
    """Of bodies (n, ...): (n, 2)."""
    given = zip(*(map(tuple, a.tolist()) for a in (q, momentum, inverse)))
    return np.array([free_top.fastest_turning(free_top.top_of(*body), body[2]) for body in given])


@pytest.mark.parametrize("family", ["solid", "other order", "far from equal", "prolate", "equal"])
def test_no_body_ever_turns_faster_than_its_bound_and_each_comes_close_to_it(family):
    given, speed, change = course(family)
    bounds = fastest_turning(*given)
    assert (speed <= bounds[:, 0] * (1 + 1e-14)).all()
    assert (change <= bounds[:, 1] * (1 + 1e-14) + 1e-15).all()
    np.testing.assert_allclose(speed, bounds[:, 0], rtol=5e-3)
    np.testing.assert_allclose(change, bounds[:, 1], rtol=5e-3, atol=1e-15)


def turning_of(q, momentum, inverse, semi_axes):
    """What `support_course` takes of a body: its semi-axis vectors and its turning with the bounds for all time."""
    moments, axes = 1 / inverse, np.array(semi_axes)
    unequal = max(abs(moments[i] - moments[j]) / moments[k] for i, j, k in itertools.permutations(range(3)))
    (most, hardest), = fastest_turning(q[None], momentum[None], inverse[None])
    spread, frame = axes.max()**2 - axes.min()**2, rotation.body_axes(tuple(q.tolist()))
    spin, acceleration = free_top.turning_of(frame, tuple(momentum.tolist()), tuple(inverse.tolist()))
    bounds = (most**2 + 0.5 * hardest) * spread / axes.min(), *free_top.jolts(most, hardest, unequal, spread)
    vectors = tuple(tuple((length * np.array(axis)).tolist()) for length, axis in zip(semi_axes, frame))
    return vectors, (spin, acceleration, 0.5 * (axes.max()**2 + axes.min()**2), *bounds)


@pytest.mark.parametrize("family", ["solid", "other order", "far from equal", "separatrix"])
@pytest.mark.parametrize("semi_axes", [(1.25, 1, 0.8), (3, 1, 0.5), (0.2, 1, 1.1)])
def test_the_third_derivative_of_a_support_is_bounded_from_near_by(semi_axes, family):
    """Of h^2, over 6, for the direction and its derivatives as the body sees them, by Euler's equations: at most twice the rest is lost."""
    q, momentum, inverse, _ = bodies(family, 100, seed=7)
    x, n = tops.in_body(q, momentum).astype(float), directions(np.random.default_rng(5), 100)
    w, torque = inverse * x, np.cross(x, inverse * x)
    rate = inverse * torque
    jerk = inverse * (np.cross(torque, w) + np.cross(x, rate))
    zeroth = tops.in_body(q, n).astype(float)
    first = np.cross(zeroth, w)
    second = np.cross(first, w) + np.cross(zeroth, rate)
    third = np.cross(second, w) + 2 * np.cross(first, rate) + np.cross(zeroth, jerk)
    exact = ((first * second + zeroth * third / 3) * np.square(semi_axes)).sum(axis=1)
    for k in range(100):
        vectors, turning = turning_of(q[k], momentum[k], inverse[k], semi_axes)
        found, rest = support_course(vectors, turning, tuple(n[k].tolist()))[3], turning[4]
        assert exact[k] <= found + 1e-13
        assert found <= exact[k] + 2 * rest + 1e-13


@pytest.mark.parametrize("family", ["solid", "other order", "far from equal", "separatrix"])
@pytest.mark.parametrize("semi_axes", [(1.25, 1, 0.8), (3, 1, 0.5), (0.2, 1, 1.1)])
def test_the_support_of_a_free_body_stays_below_its_parabola(semi_axes, family):
    """Eq. (7d), up to several horizons, along fixed directions; and the parabola is much lower than with the bound on h'' alone."""
    n = 150
    q, momentum, inverse, w = bodies(family, n, seed=8)
    n_fixed, gained = directions(np.random.default_rng(9), n), []
    for reach in (0.05, 0.3, 1.0):
        parabolas = []
        for k in range(n):
            vectors, turning = turning_of(q[k], momentum[k], inverse[k], semi_axes)
            parabolas.append(support_motion(vectors, turning, tuple(n_fixed[k].tolist()), reach / w[k]))
            gained.append(parabolas[-1][2] / turning[3])
        value, rate, curve = np.array(parabolas).T
        for time in np.linspace(0, reach / w, 31):
            h = np.linalg.norm(semi_axes * tops.in_body(tops.turned(q, momentum, inverse, time)[0], n_fixed), axis=1).astype(float)
            assert (h <= value + rate * time + 0.5 * curve * time**2 + 1e-14 * max(semi_axes)).all()
    assert np.mean(gained) < 0.5


@pytest.mark.parametrize("semi_axes", [(1.25, 1, 0.8), (3, 1, 0.5), (0.2, 1, 1.1)])
def test_the_support_of_a_free_body_bends_and_moves_no_more_than_its_bounds(semi_axes):
    """Along fixed directions, at random moments of many bodies: h' and h'' from differences of the oracle's supports."""
    n, axes = 1000, np.array(semi_axes)
    q, momentum, _, _ = bodies("solid", n, seed=5)
    inverse = np.tile(5 / (np.sum(axes**2) - axes**2), (n, 1))
    w = np.linalg.norm(tops.in_body(q, momentum).astype(float) * inverse, axis=1)
    n_fixed, step = directions(np.random.default_rng(6), n), 1e-4 / w
    h = [np.linalg.norm((axes * tops.in_body(tops.turned(q, momentum, inverse, shift * step)[0], n_fixed)), axis=1) for shift in (-1, 0, 1)]
    rate, bend = ((h[2] - h[0]) / (2 * step)).astype(float), ((h[2] - 2 * h[1] + h[0]) / step**2).astype(float)
    bounds = fastest_turning(q, momentum, inverse)
    spread = axes.max()**2 - axes.min()**2
    share = np.abs(rate) / (bounds[:, 0] * (axes.max() - axes.min()))
    bent = bend / ((bounds[:, 0]**2 + 0.5 * bounds[:, 1]) * spread / h[1].astype(float))
    assert share.max() < 1
    assert bent.max() < 1
    assert share.max() > 0.7
    assert bent.max() > 0.4
