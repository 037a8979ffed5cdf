"""The first contact of two ellipsoids in free flight: none missed, none invented, none unresolved, and at the right time."""

import json
from pathlib import Path

import dense
import numba
import numpy as np
import pytest
import reference
from cross_section import cross_section
from pairs import assert_touches_there, bodies, meeting, single

import ccd
from ccd import Ellipsoid, FreeFlight, Rest, Status, queries
from ccd.tolerances import SHOOT_STEPS

COLLISIONS = json.loads((Path(dense.__file__).parent / "collisions.json").read_text())
UPRIGHT = (1, 0, 0, 0)


def compare(a, b, expected, precision, t_max=1.0):
    """The batch finds a contact where `expected` (K,) is finite, at that time, and none elsewhere."""
    time, status = ccd.batch.first_contact(bodies(a), bodies(b), t_max)
    hit = np.isfinite(expected)
    wanted = np.where(hit, np.where(expected == 0, Status.OVERLAPPING, Status.CONTACT), Status.NO_CONTACT)
    np.testing.assert_array_equal(status, wanted)
    np.testing.assert_array_equal(np.isfinite(time), hit)
    np.testing.assert_allclose(time[hit], expected[hit], rtol=0, atol=precision)


def first_root(a, b, c):
    """The first root of a t^2 + 2 b t + c where it becomes negative, inf for none; c > 0 at the start. Without cancellation."""
    square = b * b - a * c
    with np.errstate(invalid="ignore", divide="ignore"):
        root = np.where((square > 0) & (b < 0), c / (np.sqrt(square) - b), np.inf)
        return np.where((a < 0) & (b >= 0), (b + np.sqrt(square)) / -a, root)


# closed forms

@pytest.mark.parametrize("growth", [0.0, 0.4])
def test_spheres_meet_at_the_root_of_a_quadratic(growth):
    rng = np.random.default_rng(1)
    a, b = meeting(rng, 500, axes=(0.2, 2), growth=growth)
    a.semi_axes[:], b.semi_axes[:] = a.semi_axes[:, :1], b.semi_axes[:, :1]
    r, v = b.center - a.center, b.velocity - a.velocity
    reach = a.semi_axes[:, 0] + b.semi_axes[:, 0]
    growing = a.semi_axes[:, 0] * a.growth_rate + b.semi_axes[:, 0] * b.growth_rate
    time = first_root((v**2).sum(axis=1) - growing**2, (r * v).sum(axis=1) - reach * growing, (r**2).sum(axis=1) - reach**2)
    time[time > 1] = np.inf
    assert 100 < np.isfinite(time).sum() < 400
    compare(a, b, time, 1e-12)


def test_growing_spheres_at_rest_meet():
    a, b = Ellipsoid((1, 1, 1)), Ellipsoid((2, 2, 2), (0, 0, 5))
    found = ccd.first_contact(a, FreeFlight((0, 0, 0), growth_rate=1.0), b, FreeFlight((0, 0, 0), growth_rate=0.25), (0, 10))
    assert found.status == Status.CONTACT
    assert found.time == pytest.approx(4 / 3, rel=1e-14)
    np.testing.assert_allclose(found.point, (0, 0, 7 / 3), rtol=0, atol=1e-13)


def test_parallel_ellipsoids_without_spin_are_stretched_spheres():
    rng = np.random.default_rng(2)
    a, b = meeting(rng, 500, axes=(0.2, 3), spin=0, growth=0.3)
    b.orientation[:] = a.orientation
    b.semi_axes[:] = a.semi_axes * rng.uniform(0.3, 2, (500, 1))
    _, axes = a.at(np.zeros(500))
    r = np.linalg.solve(axes, (b.center - a.center)[:, :, None])[:, :, 0]
    v = np.linalg.solve(axes, (b.velocity - a.velocity)[:, :, None])[:, :, 0]
    ratio = b.semi_axes[:, 0] / a.semi_axes[:, 0]
    reach, growing = 1 + ratio, a.growth_rate + ratio * b.growth_rate
    keep = (r**2).sum(axis=1) > reach**2
    time = first_root((v**2).sum(axis=1) - growing**2, (r * v).sum(axis=1) - reach * growing, (r**2).sum(axis=1) - reach**2)
    time[time > 1] = np.inf
    compare(a.pick(keep), b.pick(keep), time[keep], 1e-12)


