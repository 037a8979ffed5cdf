"""The microcanonical laws of a fluid in equilibrium (physics.md 1.9, 1.10): how the energy is shared, and how velocities are spread."""

import fluids
import independent
import numpy as np
import pytest
import reference

import edmd

SIGMAS = 4
SHAPES = {"prolate": ((1, 1, 2.0), [0, 1]), "oblate": ((1, 1, 0.5), [0, 1]), "triaxial": ((1.25, 1, 0.8), [0, 1, 2])}


def sampled(semi_axes, active, n=256, blocks=30, samples=10):
    """Energies (block, sample, [translation, each active principal axis]) along a run in equilibrium, and the fourth moments of v.

    A block is 80 collisions a body: of 20, the axes of a body that is nearly round remember the one before.
    """
    simulation = edmd.Simulation(fluids.fluid(semi_axes, n, 0.4, seed=2))
    simulation.run(collisions_per_particle=60)
    energy, fourth = np.empty((blocks, samples, 1 + len(active))), np.empty((blocks, samples))
    for block, sample in np.ndindex(blocks, samples):
        system = simulation.run(collisions_per_particle=8).system
        translation, rotation = independent.energies(system)
        energy[block, sample] = [translation, *rotation[active]]
        fourth[block, sample] = (system.velocities**4).mean() / (system.velocities**2).mean()**2
    return energy, fourth


@pytest.mark.parametrize("shape", SHAPES)
def test_energy_is_shared_as_the_beta_law_says(shape):
    semi_axes, active = SHAPES[shape]
    energy, fourth = sampled(semi_axes, active)
    n = 256
    total = energy.sum(axis=2)
    share = energy[:, :, 1:].sum(axis=2) / total

    expected, spread = reference.rot_fraction_mean_std(n, semi_axes)
    mean, error = independent.block_mean(share.mean(axis=1))
    assert abs(mean - expected) < SIGMAS * error
    assert error < 0.1 * expected
    assert share.std() == pytest.approx(spread, rel=0.25)

    translational = 2 * energy[:, :, 0] / (3 * n - 3)
    rotational = 2 * energy[:, :, 1:].sum(axis=2) / (n * len(active))
    difference, error = independent.block_mean((translational - rotational).mean(axis=1))
    assert abs(difference) < SIGMAS * error

    # every active principal axis has its share: none is left out, none counted twice
    for k in range(1, 1 + len(active)):
        each, error = independent.block_mean((2 * energy[:, :, k] / n).mean(axis=1))
        assert abs(each - 1) < SIGMAS * error + 0.003

    kurtosis, error = independent.block_mean(fourth.mean(axis=1))
    assert abs(kurtosis - reference.kurtosis_micro(n, semi_axes)) < max(SIGMAS * error, 0.03)


def test_rotation_that_starts_cold_warms_up_at_the_rate_of_kinetic_theory():
    """Dilute prolate 1:1:2 with T_rot = 0: dE_rot/dt per particle is n x 20.7438 kT (physics.md section 2)."""
    n, packing_fraction, steps = 1024, 0.01, 12
    axes = np.array([1, 1, 2.0])
    density = packing_fraction / (4 * np.pi / 3 * axes.prod())
    rate = density * reference.dilute(axes, Ttr=1.0, Trot=1e-12)["rates"](1.0)[1]
    assert rate / density == pytest.approx(20.7438, rel=1e-4)
    slopes = []
    for seed in range(4):
        start = fluids.fluid((1, 1, 2.0), n, packing_fraction, seed=seed)
        start.angular_velocities[:] = 0.0
        start.velocities *= np.sqrt((3 * n - 3) / (start.velocities**2).sum())
        simulation = edmd.Simulation(start)
        horizon = 0.05 / rate
        times, warm = [0.0], [0.0]
        for _ in range(steps):
            system = simulation.run(time=horizon / steps).system
            times.append(simulation.time)
            warm.append(independent.energies(system)[1][:2].sum() / n)
        # E_rot = rate t (1 - c t): the slope at the start from a fit of a parabola through the origin
        t = np.array(times[1:])
        slopes.append(np.linalg.lstsq(np.stack([t, t**2], axis=1), np.array(warm[1:]), rcond=None)[0][0])
    mean, error = independent.block_mean(slopes)
    # density corrections: Z at 0.01 for 1:1:2 raises the contact value by a few per cent
    assert abs(mean / rate - 1.03) < 0.03 + SIGMAS * error / rate
