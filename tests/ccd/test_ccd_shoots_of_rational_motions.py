"""First contact under rational motions: recursive shoots, their order of convergence, and the other road to the same contact."""

import numpy as np
import pytest
from paths import overlaps
from rational_pairs import EXAMPLE_1, ROOT2, SHAPES, affine, directions, interpolated, pair, rigid, shifted
from test_ccd_grazing import bounce, past

import ccd
from ccd import Ellipsoid, FreeFlight, Rest, State, Status
from ccd.bezier_shoot import best_certificate, bezier_shoot


def shoots(bodies, contact, span=(0.0, 1.0)):
    """Errors of the recursive shoots from the start of the span, while they are not down to rounding."""
    grid = ccd.CCDEquation(*bodies, t_span=span)._parts[0].grid
    work, time, errors = np.empty((2, grid.shape[1])), 0.0, []
    for _ in range(60):
        _, u, _ = best_certificate(grid, time, 0.5)
        time = bezier_shoot(grid, (u, 1.0, False), time, 1.0, work)
        errors.append(contact - (span[0] + time * (span[1] - span[0])))
        if errors[-1] < 1e-7:
            break
    return errors


def test_example_1_has_its_first_contact_at_one_half():
    found = ccd.first_contact(*EXAMPLE_1)
    assert found.status == Status.CONTACT
    assert found.time == pytest.approx(0.5, abs=1e-12)
    np.testing.assert_allclose(found.point, [ROOT2, 0, ROOT2], rtol=0, atol=1e-12)
    assert np.linalg.norm(found.normal) == pytest.approx(1, abs=1e-14)
    assert found.iterations <= 6


def test_the_shoots_of_example_1_converge_quadratically():
    """As those of the u that maximises F, 0.0175, 6.3e-6, 3.9e-15; here u maximises f, which is the same only at the contact."""
    errors = [error for error in shoots(EXAMPLE_1, 0.5) if error < 0.1]
    assert len(errors) == 3
    assert abs(errors[2]) < 1e-14
    assert errors[1] < 0.06 * errors[0] ** 2
    assert 0 <= errors[1] < errors[0]
    assert ccd.first_contact(*EXAMPLE_1).time - 0.5 < 4e-15


def test_shoots_at_regular_contacts_converge_at_least_quadratically():
    """Once near, each error is below a constant times the square of the last, and the order measured is 2 or more."""
    rng = np.random.default_rng(1)
    a, b = rigid(rng, 150, 2, 2), rigid(rng, 150, 4, 2)
    orders = []
    for k in range(150):
        found = ccd.first_contact(*pair(a, b, k))
        if found.status != Status.CONTACT:
            continue
        errors = [abs(error) for error in shoots(pair(a, b, k), found.time) if error < 0.02]
        if len(errors) >= 2 and errors[-1] > 3e-13:
            orders.append(np.log(errors[-1]) / np.log(errors[-2]))
    assert len(orders) > 25
    assert np.median(orders) > 1.9
    assert min(orders) > 1.4                    # the constant in front counts, too


@pytest.mark.parametrize(("path", "time"), [(past(0.0), 0.375), (bounce(0.0, bend=-8.0), 0.625)])
def test_shoots_at_tangential_contacts_converge_linearly(path, time):
    turned = ccd.RationalMotion([[1, 0], [0, 0.5], [0, 0], [0, 0.25]], path)
    body, rest, sphere = Ellipsoid((1, 1, 1)), Rest(), Ellipsoid((1, 1, 1))
    straight = path / np.array([1.0, 0.5, 2.0])[:, None]
    errors = [error for error in shoots((body, rest, sphere, ccd.RationalMotion(turned.rotation, straight)), time) if 1e-6 < error < 0.05]
    if len(errors) > 3:                         # a motion that keeps the best u arrives at once
        ratios = np.array(errors[1:]) / errors[:-1]
        assert (ratios > 0.05).all()
        assert (ratios < 0.95).all()


