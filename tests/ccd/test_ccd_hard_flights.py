"""First contact where it is hard: 4000 flights of every kind against the dense oracle, and grazes down to 1e-9 against constructions.

None missed, none invented, none unresolved.
"""

from functools import cache

import dense
import exact
import numpy as np
import pytest
from cross_section import cross_section
from dense import Flights
from pairs import bodies, meeting, single

import ccd
from ccd import Status


def shaped(a, b, shape):
    """The same flights with bodies of one kind, about as large."""
    for body in (a, b):
        body.semi_axes[:] = body.semi_axes.prod(axis=1, keepdims=True) ** (1 / 3) * np.array(shape) / np.prod(shape) ** (1 / 3)


def generic(rng, n):
    return *meeting(rng, n, (0.1, 10), growth=0.0), 1.0


def growing(rng, n):
    return *meeting(rng, n, (0.1, 10), growth=0.6), 1.0


def alike(rng, n):
    return *meeting(rng, n, (0.8, 1.2), spin=12, growth=0.2), 1.0


def needles(rng, n):
    a, b = meeting(rng, n, (0.4, 1.0), growth=0.2)
    shaped(a, b, (0.01, 0.01, 1))
    return a, b, 1.0


def plates(rng, n):
    a, b = meeting(rng, n, (0.4, 1.0), growth=0.2)
    shaped(a, b, (0.01, 1, 1))
    return a, b, 1.0


def equal(rng, n):
    a, b = meeting(rng, n)
    b.semi_axes[:], b.orientation[:] = a.semi_axes, a.orientation
    return a, b, 1.0


def needle_and_sphere(rng, n):
    a, b = meeting(rng, n, (0.4, 1.5))
    shaped(a, b, (1, 1, 1))
    a.semi_axes[:] *= (0.05, 0.05, 3)
    return a, b, 1.0


def scaled(size):
    def make(rng, n):
        a, b = meeting(rng, n, growth=0.3)
        for body in (a, b):
            for length in (body.semi_axes, body.center, body.velocity):
                length *= size
        return a, b, 1.0
    make.__name__ = f"size_{size:g}"
    return make


def crossing(rng, n):
    """They start near each other, some overlapping."""
    a, b = meeting(rng, n, (0.3, 3), 12)
    b.center = a.center + 0.35 * (b.center - a.center)
    return a, b, 1.0


def check(a, b, expected, smallest, t_max, precision):
    time, status = ccd.batch.first_contact(bodies(a), bodies(b), t_max)
    wanted = np.where(expected == 0, Status.OVERLAPPING, np.where(np.isfinite(expected), Status.CONTACT, Status.NO_CONTACT))
    clear = np.abs(smallest - 1) > 1e-9                 # what the oracle can tell
    assert clear.mean() > 0.99
    np.testing.assert_array_equal(status[clear], wanted[clear])
    hit = clear & np.isfinite(expected)
    np.testing.assert_allclose(time[hit], expected[hit], rtol=0, atol=precision * t_max)
    assert not (status == Status.UNRESOLVED).any()
    return hit


@pytest.mark.parametrize("make", [generic, growing, alike, needles, plates, equal, needle_and_sphere, scaled(1e-6), scaled(1e6), crossing],
                         ids=lambda make: make.__name__)
def test_hard_flights_miss_no_contact_and_invent_none(make):
    a, b, t_max = make(np.random.default_rng(40), 320)
    expected, smallest = dense.first_contact(a, b, t_max, samples=250)
    hit = check(a, b, expected, smallest, t_max, 1e-12)
    assert hit.sum() > 50


def test_bodies_that_come_from_far_away_are_found():
    """The oracle sees the last moments; the product starts the same flights a million times earlier."""
    a, b = meeting(np.random.default_rng(41), 400, growth=0.0)
    a.angular_velocity *= 1e-6
    b.angular_velocity *= 1e-6
    expected, smallest = dense.first_contact(a, b, 1.0, samples=60)
    early = np.full(400, -1e6)
    started = []
    for body in (a, b):
        center, axes = body.at(early)
        turned = dense.Rotation.from_matrix(axes / np.linalg.norm(axes, axis=1)[:, None, :])
        started.append(Flights(body.semi_axes, center, np.roll(turned.as_quat(), 1, axis=1), body.velocity, body.angular_velocity,
                               body.growth_rate))
    at_start = expected == 0
    expected = np.where(at_start, np.nan, expected + 1e6)
    keep = ~at_start
    a, b = (body.pick(keep) for body in started)
    hit = check(a, b, expected[keep], smallest[keep], 1e6 + 1, 1e-14)
    assert hit.sum() > 100