def test_a_spinning_body_of_revolution_about_its_axis_does_not_move():
    still = ccd.first_contact(Ellipsoid((1, 1, 3)), Rest(), Ellipsoid((2, 1, 1), (4, 1, 1)), FreeFlight((-2, 0, 0)), (0, 5))
    spun = ccd.first_contact(Ellipsoid((1, 1, 3)), FreeFlight((0, 0, 0), (0, 0, 9)),
                             Ellipsoid((2, 1, 1), (4, 1, 1)), FreeFlight((-2, 0, 0), (7, 0, 0)), (0, 5))
    assert spun.time == pytest.approx(still.time, rel=1e-13)
    assert spun.status == still.status == Status.CONTACT


@pytest.mark.parametrize("radius", [1e3, 1e5, 1e6])
def test_a_turning_needle_hits_the_flat_side_of_a_huge_sphere(radius):
    """A needle (0.2, 0.2, 2) turns in place about x at 0.5, its surface at 1 from a sphere: its support along y is known in time."""
    found = ccd.first_contact(Ellipsoid((0.2, 0.2, 2)), FreeFlight((0, 0, 0), (0.5, 0, 0)),
                              Ellipsoid([radius] * 3, (0, 1 + radius, 0)), Rest(), (0, 3))
    assert found.status == Status.CONTACT
    assert found.time == pytest.approx(2 * np.arcsin(np.sqrt((1 - 0.2**2) / (2**2 - 0.2**2))), abs=5 / radius)    # flat to 2^2 / 2 radius
    np.testing.assert_allclose(found.normal, (0, 1, 0), rtol=0, atol=3 / radius)


# vectors of others

def flight_of_solid(axes, quaternion, velocity, spin):
    """The flight of a free solid: its shape turns at the constant rate L / I_perp where it is one of revolution."""
    rotation = reference.quat_to_R(np.array(quaternion))
    spin, axes = np.array(spin), np.array(axes)
    if not spin.any() or (axes == axes[0]).all():
        return FreeFlight(velocity, spin)
    for k in range(3):
        if axes[k - 1] == axes[k - 2]:
            along, across = 2 * axes[k - 1] ** 2, axes[k - 1] ** 2 + axes[k] ** 2
            u = rotation[:, k]
            return FreeFlight(velocity, spin + (along / across - 1) * (spin @ u) * u)
    return FreeFlight(velocity, spin, moments=np.sum(axes**2) - axes**2)


@pytest.mark.parametrize("vector", COLLISIONS, ids=[v["name"] for v in COLLISIONS])
def test_flights_of_two_bodies_meet_as_in_the_reference(vector):
    a, b = (Ellipsoid(vector[f"axes{i}"], vector[f"x{i}"], vector[f"q{i}"]) for i in "12")
    motion_a, motion_b = (flight_of_solid(vector[f"axes{i}"], vector[f"q{i}"], vector[f"v{i}"], vector[f"w{i}"]) for i in "12")
    found = ccd.first_contact(a, motion_a, b, motion_b, (0, vector["horizon"]))
    if vector["toi"] is None:
        assert (found.status, found.time) == (Status.NO_CONTACT, np.inf)
        return
    assert found.status == Status.CONTACT
    assert found.time == pytest.approx(vector["toi"], rel=0, abs=1e-11)
    np.testing.assert_allclose(found.normal, vector["normal"], rtol=0, atol=1e-9)
    at_contact = np.array(vector["x1"]) + np.array(vector["v1"]) * vector["toi"] + vector["contact_from1"]
    np.testing.assert_allclose(found.point, at_contact, rtol=0, atol=1e-9)


# the dense oracle

@pytest.mark.parametrize(("seed", "axes", "spin", "growth"), [
    (11, (0.15, 3), 12, 0.0),
    (12, (0.15, 3), 12, 0.3),
    (13, (0.8, 1.2), 3, 0.0),
    (14, (0.05, 2), 6, -0.3),
])
def test_random_flights_miss_no_contact_and_invent_none(seed, axes, spin, growth):
    a, b = meeting(np.random.default_rng(seed), 120, axes, spin, abs(growth))
    if growth < 0:
        a.growth_rate, b.growth_rate = -np.abs(a.growth_rate), -np.abs(b.growth_rate)
    expected, _ = dense.first_contact(a, b, 1.0)
    assert 20 < np.isfinite(expected).sum() < 110
    compare(a, b, expected, 1e-12)


