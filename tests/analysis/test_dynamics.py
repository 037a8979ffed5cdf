import MDAnalysis as mda
import numpy as np
import pytest
import reference
from runs import random_quaternions, wrapped, write_run
from scipy.spatial.transform import Rotation

import analysis
from analysis import dynamics


def body_axes(q):
    """The third axis of each body, by scipy."""
    return Rotation.from_quat(q[..., [1, 2, 3, 0]].reshape(-1, 4)).as_matrix()[:, :, 2].reshape(*q.shape[:-1], 3)


# lags

def test_equal_intervals_give_one_group_for_each_lag():
    groups = analysis.time_lags(0.1 * np.arange(7) + 5)
    np.testing.assert_allclose([lag for lag, *_ in groups], 0.1 * np.arange(7), atol=1e-15)
    for k, (_, first, second) in enumerate(groups):
        assert sorted(zip(first, second)) == [(i, i + k) for i in range(7 - k)]


def test_unequal_intervals_give_each_lag_its_pairs():
    groups = analysis.time_lags([0.0, 1.0, 3.0, 4.0])
    assert [(lag, sorted(zip(first.tolist(), second.tolist()))) for lag, first, second in groups] == [
        (0.0, [(0, 0), (1, 1), (2, 2), (3, 3)]), (1.0, [(0, 1), (2, 3)]), (2.0, [(1, 2)]), (3.0, [(0, 2), (1, 3)]), (4.0, [(0, 3)])]
    assert [lag for lag, *_ in analysis.time_lags([0.0, 1.0, 3.0, 4.0], longest=2.0)] == [0.0, 1.0, 2.0]


def test_bins_put_lags_together():
    groups = analysis.time_lags([0.0, 1.0, 2.1, 3.0], bins=[0.5, 1.5, 2.5])
    assert [lag for lag, *_ in groups] == [pytest.approx((1 + 1.1 + 0.9) / 3), pytest.approx((2.1 + 2.0) / 2)]
    assert [len(first) for _, first, _ in groups] == [3, 2]


# displacements

def ballistic(tmp_path, times, n=50):
    """Free bodies in a skew cell that turn as they fly: path, velocities, axes at every time."""
    rng = np.random.default_rng(5)
    cell = np.array([[3.0, 0, 0], [1.2, 2.9, 0], [-0.7, 0.9, 3.1]])
    velocities = rng.normal(size=(n, 3))
    positions, images = wrapped(rng.random((n, 3)) @ cell + np.asarray(times)[:, None, None] * velocities, cell)
    turned = Rotation.from_rotvec((np.asarray(times)[:, None, None] * rng.normal(size=(n, 3))).reshape(-1, 3)).as_quat()
    q = turned[:, [3, 0, 1, 2]].reshape(len(times), n, 4)
    path = write_run(tmp_path / "run.h5md", positions, q, (0.3, 0.3, 0.6), cell, times, images=images, velocities=velocities)
    return path, velocities, body_axes(q)


@pytest.mark.parametrize(("times", "at_once"), [(0.25 * np.arange(20), dynamics.AT_ONCE), (0.25 * np.arange(20), 170),
                                                ([0.0, 0.3, 1.0, 1.7, 4.0], dynamics.AT_ONCE)])
def test_ballistic_flight_is_split_by_the_axis_at_the_start(tmp_path, monkeypatch, times, at_once):
    monkeypatch.setattr(dynamics, "AT_ONCE", at_once)
    path, velocities, axes = ballistic(tmp_path, times)
    results = analysis.MeanSquaredDisplacement(mda.Universe(path).atoms).run().results
    np.testing.assert_allclose(results.total, np.mean(np.sum(velocities**2, axis=1)) * results.lag**2, rtol=1e-9)
    for lag, found in zip(results.lag, results.parallel):
        starts = [i for i, t in enumerate(times) if np.isclose(np.asarray(times) - t, lag).any()]
        speed = np.mean([np.sum(velocities * axes[i], axis=1)**2 for i in starts])
        assert found == pytest.approx(speed * lag**2, rel=1e-9)
    np.testing.assert_allclose(results.perpendicular, results.total - results.parallel, rtol=1e-12)


def test_a_random_walk_is_isotropic_and_grows_as_the_time(tmp_path):
    rng = np.random.default_rng(9)
    n, frames = 400, 40
    positions = np.cumsum(0.3 * rng.normal(size=(frames, n, 3)), axis=0)
    axes = np.tile(body_axes(random_quaternions(rng, n)), (frames, 1, 1))
    lag, total, parallel, perpendicular = analysis.mean_squared_displacement(positions, axes, np.arange(frames))
    for value, directions in ((total, 3), (parallel, 1), (perpendicular, 2)):
        assert value[0] == 0
        sigma = np.sqrt(2 / (directions * n * (frames - lag[1:6]) / lag[1:6]))         # of a chi square; n (frames / lag) independent ones
        assert np.all(np.abs(value[1:6] / (0.09 * directions * lag[1:6]) - 1) < 4 * sigma)