@pytest.mark.parametrize("inside", [0.0, 1e-9, 0.3])
def test_bodies_that_start_one_inside_the_other_overlap(inside):
    rng = np.random.default_rng(42)
    a, b = meeting(rng, 100, (0.1, 10))
    b.semi_axes[:] = 0.05 * a.semi_axes.min(axis=1, keepdims=True) * rng.uniform(0.5, 1, (100, 3))
    b.center = a.center + inside * a.semi_axes.min(axis=1, keepdims=True) * dense.Rotation.random(100, random_state=1).as_matrix()[:, 0]
    for pair in ((a, b), (b, a)):
        time, status = ccd.batch.first_contact(*map(bodies, pair))
        assert (status == Status.OVERLAPPING).all()
        assert not time.any()


GRAZING = {"steady": ((0.15, 3), 0.0), "long": ((0.1, 10), 0.0), "growing": ((0.15, 3), 0.3), "shrinking": ((0.15, 3), -0.3)}


@cache
def grazes(kind):
    """Pairs of touching scale 1 at the deepest point of their flights, well inside the window."""
    axes, growth = GRAZING[kind]
    a, b = meeting(np.random.default_rng(43), 28, axes, growth=abs(growth))
    if growth < 0:
        a.growth_rate, b.growth_rate = -np.abs(a.growth_rate), -np.abs(b.growth_rate)
    b, time = dense.graze(a, b, 1.0, np.zeros(28), rounds=8)
    regular = (time > 0.05) & (time < 0.95)
    return a.pick(regular), b.pick(regular)


@pytest.mark.parametrize(("kind", "depth"), cross_section(GRAZING, [1e-3, 1e-5, 1e-7, 1e-9]))
def test_grazing_flights_of_every_kind_are_told_apart(kind, depth):
    a, at_zero = grazes(kind)
    for sign in (1, -1):
        b, _ = dense.graze(a, at_zero, 1.0, np.full(len(a), sign * depth), rounds=3, samples=120)
        deepest = dense.deepest(a, b, 1.0)[1]
        as_asked = np.abs(deepest - (1 - sign * depth)) < 1e-2 * depth
        assert as_asked.sum() > 12
        one, other = a.pick(as_asked), b.pick(as_asked)
        expected, _ = dense.first_contact(one, other, 1.0, samples=200)
        hit = np.isfinite(expected)
        assert (hit == (sign > 0)).mean() > 0.9             # now and then another dip is deeper than it looked
        time, status = ccd.batch.first_contact(bodies(one), bodies(other))
        np.testing.assert_array_equal(status, np.where(hit, Status.CONTACT, Status.NO_CONTACT))
        np.testing.assert_allclose(dense.touching_scale(one.pick(hit), other.pick(hit), time[hit]), 1, rtol=0, atol=1e-12)
        np.testing.assert_allclose(time[hit], expected[hit], rtol=0, atol=1e-8 if depth < 1e-8 else 1e-10)


def exact_scale(a, b, k, time):
    """mu to 50 digits for the poses that float64 has at that time."""
    posed = []
    for body in (a, b):
        turned = (dense.Rotation.from_rotvec(body.angular_velocity[k] * time)
                  * dense.Rotation.from_quat(np.roll(body.orientation[k], -1)))
        posed += [body.semi_axes[k] * (1 + body.growth_rate[k] * time), body.center[k] + body.velocity[k] * time,
                  np.roll(turned.as_quat(), 1)]
    return exact.separation(*posed, digits=30).contact_function ** 0.5


@pytest.mark.parametrize("sign", [1, -1])
def test_a_graze_of_a_billionth_is_one_to_many_digits(sign):
    """The depth of the deepest point by mpmath, from the vertex of the parabola through three moments around it."""
    a, b = meeting(np.random.default_rng(44), 8, (0.3, 3), growth=0.2)
    b, _ = dense.graze(a, b, 1.0, np.full(8, sign * 1e-9), rounds=14)
    time, _ = dense.deepest(a, b, 1.0)
    seen, step = 0, 1e-4
    for k in np.flatnonzero((time > 0.05) & (time < 0.95))[:2]:
        low, middle, high = (exact_scale(a, b, k, time[k] + shift) - 1 for shift in (-step, 0, step))
        bend = low + high - 2 * middle
        vertex = float(middle - (high - low) ** 2 / (8 * bend))
        assert bend > 0
        assert vertex == pytest.approx(-sign * 1e-9, abs=2e-10)
        found = ccd.first_contact(*single(a, k), *single(b, k))
        assert found.status == (Status.CONTACT if sign > 0 else Status.NO_CONTACT)
        assert found.reason == ""
        seen += 1
    assert seen == 2