def test_bodies_that_start_near_each_other():
    """As after a collision elsewhere: the first gaps are small, the flights short, and some pairs overlap at the start."""
    a, b = meeting(np.random.default_rng(15), 120, (0.3, 3), 6)
    b.center = a.center + 0.35 * (b.center - a.center)
    expected, _ = dense.first_contact(a, b, 1.0)
    assert (expected == 0).sum() > 20
    assert (expected > 0).sum() > 40
    compare(a, b, expected, 1e-12)


DEPTHS = [1e-3, 1e-5, 1e-7, 1e-9]


@pytest.fixture(scope="module")
def grazes():
    """Pairs of touching scale exactly 1 at the deepest point of their flights, well inside the window."""
    a, b = meeting(np.random.default_rng(16), 60)
    b, time = dense.graze(a, b, 1.0, np.zeros(60))
    inside = (time > 0.05) & (time < 0.95)
    return a.pick(inside), b.pick(inside)


@pytest.mark.parametrize(("depth", "sign"), cross_section(DEPTHS, [1, -1]))
def test_grazing_flights_are_told_apart_however_slight(grazes, depth, sign):
    a, at_zero = grazes
    b, _ = dense.graze(a, at_zero, 1.0, np.full(len(a), sign * depth), rounds=4)
    expected, _ = dense.first_contact(a, b, 1.0, samples=300)
    as_asked = np.abs(dense.deepest(a, b, 1.0)[1] - (1 - sign * depth)) < 1e-3 * depth
    assert as_asked.sum() > 30
    assert np.isfinite(expected[as_asked]).all() == (sign > 0)
    # a gap of 1e-14 is what float64 can tell; at a graze of depth d the time follows it with 1 / sqrt(d)
    compare(a.pick(as_asked), b.pick(as_asked), expected[as_asked], 1e-9 if depth < 1e-8 else 3e-11)


# what a flight may be

def test_overlapping_at_the_start_is_said_and_not_searched():
    found = ccd.first_contact(Ellipsoid((1, 2, 3)), Rest(), Ellipsoid((1, 1, 1), (1.5, 0, 0)), FreeFlight((5, 0, 0)), (0.25, 1))
    assert found.status == Status.CONTACT or found.time == np.inf       # at 0.25 they are apart already
    found = ccd.first_contact(Ellipsoid((1, 2, 3)), Rest(), Ellipsoid((1, 1, 1), (1.5, 0, 0)), FreeFlight((1, 0, 0)), (0.25, 1))
    assert (found.status, found.time) == (Status.OVERLAPPING, 0.25)


def test_bodies_with_one_centre_overlap():
    found = ccd.first_contact(Ellipsoid((1, 2, 3)), Rest(), Ellipsoid((2, 1, 1)), FreeFlight((1, 0, 0)))
    assert (found.status, found.time) == (Status.OVERLAPPING, 0)


@pytest.mark.parametrize("seed", range(8))
def test_a_pair_that_has_just_collided_parts_without_a_second_contact(seed):
    """At the contact the relative velocity is reversed: the same contact must not be found again, the way back must be free."""
    rng = np.random.default_rng(100 + seed)
    a, b = meeting(rng, 40)
    k = int(np.isfinite(ccd.batch.first_contact(bodies(a), bodies(b), 1.0)[0]).argmax())
    (one, flight), (two, other) = single(a, k), single(b, k)
    contact = ccd.first_contact(one, flight, two, other)
    time = np.array([contact.time])
    (center_a, axes_a), (center_b, axes_b) = a.pick([k]).at(time), b.pick([k]).at(time)

    def posed(center, axes):
        lengths = np.linalg.norm(axes[0], axis=0)
        turned = dense.Rotation.from_matrix(axes[0] / lengths).as_quat()
        return Ellipsoid(lengths, center[0], np.roll(turned, 1))

    touching_a, touching_b = posed(center_a, axes_a), posed(center_b, axes_b)
    away = FreeFlight(other.velocity + 10 * contact.normal)
    assert ccd.first_contact(touching_a, FreeFlight(flight.velocity), touching_b, away).status == Status.NO_CONTACT
    towards = FreeFlight(flight.velocity - 10 * contact.normal)
    again = ccd.first_contact(touching_a, FreeFlight(flight.velocity), touching_b, towards)
    assert again.status in (Status.CONTACT, Status.OVERLAPPING)
    assert again.time < 1e-12