def test_a_tangential_contact_of_turning_bodies_is_approached_linearly():
    """From inside no shoot comes; from outside each halves or so what is left, and none goes beyond the contact."""
    rng = np.random.default_rng(2)
    a, b = rigid(rng, 40, 2, 1), rigid(rng, 40, 2, 1)
    from dense import contact_function_and_normal
    seen = 0
    for k in range(40):
        one, other = a.pick([k]), b.pick([k])
        for _ in range(25):                     # carry B along the normal until the smallest mu is 1
            times = np.linspace(0.05, 0.95, 801)
            from dense import touching_scale
            mu = touching_scale(one.pick(np.zeros(801, int)), other.pick(np.zeros(801, int)), times)
            low = times[mu.argmin()]
            (center_a, axes_a), (center_b, axes_b) = one.at(np.array([low])), other.at(np.array([low]))
            _, n = contact_function_and_normal(center_b - center_a, axes_a, axes_b)
            other = shifted(other, (1 - mu.min()) * mu.min() * n / (n * n).sum())
            if abs(mu.min() - 1) < 1e-9:
                break
        if not 0.1 < low < 0.9 or seen >= 4:
            continue
        seen += 1
        errors = [error for error in shoots(pair(one, other, 0), low) if 3e-3 < error < 0.2]
        ratios = np.array(errors[1:]) / errors[:-1]
        assert (ratios < 1).all()
        if len(ratios) > 2:
            assert ratios[-1] > 0.02
    assert seen >= 2


def first_of(found):
    return next((interval.start for interval in found if interval.state == State.OVERLAPPING), np.inf)


@pytest.mark.parametrize("shape", SHAPES)
def test_the_first_contact_is_where_the_first_overlap_starts(shape):
    rng = np.random.default_rng(len(shape))
    kinds = [(rigid(rng, 60, 2, 3, shape=shape), rigid(rng, 60, 4, 2, 2, shape)),
             (affine(rng, 60, 1, 1, shape=shape), rigid(rng, 60, 2, 2))]
    for a, b in kinds:
        for k in range(60):
            found, start = ccd.first_contact(*pair(a, b, k)), first_of(ccd.contact_intervals(*pair(a, b, k)))
            if start == 0:
                assert (found.status, found.time) == (Status.OVERLAPPING, 0.0)
            elif start == np.inf:
                assert (found.status, found.time) == (Status.NO_CONTACT, np.inf)
                assert np.isnan(found.point).all()
                assert np.isnan(found.normal).all()
            else:
                assert found.status == Status.CONTACT
                assert found.time == pytest.approx(start, abs=1e-9)


def test_first_contacts_are_those_that_sampling_finds():
    rng = np.random.default_rng(4)
    a, b = rigid(rng, 300, 4, 2, 1), rigid(rng, 300, 2, 3)
    for k, expected in enumerate(overlaps(a, b)):
        if expected.clearance > 1e-7:
            found = ccd.first_contact(*pair(a, b, k))
            time = 0.0 if expected.overlap_at_start else expected.changes[0] if len(expected.changes) else np.inf
            assert found.time == pytest.approx(time, abs=1e-9)
            if found.status == Status.CONTACT:
                center, axes = a.pick([k]).at(np.array([found.time]))
                local = np.linalg.solve(axes[0], found.point - center[0])
                outward = np.linalg.solve(axes[0].T, local)
                assert abs(np.linalg.norm(local) - 1) < 1e-9
                np.testing.assert_allclose(outward / np.linalg.norm(outward), found.normal, rtol=0, atol=1e-6)


def test_the_interpolant_s_first_contact_is_that_of_its_intervals():
    a, b, corners = interpolated(np.random.default_rng(5), 60)
    for k in range(60):
        bodies = Ellipsoid(a.semi_axes[k]), Rest(), Ellipsoid(b.semi_axes[k]), ccd.interpolate_affine(*corners[k])
        assert ccd.first_contact(*bodies).time == pytest.approx(first_of(ccd.contact_intervals(*bodies)), abs=1e-9)


