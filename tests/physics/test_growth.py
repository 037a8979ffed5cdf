"""Growing bodies do work: dE/dt = 3 (Z - 1) N kT (ds/dt) / s (physics.md 1.12)."""

import fluids
import independent
import numpy as np
import pytest
import reference

import edmd


@pytest.mark.parametrize("shape", ["sphere", "prolate", "oblate", "triaxial"])
def test_energy_gained_is_the_work_of_the_measured_pressure(shape):
    """In fewer collisions than an upkeep interval, so that nothing is rescaled on the way: energy by numpy, Z by the engine."""
    start = fluids.fluid(shape, 256, 0.40, seed=3)
    moments = independent.solid_moments(start.semi_axes, start.masses)
    simulation = edmd.Simulation(start)
    seen = []

    def look(view):
        translation, rotation = independent.energies(view.system, moments)
        seen.append((view.time, view.collisions, translation + rotation.sum()))

    rate, span = 1e-4, 20
    first = sum(np.hstack(independent.energies(simulation.system, moments)))
    temperature = simulation.temperature
    target = start.packing_fraction * (1 + rate * span / simulation.run(collisions_per_particle=4).collision_rate * 0.1)**3
    began = simulation.time
    simulation.compress(rate, until_packing_fraction=target, observers=[edmd.Observer(edmd.Every(collisions=1), look)])
    assert temperature == pytest.approx(1, abs=1e-12)
    assert seen[-1][1] - seen[0][1] < 4 * 256 - 200, "an upkeep came in between"
    elapsed = simulation.time - began
    virial = 3 * (simulation.compressibility_factor - 1) * 256 * simulation.means.temperature * elapsed
    size = 1 + rate * elapsed / 2
    assert seen[-1][2] - first == pytest.approx(rate / size * virial, rel=1e-3)
    assert seen[-1][2] > first


def test_slow_growth_is_reversible_and_its_pressure_that_of_equilibrium():
    """Slow growth of hard spheres from 0.38 to 0.42: over the whole course the work is that of the equation of state, within 1%."""
    n, rate = 500, 1e-3
    simulation = edmd.Simulation(fluids.fluid((0.5, 0.5, 0.5), n, 0.38, seed=3))
    simulation.run(collisions_per_particle=50)
    rows = []

    class Work(edmd.Observer):
        def upkeep(self, view):
            rows.append((view.interval.time, view.means.temperature, view.means.reduced_pressure, view.packing_fraction))

    simulation.compress(rate, until_packing_fraction=0.42, observers=[Work(edmd.Every(time=1e300))])
    time, temperature, pressure, packing_fraction = np.array(rows).T
    # velocities are brought to kT = 1 at the start of every interval: its mean temperature is 1 + (dT/dt) time / 2
    size = np.cbrt(packing_fraction / 0.38)
    gained = (2 * (temperature - 1) / temperature)[1:].sum() * (3 * n - 3) / 2
    expected = (3 * (reference.Z_KLM(packing_fraction) - 1) * n * rate / size * time)[1:].sum()
    assert gained == pytest.approx(expected, rel=0.02)
    assert (pressure * time).sum() / time.sum() == pytest.approx((reference.Z_KLM(packing_fraction) * time).sum() / time.sum(), rel=0.01)
    assert simulation.temperature == pytest.approx(1, abs=1e-12)
