import h5py
import numpy as np
import pytest
from runs import fcc, write_run

import analysis

POSITIONS, CELL = fcc(1)
NAMES = ("pressure", "reduced_pressure", "temperature", "collision_rate")


def correlated(rng, m, memory):
    """Values with mean 0 and deviation 1, of which neighbours have the correlation `memory`: the error of their mean is known."""
    x = np.empty(m)
    x[0] = rng.normal()
    for k in range(1, m):
        x[k] = memory * x[k - 1] + np.sqrt(1 - memory**2) * rng.normal()
    return x, np.sqrt((1 + memory) / (1 - memory) / m)


# errors by blocks

@pytest.mark.parametrize("memory", [0.0, 0.6, 0.9])
def test_the_error_counts_the_correlation(memory):
    rng = np.random.default_rng(4)
    series = [correlated(rng, 4000, memory) for _ in range(12)]
    found = np.array([analysis.block_error(values) for values, _ in series])
    assert found.mean() == pytest.approx(series[0][1], rel=0.15)
    columns = analysis.block_error(np.stack([values for values, _ in series], axis=1))
    np.testing.assert_allclose(columns, found, rtol=1e-12)


def test_the_error_holds_as_often_as_one_sigma_should():
    rng = np.random.default_rng(5)
    series = [correlated(rng, 1000, 0.5)[0] for _ in range(100)]
    within = sum(abs(values.mean()) < analysis.block_error(values) for values in series)
    assert abs(within - 68) < 4 * np.sqrt(100 * 0.68 * 0.32)


def test_what_does_not_move_has_no_error_and_what_is_too_short_none_that_is_known():
    assert analysis.block_error(np.full(50, 3.0)) == 0
    assert np.isnan(analysis.block_error([1.0, 2.0]))
    assert np.isnan(analysis.block_error([1.0]))
    assert np.isnan(analysis.block_error(np.arange(100.0)))                  # a drift: no block is long enough
    with pytest.raises(ValueError, match="values"):
        analysis.block_error([1.0, np.nan])


def test_a_weighted_mean_is_that_of_all_single_values():
    rng = np.random.default_rng(6)
    numbers = rng.integers(1, 9, 500)
    values = [rng.normal(2.0, 1.0, k) for k in numbers]
    mean, error = analysis.weighted_mean([v.sum() for v in values], numbers)
    assert mean == pytest.approx(np.concatenate(values).mean(), abs=1e-13)
    assert error == pytest.approx(1 / np.sqrt(numbers.sum()), rel=0.4)
    assert np.isnan(analysis.weighted_mean(np.zeros(9), np.zeros(9))).all()


# a run

def write(path, durations, begun=10.0, packing_fraction=0.4, **series):
    m = len(durations)
    log = {name: np.ones(m) for name in NAMES} | series
    log |= {"time": begun + np.cumsum(durations), "collisions": np.arange(m), "packing_fraction": np.broadcast_to(packing_fraction, m)}
    return write_run(path, POSITIONS, [1, 0, 0, 0], (0.4, 0.4, 0.4), CELL, [begun], log=log)


def test_intervals_count_by_their_length(tmp_path):
    rng = np.random.default_rng(1)
    durations, pressure = rng.uniform(0.5, 2.0, 200), rng.normal(5.0, 0.1, 200)
    path = write(tmp_path / "run.h5md", durations, pressure=pressure, reduced_pressure=2 * pressure)
    means = analysis.mean_pressure(path)
    assert set(means) == set(NAMES)
    assert means["pressure"][0] == pytest.approx(np.average(pressure, weights=durations), rel=1e-13)
    assert means["pressure"][1] == pytest.approx(0.1 / np.sqrt(200), rel=0.5)
    assert means["reduced_pressure"] == pytest.approx([2 * value for value in means["pressure"]], rel=1e-12)
    assert means["temperature"] == (1.0, 0.0)


def test_what_lies_between_start_and_stop_counts(tmp_path):
    path = write(tmp_path / "run.h5md", np.ones(100), pressure=np.where(np.arange(100) < 30, 9.0, 5.0))      # 30 intervals to settle
    assert analysis.mean_pressure(path)["pressure"][0] == pytest.approx(6.2)
    assert analysis.mean_pressure(path, start=40.0)["pressure"] == (5.0, 0.0)
    assert analysis.mean_pressure(path, start=39.5)["pressure"] == (5.0, 0.0)                                # that interval begins before
    assert analysis.mean_pressure(path, start=39.0)["pressure"][0] > 5
    assert analysis.mean_pressure(path, stop=40.0)["pressure"] == (9.0, 0.0)


def test_a_compression_has_no_equilibrium(tmp_path):
    path = write(tmp_path / "run.h5md", np.ones(50), packing_fraction=np.r_[np.linspace(0.3, 0.5, 20), np.full(30, 0.5)])
    with pytest.raises(ValueError, match=r"packing fraction .* goes from 0.3 to 0.5"):
        analysis.mean_pressure(path)
    assert analysis.mean_pressure(path, start=30.0)["pressure"] == (1.0, 0.0)
    with pytest.raises(ValueError, match="no interval"):
        analysis.mean_pressure(path, start=100.0)


def test_hard_spheres_as_edmd_writes_them(tmp_path):
    """Carnahan and Starling, J. Chem. Phys. 51, 635 (1969), within the error that is found, and the run's own mean."""
    import edmd

    simulation = edmd.Simulation(edmd.lattice("fcc", (0.5, 0.5, 0.5), 0.3, cells=(5, 5, 5), seed=2))
    simulation.run(collisions_per_particle=50)
    with edmd.Trajectory(tmp_path / "run.h5md") as trajectory:
        simulation.run(collisions_per_particle=600, observers=[trajectory])
    mean, error = analysis.mean_pressure(tmp_path / "run.h5md")["reduced_pressure"]
    assert mean == pytest.approx(simulation.compressibility_factor, rel=2e-3)
    eta = 0.3
    assert abs(mean - (1 + eta + eta**2 - eta**3) / (1 - eta)**3) < 4 * error
    assert 1e-4 < error < 0.03
    with h5py.File(tmp_path / "run.h5md") as file:
        assert len(file["edmd/log/time"]) > 10