def test_errors_are_what_means_of_other_bodies_differ_by(tmp_path):
    """Of many random walks in copies of a run: the spread of the means is the error, which each run tells by itself."""
    rng = np.random.default_rng(31)
    copies, n, frames = 30, 80, 12
    found = []
    for copy in range(copies):
        walk = np.cumsum(0.3 * rng.normal(size=(frames, n, 3)), axis=0)
        path = write_run(tmp_path / f"{copy}.h5md", walk, random_quaternions(rng, frames * n).reshape(frames, n, 4), (0.3, 0.3, 0.6),
                         99 * np.eye(3), np.arange(frames))
        universe = mda.Universe(path)
        moved, turned = analysis.MeanSquaredDisplacement(universe.atoms).run().results, \
            analysis.OrientationalCorrelation(universe.atoms).run().results
        found.append([[results[name], results[f"{name}_error"]] for results, names in
                      ((moved, ("total", "parallel", "perpendicular")), (turned, ("c1", "c2"))) for name in names])
        universe.trajectory.close()
    means, errors = np.moveaxis(found, 2, 0)[:, :, :, 1:]
    spread = means.std(axis=0, ddof=1)
    assert np.abs(np.sqrt(np.mean(errors**2, axis=0)) / spread - 1).max() < 4 / np.sqrt(2 * copies)


def test_one_body_has_no_error():
    lag, means, errors = dynamics.squared_displacements(np.arange(12.0).reshape(4, 1, 3), np.tile([0, 0, 1.0], (4, 1, 1)), np.arange(4),
                                                        None, None)
    assert np.isfinite(means).all()
    assert np.isnan(errors).all()
    assert len(lag) == 4


def test_einstein_msd_of_mdanalysis_agrees_in_its_precision(tmp_path):
    from MDAnalysis.analysis.msd import EinsteinMSD

    universe = mda.Universe(ballistic(tmp_path, 0.5 * np.arange(6))[0])
    ours = analysis.MeanSquaredDisplacement(universe.atoms).run().results
    universe.trajectory.add_transformations(analysis.unwrap)
    np.testing.assert_allclose(EinsteinMSD(universe, fft=False).run().results.timeseries, ours.total, rtol=1e-5, atol=1e-10)


# reorientation

def test_one_axis_that_turns_steadily():
    angle = 0.37 * np.arange(9)
    axes = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)[:, None]
    _, c1, c2 = analysis.orientational_correlation(axes, np.arange(9))
    np.testing.assert_allclose(c1, np.cos(angle), atol=1e-13)
    np.testing.assert_allclose(c2, 1.5 * np.cos(angle)**2 - 0.5, atol=1e-13)


@pytest.mark.parametrize("semi_axes", [(1.0, 1.0, 3.0), (1.0, 1.0, 1 / 3)])
def test_free_rotors_have_the_exact_correlation(tmp_path, semi_axes):
    """Torque-free spheroids at kT = 1: the axis precesses about L at |L| / I_perp. The exact average over Maxwell's law is the oracle's."""
    rng = np.random.default_rng(17)
    n, times = 6000, np.array([0.0, 0.4, 1.0, 1.8])
    a, _, c = semi_axes
    moments = np.array([a * a + c * c, a * a + c * c, 2 * a * a]) / 5
    start = Rotation.from_quat(random_quaternions(rng, n)[:, [1, 2, 3, 0]])
    momentum = start.apply(rng.normal(size=(n, 3)) * np.sqrt(moments))
    spin = (1 / moments[2] - 1 / moments[0]) * np.sum(momentum * start.apply([0, 0, 1.0]), axis=1)
    q = np.stack([(Rotation.from_rotvec(momentum / moments[0] * t) * start * Rotation.from_rotvec(spin[:, None] * [0, 0, t])).as_quat()
                  for t in times])[..., [3, 0, 1, 2]]
    path = write_run(tmp_path / "run.h5md", rng.random((n, 3)), q, semi_axes, np.eye(3) * 9, times)
    results = analysis.OrientationalCorrelation(mda.Universe(path).atoms, bins=[-0.1, 0.1, 0.5]).run().results
    np.testing.assert_allclose([results.c1[0], results.c2[0]], 1, atol=1e-12)
    lag, c1, c2 = analysis.orientational_correlation(body_axes(q)[[0, 2]], times[[0, 2]])
    assert lag.tolist() == [0.0, 1.0]
    for found, rank, t in ((results.c1[1], 1, 0.4), (results.c2[1], 2, 0.4), (c1[1], 1, 1.0), (c2[1], 2, 1.0)):
        assert abs(found - reference.free_rotor_C(semi_axes, rank, t)) < 4 / np.sqrt(n)         # neither rank can deviate by more than 1


def test_what_is_no_trajectory_is_refused():
    axes = np.tile([0, 0, 1.0], (3, 2, 1))
    for times in ([0.0, 1.0], [0.0, 1.0, 1.0], [2.0, 1.0, 0.0]):
        with pytest.raises(ValueError, match="times"):
            analysis.orientational_correlation(axes, times)
    with pytest.raises(ValueError, match="positions"):
        analysis.mean_squared_displacement(np.zeros((3, 2)), axes, [0.0, 1, 2])
    with pytest.raises(ValueError, match="axes"):
        analysis.mean_squared_displacement(np.zeros((3, 4, 3)), axes, [0.0, 1, 2])
    with pytest.raises(ValueError, match="no pair of frames"):
        analysis.orientational_correlation(axes, [0.0, 1, 2], bins=[7.0, 8.0])
