"""Every invariant of the world after every single event, in small systems where mistakes show; and contacts by an independent check."""

from contextlib import nullcontext

import fluids
import independent
import numpy as np
import pytest
from cross_section import cross_section, some_of

import edmd
from edmd import state

EVENTS = [24, 300]           # of the cheap shapes, the second behind `validate`; a check of long and flat bodies costs ten times as much
CASES = {**{shape: (shape, 24, 0.45) for shape in fluids.SHAPES}, "needle": ((0.5, 0.5, 2.0), 24, 0.3), "plate": ((2.0, 2.0, 0.4), 32, 0.3)}


@pytest.mark.parametrize("events", some_of(EVENTS, EVENTS[:1]))
@pytest.mark.parametrize("case", CASES)
def test_after_every_collision(case, events):
    simulation = edmd.Simulation(fluids.fluid(*CASES[case], seed=12))
    for event in range(events if case in fluids.SHAPES else events // 4):
        simulation.run(collisions=1)
        assert simulation.collisions == event + 1
        simulation.verify()


@pytest.mark.parametrize("case", ["oblate", "triaxial", "plate"])
def test_between_collisions(case):
    """Also while bodies fly and lists are made anew."""
    simulation = edmd.Simulation(fluids.fluid(*CASES[case], seed=13)).run(collisions=100)
    span = simulation.time / 100 / 3.1
    for _ in range(12):
        simulation.run(time=span)
        simulation.verify()


@pytest.mark.parametrize(("case", "rate"), cross_section(["sphere", "oblate", "triaxial"], [0.02, 1.0, -0.3]))
def test_while_the_bodies_grow(case, rate):
    simulation = edmd.Simulation(fluids.fluid(CASES[case][0], 24, 0.40, seed=14))
    seen = []

    def look(view):
        if len(seen) < 30:
            view._simulation.verify()
        seen.append(view.packing_fraction)

    simulation.compress(rate, until_packing_fraction=0.5 if rate > 0 else 0.2, observers=[edmd.Observer(edmd.Every(collisions=1), look)])
    assert len(seen) > 10
    assert (np.diff(seen) * rate >= 0).all()
    simulation.verify()
    simulation.run(collisions=200)
    simulation.verify()


@pytest.mark.parametrize("case", ["sphere", "prolate", "triaxial"])
def test_near_jamming(case):
    """At a reduced pressure of 1e6 gaps are 1e-6 of a body: the lists, the predictions and the contacts still hold."""
    simulation = edmd.Simulation(fluids.fluid(CASES[case][0], 32, 0.45, seed=15))
    simulation.compress(0.05, until_pressure=1e6)
    for _ in range(8):
        simulation.run(collisions=17)
        simulation.verify()
        assert independent.smallest_scale(simulation.system) > 1 - 1e-11


@pytest.mark.parametrize("case", CASES)
def test_no_overlap_at_any_time(case):
    """By Perram and Wertheim's function in numpy, over all images, at times that have nothing to do with the events."""
    simulation = edmd.Simulation(fluids.fluid(*CASES[case], seed=16))
    smallest = []
    look = edmd.Observer(edmd.Every(time=0.0473), lambda view: smallest.append(independent.smallest_scale(view.system)))
    simulation.run(collisions=400, observers=[look])
    assert len(smallest) > 10
    assert min(smallest) > 1 - 1e-12
    assert min(smallest) < 1.02


def test_mixture_of_sizes_shapes_and_masses():
    """Spheres, needles and plates of unequal masses in one cell."""
    start = edmd.random_system((16, 8, 8), [(1, 1, 1), (0.4, 0.4, 2), (1.5, 1.2, 0.4)], 0.4, seed=4)
    masses = np.array([1.0, 0.1, 20.0])[start.species]
    start = edmd.thermalized(edmd.System(start.positions, start.orientations, start.semi_axes, start.box, masses=masses,
                                         species=start.species), 5)
    simulation = edmd.Simulation(start)
    translation, rotation = independent.energies(simulation.system)
    for _ in range(20):
        simulation.run(collisions=7)
        simulation.verify()
        assert independent.smallest_scale(simulation.system) > 1 - 1e-12
    after, turned = independent.energies(simulation.system)
    assert after + turned.sum() == pytest.approx(translation + rotation.sum(), rel=1e-12)
    assert abs(independent.momentum(simulation.system)).max() < 1e-12


def out_of_place(world):
    world.bodies[3, :3] += 0.3 * world.grid.box.diagonal() / 2


def out_of_the_lists(world):
    world.anchors[:, state.ANCHOR_MARGIN] *= 3


def out_of_order(world):
    world.calendar.time[0] += 1.0


def out_of_energy(world):
    world.clock[state.ENERGY] *= 1 + 1e-9


@pytest.mark.parametrize(("damage", "told"), [(out_of_place, "overlap"), (out_of_the_lists, "not listed"), (out_of_order, "calendar"),
                                              (out_of_energy, "account")])
def test_verify_sees_what_is_wrong(damage, told):
    """The check itself can fail."""
    simulation = edmd.Simulation(fluids.fluid("prolate", 24, 0.45, seed=12)).run(collisions=50)
    simulation.verify()
    damage(simulation._world)
    with pytest.raises(AssertionError, match=told):
        simulation.verify()


@pytest.mark.parametrize(("speed", "late", "seen"), [(1.0, 1e-14, False), (1.0, 1e-9, True), (1.0, 6.0, True),
                                                     (1e-9, 1e-3, False), (1e-9, 1.0, True)])
def test_verify_sees_a_prediction_that_is_late(speed, late, seen):
    """Two spheroids about to meet end to end; late by so little that they hardly overlap till then is rounding, by 6 they are through."""
    start = edmd.System([[2, 5, 5], [6.2, 5, 5]], [[1, 0, 0, 0]] * 2, [(2, 1, 1)] * 2, 20.0, velocities=[[speed, 0, 0], [-speed, 0, 0]])
    simulation = edmd.Simulation(start)
    lists = simulation._world.lists
    held = [entry for entry in lists.spans[:-1, state.BEGIN] if lists.numbers[entry, state.EVENT] < np.inf]
    lists.numbers[held, state.EVENT] = 0.1 / speed + late
    with pytest.raises(AssertionError, match="before its prediction") if seen else nullcontext():
        simulation.verify()
