"""Regression cases: each was once a wrong answer, a hang or lost data."""

import h5py
import numpy as np
import pytest

import edmd


def fluid(**more):
    return edmd.lattice("fcc", (1, 1, 1.5), 0.3, (2, 2, 2), seed=1, **more)


def test_bodies_at_rest_are_not_asked_for_collisions():
    still = fluid()
    still.velocities[:] = still.angular_velocities[:] = 0
    with pytest.raises(ValueError, match=r"collisions = 10.*at rest"):
        edmd.Simulation(still).run(collisions=10)
    with pytest.raises(ValueError, match="less than one collision"):
        edmd.Simulation(fluid()).run(collisions=0.4)


def test_a_closed_trajectory_is_not_written_again(tmp_path):
    simulation = edmd.Simulation(fluid())
    with edmd.Trajectory(tmp_path / "run.h5md", edmd.Every(collisions=20)) as trajectory:
        simulation.run(collisions=100, observers=[trajectory])
    with pytest.raises(ValueError, match="closed"):
        simulation.run(collisions=100, observers=[trajectory])
    with h5py.File(tmp_path / "run.h5md") as file:
        assert len(file["particles/trajectory/position/step"]) == 6


def test_growth_faster_than_the_bodies_is_refused():
    with pytest.raises(ValueError, match=r"rate = 5.0.*at most 1.33"):
        edmd.Simulation(fluid()).compress(5.0, until_pressure=1e3)


def test_a_common_drift_changes_neither_temperature_nor_pressure():
    still, moving = fluid(), fluid()
    moving.velocities += (10.0, -3.0, 0.5)
    results = [edmd.Simulation(system).run(collisions=400).means for system in (still, moving)]
    assert results[1] == pytest.approx(results[0], rel=1e-6)
    assert results[1].temperature == pytest.approx(1)


def test_a_file_gives_the_moments_of_inertia_back(tmp_path):
    simulation = edmd.Simulation(fluid(inertia="sphere"))
    with edmd.Trajectory(tmp_path / "run.h5md") as trajectory:
        simulation.run(collisions=50, observers=[trajectory])
    back = edmd.read_system(tmp_path / "run.h5md")
    assert np.array_equal(back.moments, simulation.system.moments)
    assert edmd.Simulation(back).temperature == pytest.approx(1, rel=1e-12)


def test_semi_axes_equal_but_for_rounding_make_a_body_of_revolution():
    system = edmd.lattice("fcc", (0.1 + 0.2, 0.3, 1.0), 0.05, (2, 2, 2))
    assert np.array_equal(system.semi_axes[:, 0], system.semi_axes[:, 1])
    assert system.moments[0] == pytest.approx([(0.09 + 1) / 5, (0.09 + 1) / 5, 0.18 / 5])


def test_collisions_per_particle_keep_step_with_an_odd_number_of_bodies():
    simulation, seen = edmd.Simulation(edmd.random_system(37, (1, 1, 1), 0.2, seed=1)), []
    counter = edmd.Observer(edmd.Every(collisions_per_particle=1), lambda view: seen.append(view.collisions))
    simulation.run(collisions_per_particle=10, observers=[counter])
    assert seen == [19, 37, 56, 74, 93, 111, 130, 148, 167, 185]


def test_an_interval_too_short_to_be_told_is_refused():
    with pytest.raises(ValueError, match="too short"):
        edmd.Simulation(fluid()).run(time=1).run(time=1, observers=[edmd.Observer(edmd.Every(time=1e-18), print)])


def test_random_systems_of_any_size_are_made():
    for length in (1e-6, 1e6):
        assert edmd.random_system(32, (length, length, 1.5 * length), 0.3, seed=1).packing_fraction == pytest.approx(0.3, rel=1e-13)