@pytest.mark.parametrize("seed", range(6))
def test_the_window_may_start_and_end_anywhere(seed):
    a, b = meeting(np.random.default_rng(200 + seed), 60, growth=0.2)
    times, status = ccd.batch.first_contact(bodies(a), bodies(b), 1.0)
    k = int(((status == Status.CONTACT) & (times > 0.2)).argmax())
    (one, flight), (two, other) = single(a, k), single(b, k)
    assert ccd.first_contact(one, flight, two, other, (0.1, 1)).time == pytest.approx(times[k], abs=1e-12)
    assert ccd.first_contact(one, flight, two, other, (times[k] - 0.01, times[k] + 0.01)).time == pytest.approx(times[k], abs=1e-12)
    assert ccd.first_contact(one, flight, two, other, (0, times[k] - 1e-9)).status == Status.NO_CONTACT
    assert ccd.first_contact(one, flight, two, other, (times[k] + 1e-9, 2)).status == Status.OVERLAPPING
    assert ccd.first_contact(one, flight, two, other, (-0.2, 1)).time == pytest.approx(times[k], abs=1e-12)


def test_negative_growth_ends_a_contact_that_would_be():
    a, b = Ellipsoid((1, 1, 2)), Ellipsoid((1, 2, 1), (3, 0, 0))
    assert ccd.first_contact(a, Rest(), b, FreeFlight((-1.1, 0, 0)), (0, 1)).time == pytest.approx(1 / 1.1, rel=1e-13)
    shrinking = FreeFlight((-1.1, 0, 0), growth_rate=-0.3)
    assert ccd.first_contact(a, FreeFlight((0, 0, 0), growth_rate=-0.3), b, shrinking, (0, 1)).status == Status.NO_CONTACT
    slower = FreeFlight((-1.6, 0, 0), growth_rate=-0.3)
    found = ccd.first_contact(a, FreeFlight((0, 0, 0), growth_rate=-0.3), b, slower, (0, 1))
    assert found.time == pytest.approx(1.0 / (1.6 - 0.6), rel=1e-12)


def test_what_never_touches_has_no_time_normal_or_point():
    found = ccd.first_contact(Ellipsoid((1, 2, 3)), Rest(), Ellipsoid((1, 1, 1), (9, 0, 0)), FreeFlight((1, 0, 0)), (0, 1e9))
    assert (found.status, found.time) == (Status.NO_CONTACT, np.inf)
    assert np.isnan(found.normal).all()
    assert np.isnan(found.point).all()


def test_two_bodies_at_rest_never_touch():
    assert ccd.first_contact(Ellipsoid((1, 2, 3)), Rest(), Ellipsoid((1, 1, 1), (9, 0, 0)), Rest()).status == Status.NO_CONTACT


def test_at_a_contact_the_bodies_touch_there():
    a, b = meeting(np.random.default_rng(17), 60, growth=0.2)
    seen = 0
    for k in range(60):
        (one, flight), (two, other) = single(a, k), single(b, k)
        found = ccd.first_contact(one, flight, two, other)
        if found.status != Status.CONTACT:
            continue
        seen += 1
        assert_touches_there(found, (a, b), k, 1e-9, 1e-7)
    assert seen > 20


# batches

def test_a_batch_is_its_pairs_one_by_one_bit_for_bit():
    a, b = meeting(np.random.default_rng(18), 150, growth=0.2)
    time, status = ccd.batch.first_contact(bodies(a), bodies(b), 0.9)
    for k in range(150):
        found = ccd.first_contact(*single(a, k), *single(b, k), (0, 0.9))
        assert (found.status, found.time) == (status[k], time[k])


