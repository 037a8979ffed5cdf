"""Two groups in a frame: what is culled never touches, and the earliest contact is the earliest of all pairs."""

import numpy as np
import pytest
from cross_section import some_of
from hypothesis import given, settings
from hypothesis import strategies as st
from paths import Interpolated, Rigid, overlaps
from rational_pairs import directions, semi_axes
from scipy.spatial.transform import Rotation

import ccd
from ccd import Ellipsoid, Status
from ccd.scene import Group, Outcome

SIZE = 6


def group(rng, n, around, towards, shape="any", scale=0.6):
    axes, start = scale * semi_axes(rng, n, shape), around + 1.2 * rng.normal(size=(n, 3))
    end = start + towards + 0.8 * rng.normal(size=(n, 3))
    first = Rotation.random(n, random_state=rng)
    last = Rotation.from_rotvec(rng.uniform(0, 2.5, (n, 1)) * directions(rng, n)) * first
    poses = [np.roll(turn.as_quat(), 1, axis=1) * rng.choice([-1, 1], (n, 1)) for turn in (first, last)]
    return Group(ccd.Bodies(axes, start, poses[0]), ccd.Bodies(axes, end, poses[1]))


def frame(seed, n=SIZE, shape="any"):
    rng = np.random.default_rng(seed)
    apart, speed = rng.uniform(2.5, 6) * directions(rng, 1)[0], rng.uniform(0.1, 1.2)
    return group(rng, n, np.zeros(3), 0 * apart, shape), group(rng, n, apart, -speed * apart, shape)


def rigid_path(bodies, index):
    """The linear quaternion curve by the shorter way, and the linear path."""
    (p, q), n = (each.orientation[index] for each in (bodies.start, bodies.end)), len(index)
    q = np.where((p * q).sum(axis=1, keepdims=True) < 0, -q, q)
    c, d = bodies.start.center[index], bodies.end.center[index]
    return Rigid(bodies.start.semi_axes[index], np.stack([p, q - p], axis=2), np.stack([c, d - c], axis=2), np.ones((n, 1)))


def affine_path(one, other, i, j):
    inverses, centers = np.empty((len(i), 2, 3, 3)), np.empty((len(i), 2, 3))
    for k, end in enumerate(("start", "end")):
        a, b = getattr(one, end), getattr(other, end)
        into = Rotation.from_quat(np.roll(a.orientation[i], -1, axis=1)).inv().as_matrix()
        s = into @ Rotation.from_quat(np.roll(b.orientation[j], -1, axis=1)).as_matrix() / b.semi_axes[j][:, None, :]
        inverses[:, k], centers[:, k] = s @ s.transpose(0, 2, 1), np.einsum("kij,kj->ki", into, b.center[j] - a.center[i])
    axes, n = one.start.semi_axes[i], len(i)
    rest = Rigid(axes, np.tile([[[1.0], [0], [0], [0]]], (n, 1, 1)), np.zeros((n, 3, 1)), np.ones((n, 1)))
    return rest, Interpolated(other.start.semi_axes[j], inverses, centers)


def brute_force(one, other, interpolant="rigid"):
    """First contact times (n_a, n_b) by sampling: 0 for overlap at the start, inf for none."""
    i, j = (index.ravel() for index in np.indices((len(one), len(other))))
    paths = (rigid_path(one, i), rigid_path(other, j)) if interpolant == "rigid" else affine_path(one, other, i, j)
    times = [0.0 if x.overlap_at_start else x.changes[0] if len(x.changes) else np.inf for x in overlaps(*paths, samples=80)]
    return np.array(times).reshape(len(one), len(other))


@pytest.mark.parametrize("shape", ["any", "needle", "plate", "sphere"])
@pytest.mark.parametrize("interpolant", ["rigid", "affine"])
@pytest.mark.parametrize("seed", some_of(range(5), [0]))
def test_every_pair_is_what_sampling_finds(seed, interpolant, shape):
    """Without the bound every contact time; with it the earliest. A pair that was removed never touches. Counts add up."""
    one, other = frame(seed, shape=shape)
    expected = brute_force(one, other, interpolant)
    found = ccd.scene.first_contact(one, other, interpolant, running_bound=False)
    removed = (found.outcomes == Outcome.SPHERES_APART) | (found.outcomes == Outcome.PLANE_HOLDS)
    assert np.isinf(expected[removed]).all()
    np.testing.assert_allclose(found.times, expected, rtol=0, atol=1e-9)
    assert ((found.outcomes == Outcome.OVERLAPPING) == (expected == 0)).all()
    assert found.time == pytest.approx(expected.min(), abs=1e-9)
    for options in ({}, {"planes": False}):
        bounded = ccd.scene.first_contact(one, other, interpolant, **options)
        assert bounded.time == pytest.approx(expected.min(), abs=1e-9)
        assert np.isinf(expected[bounded.outcomes == Outcome.SPHERES_APART]).all() or expected.min() < np.inf
    for answer in (found, bounded):
        counts = answer.counts
        assert counts.pairs == SIZE * SIZE == counts.spheres_apart + counts.plane_holds + counts.overlapping + counts.solved
        assert counts.contacts == (answer.outcomes == Outcome.CONTACT).sum() <= counts.solved
        assert counts.spheres_apart == (answer.outcomes == Outcome.SPHERES_APART).sum()
        assert counts.plane_holds == (answer.outcomes == Outcome.PLANE_HOLDS).sum()
    if expected.min() == np.inf:
        assert (found.status, found.pair) == (Status.NO_CONTACT, (-1, -1))
        assert np.isnan(found.point).all()
    elif expected.min() == 0:
        assert found.status == Status.OVERLAPPING
        assert expected[found.pair] == 0
    else:
        assert found.status == Status.CONTACT
        assert found.pair == np.unravel_index(expected.argmin(), expected.shape)