def two_roads(n, seed, degree, spin):
    """Free flight with spin, approximated and solved algebraically, against the certified shoot.

    An approximation whose angle errs by delta carries a body that lies between the true one made (1 - e) and (1 + e) times as large,
    with e = delta a_max / a_min. So its contact time lies between those of the larger and of the smaller bodies, also for grazes.
    """
    rng = np.random.default_rng(seed)
    law = {2: 1 / 720, 3: 1.0e-5, 4: 4e-8}[degree]
    sizes, around = rng.uniform(0.4, 1.6, (2, n, 3)), 4 * directions(rng, n)
    turn, angular = rng.normal(size=(2, n, 4)), np.array([directions(rng, n), directions(rng, n)]) * rng.uniform(0, spin, (2, n, 1))
    velocity = np.array([0.3 * rng.normal(size=(n, 3)), -around * rng.uniform(0.6, 1.6, (n, 1)) + 0.8 * rng.normal(size=(n, 3))])
    center = np.array([np.zeros((n, 3)), around])
    half = np.linalg.norm(angular, axis=2) / 2
    error = (1.3 * law * half ** (2 * degree + 1) + 1e-14) * sizes.max(axis=2) / sizes.min(axis=2)
    bounds = []
    for sign in (1, -1):
        groups = [ccd.Bodies(sizes[g] * (1 + sign * error[g])[:, None], center[g], turn[g], velocity[g], angular[g]) for g in (0, 1)]
        time, status = ccd.batch.first_contact(*groups, 1.0)
        assert (status != Status.UNRESOLVED).all()
        bounds.append(np.where(status == Status.OVERLAPPING, 0, time))
    contacts, widths = 0, []
    for k in range(n):
        bodies = [Ellipsoid(sizes[g, k], center[g, k], turn[g, k]) for g in (0, 1)]
        motions = [ccd.approximate_flight(bodies[g], FreeFlight(velocity[g, k], angular[g, k]), degree=degree) for g in (0, 1)]
        found = ccd.first_contact(bodies[0], motions[0], bodies[1], motions[1])
        assert found.status != Status.UNRESOLVED
        assert bounds[0][k] - 1e-10 <= found.time <= bounds[1][k] + 1e-10, k
        contacts += found.status == Status.CONTACT
        widths.append(bounds[1][k] - bounds[0][k] if np.isfinite(bounds[1][k]) else np.nan)
    assert 0.3 * n < contacts < 0.95 * n
    return np.nanmedian(widths)


def test_the_two_roads_agree():
    assert two_roads(500, 6, 3, 2.0) < 1e-5
    assert two_roads(200, 7, 4, 3.0) < 1e-6


@pytest.mark.validate
def test_the_two_roads_agree_for_ten_thousand_pairs():
    assert two_roads(10000, 8, 3, 2.0) < 1e-5


STRAIGHT = {"sphere": (1, 1, 1), "needle": (0.01, 0.01, 1), "plate": (1, 1, 0.01), "three axes": (0.5, 1, 2),
            "tiny": (0.0005, 0.001, 0.002)}


@pytest.mark.parametrize("other", STRAIGHT)
@pytest.mark.parametrize("one", STRAIGHT)
def test_without_rotation_the_two_roads_are_one(one, other):
    """Bodies that fly straight are rational exactly: the certified shoot, the Bézier shoots and the intervals give one time."""
    rng = np.random.default_rng(11)
    for _ in range(30):
        a = Ellipsoid(STRAIGHT[one], rng.normal(size=3), rng.normal(size=4))
        apart = rng.normal(size=3)
        apart *= 5 / np.linalg.norm(apart)
        b = Ellipsoid(STRAIGHT[other], a.center + apart, rng.normal(size=4))
        velocity = -1.6 * apart + 0.1 * rng.normal(size=3) * (a.semi_axes.min() + b.semi_axes.min())
        path = ccd.RationalMotion(b.orientation[:, None], np.stack([b.center, velocity], axis=1))
        at_rest = ccd.RationalMotion(a.orientation[:, None], a.center[:, None])
        certified, algebraic = ccd.first_contact(a, Rest(), b, FreeFlight(velocity)), ccd.first_contact(a, at_rest, b, path)
        starts = [each.start for each in ccd.contact_intervals(a, at_rest, b, path) if each.state == State.OVERLAPPING]
        assert certified.status == algebraic.status == Status.CONTACT
        assert len(starts) == 1
        np.testing.assert_allclose([algebraic.time, starts[0]], certified.time, rtol=0, atol=1e-12)