def test_a_batch_does_not_depend_on_its_order_size_or_the_run():
    a, b = meeting(np.random.default_rng(19), 300)
    time, status = ccd.batch.first_contact(bodies(a), bodies(b), 1.0)
    order = np.random.default_rng(0).permutation(300)
    shuffled = ccd.batch.first_contact(bodies(a.pick(order)), bodies(b.pick(order)), 1.0)
    np.testing.assert_array_equal(shuffled[0], time[order])
    np.testing.assert_array_equal(shuffled[1], status[order])
    np.testing.assert_array_equal(ccd.batch.first_contact(bodies(a.pick(slice(7))), bodies(b.pick(slice(7))), 1.0)[0], time[:7])
    np.testing.assert_array_equal(ccd.batch.first_contact(bodies(a), bodies(b), 1.0)[0], time)


def test_a_batch_gives_the_same_bits_on_any_number_of_threads():
    a, b = meeting(np.random.default_rng(22), 500, growth=0.2)
    together = ccd.batch.first_contact(bodies(a), bodies(b))
    threads = numba.get_num_threads()
    try:
        for fewer in range(1, threads + 1):
            numba.set_num_threads(fewer)
            time, status = ccd.batch.first_contact(bodies(a), bodies(b))
            np.testing.assert_array_equal(time, together[0])
            np.testing.assert_array_equal(status, together[1])
    finally:
        numba.set_num_threads(threads)


def test_what_stays_unresolved_says_where_and_why():
    """A speck 1e-40 small: float64 cannot hold the pencil parameter. Where it starts inside, that is said, and not guessed."""
    speck, flight = Ellipsoid((1e-40, 2e-40, 1e-40)), FreeFlight((0.1, 0, 0), (1, 2, 3))
    outside, inside = (ccd.first_contact(speck, flight, Ellipsoid((1, 2, 1), center), FreeFlight((0, -2, 0), (0, 0.3, 1)))
                       for center in ((0.3, 3, 0), (0.1, 0.5, 0.3)))
    assert outside.status == Status.CONTACT
    found = inside
    assert found.status == Status.UNRESOLVED
    assert f"at time {found.time} the pencil" in found.reason
    assert "steps" in queries._reason(Status.UNRESOLVED, 0.25, SHOOT_STEPS)
    assert queries._reason(Status.CONTACT, 0.25, 3) == ""


def test_an_empty_batch_has_no_contacts():
    nobody = ccd.Bodies(np.ones((0, 3)), np.ones((0, 3)), np.ones((0, 4)))
    time, status = ccd.batch.first_contact(nobody, nobody)
    assert len(time) == len(status) == len(ccd.batch.contact_function(nobody, nobody)) == 0


# the cost

def test_regular_contacts_take_a_handful_of_steps_and_nothing_stays_unresolved():
    a, b = meeting(np.random.default_rng(20), 3000, spin=6, axes=(0.5, 2))
    _, status = ccd.batch.first_contact(bodies(a), bodies(b), 1.0)
    assert not (status == Status.UNRESOLVED).any()
    steps = [ccd.first_contact(*single(a, k), *single(b, k)).iterations for k in np.flatnonzero(status == Status.CONTACT)[:200]]
    assert np.mean(steps) < 12
    assert max(steps) < 60


def test_convergence_is_quadratic():
    """Steps until the shoot has passed the contact time less 1e-2, 1e-3, 1e-6 and 1e-12: digits double, so the last cost no more."""
    a, b = meeting(np.random.default_rng(21), 400, spin=6, axes=(0.5, 2))
    times, status = ccd.batch.first_contact(bodies(a), bodies(b), 1.0)
    regular = np.flatnonzero((status == Status.CONTACT) & (times > 0.1))[:60]
    steps = np.array([[ccd.first_contact(*single(a, k), *single(b, k), (0, times[k] - left)).iterations for left in (1e-3, 1e-6, 1e-12)]
                      for k in regular])
    assert np.median(steps[:, 1] - steps[:, 0]) <= 2
    assert np.median(steps[:, 2] - steps[:, 1]) <= 2
    assert (steps[:, 2] - steps[:, 1]).mean() < 1.5
