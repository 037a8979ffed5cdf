"""The same run in any units, at any age and in a cell of any size."""

import signal
from contextlib import contextmanager

import fluids
import independent
import numpy as np
import pytest
from cross_section import cross_section, some_of

import edmd
from edmd.state import ORIENTATION

SHAPES = list(fluids.SHAPES)
AGES = [100_000, 10_000_000]            # in collisions, the second behind `validate`


def scaled(system, length=1.0, mass=1.0, energy=1.0):
    """The same bodies in other units -> System, unit of time."""
    time = length * np.sqrt(mass / energy)
    return edmd.System(system.positions * length, system.orientations, system.semi_axes * length, system.box * length,
                       system.velocities * (length / time), system.angular_velocities / time, system.masses * mass,
                       species=system.species), time


def mixture():
    start = edmd.random_system((12, 10, 10), [(1, 1, 1), (0.5, 0.5, 1.5), (1.4, 1.1, 0.5)], 0.4, seed=3)
    heavy = edmd.System(start.positions, start.orientations, start.semi_axes, start.box, species=start.species,
                        masses=np.array([1.0, 0.125, 16.0])[start.species])
    return edmd.thermalized(heavy, 5)


def started(shape):
    return mixture() if shape == "mixture" else fluids.fluid(shape, 32, 0.4, seed=6)


def collisions(simulation, count):
    """(time, who) of each, and the end."""
    seen, before = [], simulation.system.velocities
    for _ in range(count):
        after = simulation.run(collisions=1).system.velocities
        seen.append((simulation.time, tuple(np.flatnonzero((after != before).any(axis=1)))))
        before = after
    return seen


@pytest.mark.parametrize(("shape", "units"), cross_section([*SHAPES, "mixture"], [
    {"length": 2.0**20}, {"length": 2.0**-20}, {"mass": 4.0**10}, {"mass": 4.0**-10}, {"energy": 4.0**10}, {"energy": 4.0**-10},
    {"length": 2.0**-13, "mass": 4.0**30, "energy": 4.0**-7}]), ids=str)
def test_units_that_are_powers_of_two_change_no_bit(shape, units):
    start = started(shape)
    other, unit = scaled(start, **units)
    a, b = edmd.Simulation(start), edmd.Simulation(other)
    a.run(collisions=1000)
    b.run(collisions=1000)
    assert b.time / unit == a.time
    length = units.get("length", 1.0)
    assert np.array_equal(b.system.positions / length, a.system.positions)
    assert np.array_equal(b.system.velocities * (unit / length), a.system.velocities)
    assert np.array_equal(b.system.orientations, a.system.orientations)


@pytest.mark.parametrize(("shape", "quantity", "factor"), cross_section([*SHAPES, "mixture"], ["length", "mass", "energy"], [1e6, 1e-6]))
def test_units_of_a_million_change_nothing_but_rounding(shape, quantity, factor):
    """Rounding parts two runs by a factor of a few a collision and body: the first fifty collisions are the same."""
    start = started(shape)
    other, unit = scaled(start, **{quantity: factor})
    a, b = edmd.Simulation(start), edmd.Simulation(other)
    one, two = collisions(a, 50), collisions(b, 50)
    assert [who for _, who in one] == [who for _, who in two]
    assert np.array([time for time, _ in two]) / unit == pytest.approx(np.array([time for time, _ in one]), rel=1e-9)
    unit_of_pressure = {"length": factor**-3, "mass": 1.0, "energy": factor}[quantity]
    assert b.pressure / unit_of_pressure == pytest.approx(a.pressure, rel=1e-7)
    b.verify()


@pytest.mark.parametrize("age", some_of(AGES, AGES[:1]), ids="{:.0e}".format)
@pytest.mark.parametrize("shape", SHAPES)
def test_an_old_run_goes_on_as_a_new_one(shape, age):
    """The state of a long run, handed to a new simulation whose clock is at 0: the same collisions at the same intervals."""
    old = edmd.Simulation(fluids.fluid(shape, 12, 0.3, seed=2))
    energy = old.energy
    old.run(collisions=age)
    state = old.system
    kept = old._world.bodies[:, ORIENTATION:ORIENTATION + 4]        # a System would make them unit
    assert abs((kept**2).sum(axis=1) - 1).max() < 1e-15
    assert abs(old.energy / energy - 1) < 1e-15 * np.sqrt(age) + 1e-18 * age
    assert abs(independent.momentum(state)).max() < 1e-15 * np.sqrt(age)

    new, began = edmd.Simulation(state), old.time
    one, two = collisions(old, 30), collisions(new, 30)
    assert [who for _, who in one] == [who for _, who in two]
    resolution = np.spacing(old.time)
    assert np.array([time for time, _ in one]) - began == pytest.approx(np.array([time for time, _ in two]), abs=1e-10 + 2 * resolution)
    assert old.system.velocities == pytest.approx(new.system.velocities, abs=1e-9)
    old.verify()