def test_these_frames_have_all_outcomes():
    outcomes = [ccd.scene.first_contact(*frame(seed, shape=shape), running_bound=False).outcomes
                for seed in range(5) for shape in ("any", "needle", "plate", "sphere")]
    seen = np.bincount(np.ravel(outcomes), minlength=6)
    assert (seen[:5] > 5).all()
    assert seen[Outcome.UNRESOLVED] == 0


@settings(derandomize=True, deadline=None, max_examples=40)
@given(st.integers(0, 10**6), st.sampled_from(["any", "needle", "plate", "sphere"]))
def test_the_earliest_is_that_of_first_contact_of_each_pair(seed, shape):
    one, other = frame(seed, 4, shape)
    times = np.array([[ccd.first_contact(Ellipsoid(one.start.semi_axes[i]), one.motion(i), Ellipsoid(other.start.semi_axes[j]),
                                         other.motion(j)).time for j in range(4)] for i in range(4)])
    every = [ccd.scene.first_contact(one, other, planes=planes, running_bound=bound) for planes in (False, True) for bound in (False, True)]
    for found in every:
        assert found.time == pytest.approx(times.min(), abs=1e-11)
    np.testing.assert_allclose(every[0].times, times, rtol=0, atol=1e-11)
    swapped = ccd.scene.first_contact(other, one)
    assert swapped.time == pytest.approx(times.min(), abs=1e-9)


@pytest.mark.parametrize("interpolant", ["rigid", "affine"])
def test_groups_of_one_touch_on_both_surfaces(interpolant):
    contacts = 0
    for seed in range(60):
        rng = np.random.default_rng(seed)
        one, other = group(rng, 1, np.zeros(3), np.zeros(3), scale=1), group(rng, 1, np.array([5.0, 0, 0]), np.array([-4.0, 0, 0]), scale=1)
        found = ccd.scene.first_contact(one, other, interpolant)
        corners = [Ellipsoid(each.semi_axes[0], each.center[0], each.orientation[0])
                   for each in (one.start, one.end, other.start, other.end)]
        bodies = [Ellipsoid(corners[k].semi_axes) for k in (0, 2)]
        motions = ((ccd.interpolate_rigid(*corners[:2]), ccd.interpolate_rigid(*corners[2:])) if interpolant == "rigid"
                   else (ccd.Rest(), ccd.interpolate_affine(*corners)))
        alone = ccd.first_contact(bodies[0], motions[0], bodies[1], motions[1])
        assert (found.status, found.time) == (alone.status, pytest.approx(alone.time, abs=1e-11))
        if found.status == Status.CONTACT:
            contacts += 1
            pose = one.motion(0).matrix(found.time)
            local = pose[:3, :3].T @ (found.point - pose[:3, 3]) / one.start.semi_axes[0]
            assert np.linalg.norm(local) == pytest.approx(1, abs=1e-8)
            outward = pose[:3, :3] @ (local / one.start.semi_axes[0])
            np.testing.assert_allclose(found.normal, outward / np.linalg.norm(outward), rtol=0, atol=1e-6)
            assert found.pair == (0, 0)
    assert contacts > 10


def test_bodies_far_apart_are_all_left_out_by_their_spheres():
    one, other = frame(0)
    away = [ccd.Bodies(each.semi_axes, each.center + 1e6, each.orientation) for each in (other.start, other.end)]
    found = ccd.scene.first_contact(one, Group(*away))
    assert found.counts == (SIZE**2, SIZE**2, 0, 0, 0, 0)
    assert (found.status, found.time) == (Status.NO_CONTACT, np.inf)


def test_bad_groups_are_refused():
    one, other = frame(0)
    for wrong in (None, one.start, [1, 2]):
        with pytest.raises(ValueError, match="group_a"):
            ccd.scene.first_contact(wrong, other)
        with pytest.raises(ValueError, match="group_b"):
            ccd.scene.first_contact(one, wrong)
        if wrong is not one.start:
            with pytest.raises(ValueError, match=r"^start"):
                Group(wrong, one.end)
            with pytest.raises(ValueError, match=r"^end"):
                Group(one.start, wrong)
    for wrong in ("Rigid", None, 3):
        with pytest.raises(ValueError, match="interpolant"):
            ccd.scene.first_contact(one, other, wrong)
    with pytest.raises(ValueError, match="planes"):
        ccd.scene.first_contact(one, other, "affine", planes=True)
    larger = ccd.Bodies(2 * one.start.semi_axes, one.end.center, one.end.orientation)
    fewer = ccd.Bodies(one.start.semi_axes[:3], one.end.center[:3], one.end.orientation[:3])
    for end in (larger, fewer):
        with pytest.raises(ValueError, match=r"end\.semi_axes"):
            Group(one.start, end)
