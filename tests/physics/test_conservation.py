"""Elastic smooth bodies: energy, momentum and the spin of every spheroid about its axis are constants of the motion."""

import fluids
import independent
import numpy as np
import pytest

import edmd

CASES = {"prolate": ((1, 1, 2.0), 0.45), "triaxial": ((1.25, 1, 0.8), 0.5), "sphere": ((1, 1, 1.0), 0.45)}
VERSIONS = [pytest.param(200_000, id="2e5"), pytest.param(1_000_000, id="1e6", marks=pytest.mark.validate)]
BLOCKS = 10


def states(shape, collisions):
    """Synchronised states at equal numbers of collisions along a run, the start first."""
    semi_axes, packing_fraction = CASES[shape]
    simulation = edmd.Simulation(fluids.fluid(semi_axes, 128, packing_fraction, seed=11))
    seen = [simulation.system]
    for _ in range(BLOCKS):
        simulation.run(collisions=collisions // BLOCKS)
        seen.append(simulation.system)
    assert simulation.collisions == collisions
    return seen


@pytest.mark.parametrize("collisions", VERSIONS)
@pytest.mark.parametrize("shape", CASES)
def test_energy_and_momentum_stay(shape, collisions):
    seen = states(shape, collisions)
    energy = np.array([translation + rotation.sum() for translation, rotation in map(independent.energies, seen)])
    error = energy / energy[0] - 1
    assert abs(error).max() < 1e-12
    # no growth beyond the random walk of rounding: 128 bodies of energy 1/128 each, half a unit in the last place a collision
    # and the bias of the last place of the effective mass, 1e-19 a collision
    assert abs(error).max() < 10 * 1.1e-16 / 128 * np.sqrt(collisions) + 3e-14 + 2e-19 * collisions
    typical = np.sqrt((seen[0].velocities**2).sum())
    for state in seen:
        assert abs(independent.momentum(state)).max() < 1e-12 * typical


@pytest.mark.parametrize(("semi_axes", "axis"), [((1, 1, 2.0), 2), ((1, 1, 0.5), 2), ((2.0, 1, 1), 0), ((1, 0.6, 1), 1)])
def test_spin_of_a_spheroid_about_its_axis_never_changes(semi_axes, axis):
    simulation = edmd.Simulation(fluids.fluid(semi_axes, 64, 0.4, seed=5))
    before = independent.body_spin(simulation.system)
    simulation.run(collisions=30_000)
    after = independent.body_spin(simulation.system)
    assert abs(after[:, axis] - before[:, axis]).max() < 1e-12 * abs(before[:, axis]).max()
    across = [k for k in range(3) if k != axis]
    assert (abs(after[:, across] - before[:, across]).max(axis=1) > 1e-3).all(), "nothing has turned: this test would see nothing"


def test_rotation_of_spheres_never_changes():
    start = fluids.fluid("sphere", 64, 0.4, seed=5)
    assert abs(start.angular_velocities).max() > 0
    end = edmd.Simulation(start).run(collisions=20_000).system
    assert abs(end.angular_velocities - start.angular_velocities).max() < 1e-12
