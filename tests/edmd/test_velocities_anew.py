"""Velocities rescaled or drawn anew in the middle of a run."""

import fluids
import independent
import numpy as np
import pytest
from cross_section import cross_section

import edmd

RULES = {"elastic": edmd.Elastic(), "inelastic": edmd.Inelastic(0.9), "rough": edmd.Rough(0.9, 0.5)}
CHANGES = {"rescaled": lambda simulation: simulation.rescale(2.5), "thermalized": lambda simulation: simulation.thermalize(2.5, seed=8)}


def mixture():
    return edmd.random_system((20, 12), [(1, 1, 2.0), (0.8, 0.6, 0.5)], 0.35, seed=5, masses=2.5)


def aged(shape="prolate", rule="elastic"):
    start = mixture() if shape == "mixture" else fluids.fluid(shape, 32, 0.4)
    return edmd.Simulation(edmd.thermalized(start, 3, spin="counted" if rule == "rough" else "drawn"), rule=RULES[rule]).run(collisions=333)


@pytest.mark.parametrize(("change", "shape", "rule"), cross_section(CHANGES, [*fluids.SHAPES, "mixture"], RULES))
def test_the_temperature_is_the_wanted_one_and_the_run_goes_on(change, shape, rule):
    simulation = aged(shape, rule)
    before, time = simulation.system, simulation.time
    assert CHANGES[change](simulation) is simulation
    assert simulation.temperature == pytest.approx(2.5, rel=1e-12)
    assert (simulation.time, simulation.collisions) == (time, 333)
    simulation.verify()
    after = simulation.system
    assert np.array_equal(after.positions, before.positions)
    assert np.abs(after.orientations - before.orientations).max() < 1e-14
    assert abs(independent.momentum(after)).max() < 1e-12
    simulation.run(collisions=200).verify()
    if rule == "elastic":
        assert simulation.temperature == pytest.approx(2.5, rel=1e-11)


def test_rescaling_multiplies_energy_and_momentum():
    """A common drift is a momentum, and no temperature; spin about the symmetry axis is neither."""
    start = fluids.fluid("oblate", 32, 0.4)
    start.velocities += (2.0, 0.5, -1.0)
    simulation = edmd.Simulation(start).run(collisions=100)
    before, factor = simulation.system, np.sqrt(0.01 / simulation.temperature)
    after = simulation.rescale(0.01).system
    assert after.velocities == pytest.approx(factor * before.velocities, abs=1e-14)
    u = independent.rotation_matrices(after.orientations)[:, :, fluid_axis(after)]
    along, was = ((one.angular_velocities * u).sum(axis=1) for one in (after, before))
    assert along == pytest.approx(was, abs=1e-12)
    across = after.angular_velocities - along[:, None] * u
    assert across == pytest.approx(factor * (before.angular_velocities - was[:, None] * u), abs=1e-12)
    simulation.run(collisions=500)
    assert simulation.temperature == pytest.approx(0.01, rel=1e-11)
    simulation.verify()


def fluid_axis(system):
    a = system.semi_axes[0]
    return next(k for k in range(3) if a[k - 1] == a[k - 2])


def test_the_same_collisions_in_another_time():
    """Without spin about the axes a rescaled run is the old one, slower: the same pairs, times longer by the factor."""
    start = edmd.thermalized(fluids.fluid("prolate", 24, 0.4), 2, spin="none")
    a, b = edmd.Simulation(start), edmd.Simulation(start).rescale(1e-4)
    a.run(collisions=60)
    b.run(collisions=60)
    assert b.time == pytest.approx(100 * a.time, rel=1e-6)
    assert 100 * b.system.velocities == pytest.approx(a.system.velocities, abs=1e-5)


def test_drawn_velocities_are_maxwellian_and_of_the_seed():
    simulation = edmd.Simulation(fluids.fluid("triaxial", 256, 0.3), seed=4).run(collisions=500)
    a, b, c = (simulation.thermalize(1.0, seed=seed).system for seed in (1, 1, 2))
    assert np.array_equal(a.velocities, b.velocities)
    assert not np.array_equal(a.velocities, c.velocities)
    default = simulation.thermalize().system
    assert np.array_equal(default.velocities, simulation.thermalize(1.0, seed=4).system.velocities)
    translation, rotation = independent.energies(c)
    assert np.hstack([translation, rotation.sum()]).sum() == pytest.approx(0.5 * (6 * 256 - 3), rel=1e-12)
    assert rotation == pytest.approx(128 * np.ones(3), rel=0.4)


@pytest.mark.parametrize("change", CHANGES)
def test_restart_and_repeat(change, tmp_path):
    a, b = aged("mixture"), aged("mixture")
    CHANGES[change](a).save(tmp_path / "state")
    CHANGES[change](b)
    loaded = edmd.Simulation.load(tmp_path / "state")
    for one in (a, b, loaded):
        one.run(collisions=300)
    assert a.time == b.time == loaded.time
    assert independent.same_bits(a.system, b.system)
    assert independent.same_bits(a.system, loaded.system)


def test_bodies_at_rest_can_be_thermalized_but_not_rescaled():
    still = fluids.fluid("prolate", 32, 0.4)
    still.velocities[:] = still.angular_velocities[:] = 0
    simulation = edmd.Simulation(still)
    with pytest.raises(ValueError, match=r"at rest.*thermalize"):
        simulation.rescale(1.0)
    assert simulation.run(time=2.0).thermalize().run(collisions=400).temperature == pytest.approx(1, rel=1e-12)
    simulation.verify()


@pytest.mark.parametrize("temperature", [0, -1, np.nan, np.inf, "warm", None])
def test_only_a_positive_temperature(temperature):
    simulation = aged()
    before = simulation.system
    for change in (simulation.rescale, simulation.thermalize):
        with pytest.raises(ValueError, match=r"^temperature"):
            change(temperature)
    assert independent.same_bits(simulation.system, before)


def test_numbers_of_the_last_run_stay():
    simulation = aged()
    pressure, rate = simulation.pressure, simulation.collision_rate
    simulation.rescale(7.0)
    assert (simulation.pressure, simulation.collision_rate) == pytest.approx((pressure, rate), rel=1e-12)