PAIR = {"sphere": (0.5, 0.5, 0.5), "prolate": (0.5, 0.5, 1.0), "plate": (1.0, 1.0, 0.1), "three axes": (1.0, 0.7, 0.4)}


def head_on(axes, edge, apart, offset):
    """Two bodies on their way to each other along the diagonal of the cell, side by side by `offset`, turning."""
    along = np.ones(3) / np.sqrt(3)
    across = np.array([1, -1, 0]) / np.sqrt(2)
    centre = np.full(3, 0.98 * edge)
    centers = [centre - apart / 2 * along, centre + apart / 2 * along + offset * across]
    turned, turning = [[0.5, 0.5, 0.1, 0.7], [0.2, -0.4, 1, 0.3]], [[0.3, 0.1, -0.2], [0.1, 0.2, 0.5]]
    return edmd.System(centers, turned, axes, edge, [along, -along], turning)


@contextmanager
def within(seconds):
    """TimeoutError for what takes longer; a run gives Python control back every million events."""
    def give_up(*_):
        raise TimeoutError(f"not done within {seconds} s")
    before = signal.signal(signal.SIGALRM, give_up)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


@pytest.mark.parametrize("edge", [1e2, 1e3, 1e4])
@pytest.mark.parametrize("shape", PAIR)
def test_a_contact_in_a_wide_cell(shape, edge):
    """A position is known to 1e-16 of the cell: the contact is found to some fifty times that, as in a small cell, and is no overlap."""
    for offset in (0.03, 0.06, 0.12, 0.15, 0.3):
        with within(2):
            small, large = (edmd.Simulation(head_on(PAIR[shape], width, 6.0, offset)).run(collisions=1) for width in (20.0, edge))
        assert large.time == pytest.approx(small.time, abs=1e-14 * edge)
        assert large.system.velocities == pytest.approx(small.system.velocities, abs=1e-13 * edge)
        assert abs(independent.smallest_scale(large.system) - 1) < 1e-14 * edge
        assert abs(independent.smallest_scale(small.system) - 1) < 1e-13
        large.verify()


@pytest.mark.parametrize("shape", PAIR)
def test_a_contact_in_a_wide_cell_at_an_early_time(shape):
    """Time is known far better than positions then: steps that move no body must not go on for ever."""
    edge, before = 1e4, 1e-3
    for offset in np.linspace(0.02, 0.3, 15):
        start = head_on(PAIR[shape], 20.0, 6.0, offset)
        contact = edmd.Simulation(start).run(collisions=1).time
        bodies, images = edmd.Simulation(start).run(time=contact - before).synchronised()
        large = edmd.Simulation(edmd.System(bodies.positions + images @ bodies.box + 0.98 * (edge - 20), bodies.orientations, PAIR[shape],
                                            edge, bodies.velocities, bodies.angular_velocities))
        with within(2):
            large.run(collisions=1)
        assert large.time == pytest.approx(before, abs=1e-14 * edge)
        assert abs(independent.smallest_scale(large.system) - 1) < 1e-14 * edge
        large.verify()


def test_spheres_that_meet_after_thousands_of_diameters():
    """A quadratic has the answer; the flight goes through a face of the cell."""
    apart, offset = 5000.0, 0.6
    with within(2):
        simulation = edmd.Simulation(head_on((0.5, 0.5, 0.5), 1e4, apart, offset)).run(collisions=1)
    # on the way the body is moved thousands of times, each to the 2e-12 to which a position is known in this cell
    assert simulation.time == pytest.approx((apart - np.sqrt(1 - offset**2)) / 2, abs=1e-8)
    simulation.verify()
