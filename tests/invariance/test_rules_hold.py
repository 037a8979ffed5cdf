"""Under every rule: every invariant after every collision, restart bit for bit, and looking changes nothing."""

import fluids
import granular
import independent
import numpy as np
import pytest
from cross_section import cross_section
from test_restart_is_exact import assert_same

import edmd
from edmd import state

SHAPES = ("sphere", "prolate", "triaxial")
RULES = {**{name: granular.RULES[name] for name in ("inelastic", "viscoelastic", "power law", "rough")},
         "rough, TC": edmd.Rough(0.8, 0.2, contact_share=0.01), "inelastic, TC": edmd.Inelastic(0.6, contact_time=1e-3)}


def gas(rule, shape="prolate", n=32, packing_fraction=0.4):
    return edmd.Simulation(fluids.fluid(shape, n, packing_fraction, seed=6), rule=RULES[rule])


@pytest.mark.parametrize(("rule", "shape"), cross_section(RULES, SHAPES))
def test_after_every_collision(rule, shape):
    simulation = gas(rule, shape, 24)
    start = independent.momentum(simulation.system)
    for _ in range(15):
        simulation.run(collisions=1)
        simulation.verify()
    assert independent.momentum(simulation.system) == pytest.approx(start, abs=1e-13)
    simulation.run(collisions=400).verify()
    assert simulation.temperature < 0.9


@pytest.mark.parametrize(("rule", "shape", "rate"), cross_section(["inelastic", "rough"], SHAPES, [0.1, -0.2], together=2))
def test_while_the_bodies_grow(rule, shape, rate):
    """The work of the surfaces and the loss are both accounted for, tangential impulses and moments of inertia that grow included."""
    simulation, seen = gas(rule, shape, 24), []

    def look(view):
        if len(seen) % 5 == 0:
            view._simulation.verify()
        seen.append(view.energy)

    simulation.compress(rate, until_packing_fraction=0.45 if rate > 0 else 0.3, observers=[edmd.Observer(edmd.Every(collisions=1), look)])
    assert len(seen) > 20
    assert simulation.temperature == pytest.approx(1, abs=1e-12)
    simulation.run(collisions=100).verify()


@pytest.mark.parametrize(("rule", "shape"), cross_section(RULES, SHAPES))
def test_restart(rule, shape, tmp_path):
    simulation = gas(rule, shape).run(collisions=333)
    simulation.save(tmp_path / "state")
    loaded = edmd.Simulation.load(tmp_path / "state")
    assert loaded.rule == simulation.rule
    assert_same(loaded, simulation)
    for each in (loaded, simulation):
        each.run(collisions=200).compress(0.05, until_packing_fraction=0.43).run(time=0.3)
    assert_same(loaded, simulation)
    assert loaded.contact_time_collisions == simulation.contact_time_collisions


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize(("rule", "collisions"), [("rough, TC", 900), ("inelastic, TC", 900), ("inelastic", 300)])
def test_looking_changes_nothing(rule, collisions, shape):
    """An inelastic gas without a contact time for a while only: one in ten has collapsed within 900 collisions."""
    plain, watched, seen = gas(rule, shape).run(collisions=collisions), gas(rule, shape), []
    watched.run(collisions=collisions, observers=[edmd.Observer(edmd.Every(collisions=23), lambda view: seen.append(view.system))])
    assert len(seen) > collisions // 25
    assert independent.same_bits(plain.system, watched.system)


def test_a_burst_of_collisions_does_not_set_the_pace():
    """A growth that began just after one took 58 000 events a collision: bounds looked ahead a millionth of the mean free time."""
    simulation = gas("viscoelastic").run(collisions=533).compress(0.05, until_packing_fraction=0.43)
    assert simulation._world.tally[state.EVENTS] < 300 * simulation.collisions


@pytest.mark.parametrize("axes", [(0.5, 0.5, 0.5), (1, 1, 2.0)])
def test_epochs_of_a_dilute_gas_are_whole(axes):
    """Though it makes a thousand lists a collision: only looks at pairs tell that bounds do not look far enough."""
    simulation = edmd.Simulation(edmd.random_system(24, axes, 1e-3, seed=1)).run(collisions=150)
    assert simulation._last.collisions == 4 * 24


@pytest.mark.parametrize("axes", [(1, 1, 2.0), (1, 1, 0.5), (1, 1, 1.0)])
def test_rough_bodies_turn_as_their_angular_velocities_say(axes):
    """Orientations between collisions, spin about the axis included, against small steps of dq/dt = w q / 2."""
    simulation = edmd.Simulation(fluids.fluid(axes, 24, 0.3, seed=6), rule=edmd.Rough(0.9, 0.5)).run(collisions=150)
    step, turned = 2e-6, []
    for _ in range(20):
        first, count = simulation.system, simulation.collisions
        last = simulation.run(time=step).system
        if simulation.collisions == count:
            frames = [independent.rotation_matrices(state.orientations) for state in (first, last)]
            rate = np.einsum("nij,nkj->nik", frames[1] - frames[0], frames[0]) / step
            turned.append(abs(np.stack([rate[:, 2, 1], rate[:, 0, 2], rate[:, 1, 0]], axis=1) - first.angular_velocities).max())
        simulation.run(collisions=7)
    assert len(turned) > 10
    assert max(turned) < 1e-4


@pytest.mark.parametrize("axes", [(1, 1, 2.0), (0.5, 1, 1)])
def test_no_orientation_jumps_when_rough_bodies_collide(axes, tmp_path):
    """A collision changes the spin about the axis; the angle goes on from where it was, over upkeeps too."""
    simulation = edmd.Simulation(fluids.fluid(axes, 24, 0.3, seed=6), rule=edmd.Rough(0.9, 0.5)).run(collisions=60)
    spins = []
    for _ in range(10):
        simulation.save(tmp_path / "state")
        began = simulation.time
        after = simulation.run(collisions=1).system
        before = edmd.Simulation.load(tmp_path / "state").run(time=(simulation.time - began) * (1 - 1e-9)).system
        frames = [independent.rotation_matrices(state.orientations) for state in (before, after)]
        assert abs(frames[1] - frames[0]).max() < 1e-8
        spins.append(abs(independent.body_spin(after) - independent.body_spin(before)).max(axis=0))
    assert (np.max(spins, axis=0) > 0.01).all(), "no spin about the axis has changed: this test would see nothing"


def test_spheres_that_are_smooth_keep_their_spin_and_rough_ones_do_not():
    start = fluids.fluid("sphere", 24, 0.4, seed=6)
    for rule, changes in ((edmd.Inelastic(0.9), False), (edmd.Rough(0.9, 0.5), True)):
        end = edmd.Simulation(start, rule=rule).run(collisions=100).system
        assert (abs(end.angular_velocities - start.angular_velocities).max() > 1e-12) == changes
