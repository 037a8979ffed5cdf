"""What physics says must not matter: where the origin lies, which units are used, the direction of time, how the cell is described."""

import fluids
import independent
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import edmd

SHAPES = list(fluids.SHAPES)


def changed(system, **arrays):
    """The same system with some arrays replaced."""
    names = ("positions", "orientations", "semi_axes", "box", "velocities", "angular_velocities", "masses")
    return edmd.System(**{name: arrays.get(name, getattr(system, name)) for name in names})


def event_times(system, collisions):
    simulation = edmd.Simulation(system)
    return np.array([simulation.run(collisions=1).time for _ in range(collisions)]), simulation


def distance_in_cell(a, b, box):
    """Largest distance of two sets of positions modulo the cell."""
    fraction = (a - b) @ np.linalg.inv(box)
    return np.abs((fraction - np.round(fraction)) @ box).max()


@pytest.mark.parametrize("shape", SHAPES)
def test_moved_by_cell_vectors(shape):
    """Bodies handed over in other images of the cell: the same collisions at the same times."""
    system = fluids.fluid(shape, 32, 0.4, seed=6)
    images = np.random.default_rng(1).integers(-3, 4, size=(32, 3))
    times, simulation = event_times(system, 60)
    moved, other = event_times(changed(system, positions=system.positions + images @ system.box), 60)
    assert moved == pytest.approx(times, rel=1e-9)
    assert distance_in_cell(simulation.system.positions, other.system.positions, system.box) < 1e-8


@pytest.mark.parametrize("shape", SHAPES)
def test_moved_and_set_in_motion_together(shape):
    """A common displacement, and a common velocity (Galileo)."""
    system = fluids.fluid(shape, 32, 0.4, seed=6)
    times, simulation = event_times(system, 60)
    drift, offset = np.array([0.3, -1.1, 0.7]), np.array([0.11, 2.7, -13.0])
    moved, other = event_times(changed(system, positions=system.positions + offset, velocities=system.velocities + drift), 60)
    assert moved == pytest.approx(times, rel=1e-9)
    expected = simulation.system.positions + offset + drift * simulation.time
    assert distance_in_cell(other.system.positions, expected, system.box) < 1e-8
    assert other.system.velocities - drift == pytest.approx(simulation.system.velocities, abs=1e-8)


@pytest.mark.parametrize(("k", "j"), [(1, 0), (0, 1), (-7, 0), (3, -2), (40, 10), (-60, -5)])
@pytest.mark.parametrize("shape", SHAPES)
def test_units(shape, k, j):
    """Lengths times 2^k and masses times 4^j at the same kT: times go with 2^(k + j), and nothing else is new."""
    system = fluids.fluid(shape, 32, 0.4, seed=6)
    length, mass, time = 2.0**k, 4.0**j, 2.0**(k + j)
    scaled = changed(system, positions=system.positions * length, semi_axes=system.semi_axes * length, box=system.box * length,
                     velocities=system.velocities * (length / time), angular_velocities=system.angular_velocities / time,
                     masses=system.masses * mass)
    times, simulation = event_times(system, 80)
    other_times, other = event_times(scaled, 80)
    assert other_times / time == pytest.approx(times, rel=1e-9)
    a, b = simulation.system, other.system
    assert distance_in_cell(b.positions / length, a.positions, system.box) < 1e-8
    assert b.velocities * (time / length) == pytest.approx(a.velocities, abs=1e-8)
    assert b.angular_velocities * time == pytest.approx(a.angular_velocities, abs=1e-7)
    assert other.temperature == pytest.approx(1, abs=1e-12)
    assert other.pressure * length**3 == pytest.approx(simulation.pressure, rel=1e-8)
    other.verify()


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("n", [12, 16])
def test_time_reversal(shape, n):
    """Run, turn every velocity round, run as long again: back where it began."""
    start = fluids.fluid(shape, n, 0.3, seed=8)
    simulation = edmd.Simulation(start).run(collisions=2 * n)
    span = simulation.time * (1 + 1e-3)
    simulation.run(time=span - simulation.time)
    there = simulation.system
    there.velocities *= -1
    there.angular_velocities *= -1
    back = edmd.Simulation(there).run(time=span)
    assert back.collisions == simulation.collisions
    end = back.system
    assert distance_in_cell(end.positions, start.positions, start.box) < 1e-8
    assert end.velocities == pytest.approx(-start.velocities, abs=1e-7)
    if shape != "sphere":
        same = np.abs((end.orientations * start.orientations).sum(axis=1))
        assert same == pytest.approx(1, abs=1e-13)
        assert end.angular_velocities == pytest.approx(-start.angular_velocities, abs=1e-7)


@pytest.mark.parametrize("combination", [[[1, 0, 0], [1, 1, 0], [0, 0, 1]], [[1, 0, 0], [0, 1, 0], [-1, 1, 1]],
                                         [[1, 0, 0], [-1, 1, 0], [1, -1, 1]]])
@pytest.mark.parametrize("shape", SHAPES)
def test_the_same_lattice_of_images_in_a_skewed_cell(shape, combination):
    """Cell vectors combined with integers of determinant 1 span the same images: the same collisions."""
    system = fluids.fluid(shape, 108, 0.3, seed=6)
    box = np.array(combination) @ system.box
    times, simulation = event_times(system, 150)
    skewed, other = event_times(changed(system, box=box), 150)
    assert skewed == pytest.approx(times, rel=1e-9)
    assert distance_in_cell(simulation.system.positions, other.system.positions, system.box) < 1e-7
    other.verify()


def test_a_crystal_in_another_cell_from_ase():
    """Any cell vectors that describe the crystal, in any order and direction, through edmd.from_ase: the same collisions."""
    import ase

    start = edmd.lattice("fcc", (1.25, 1, 0.8), 0.5, cells=(3, 3, 3), seed=2)
    times, _ = event_times(start, 100)
    turn = Rotation.from_rotvec([0.3, -0.8, 0.5]).as_matrix()
    cell = np.array([[0, 1, 0], [0, 1, 1], [1, 0, 1]]) @ start.box @ turn.T
    atoms = ase.Atoms(f"X{start.n}", positions=start.positions @ turn.T, cell=cell, pbc=True)
    quaternion = Rotation.from_matrix(turn).as_quat()
    other = edmd.from_ase(atoms, (1.25, 1, 0.8), orientations=np.tile(quaternion[[3, 0, 1, 2]], (start.n, 1)))
    # the rotation that from_ase applies, seen in the bodies
    applied = independent.rotation_matrices(other.orientations)[0]
    other.velocities, other.angular_velocities = start.velocities @ applied.T, start.angular_velocities @ applied.T
    assert other.packing_fraction == pytest.approx(start.packing_fraction, rel=1e-12)
    turned, simulation = event_times(other, 100)
    assert turned == pytest.approx(times, rel=1e-9)
    simulation.verify()


def test_order_of_the_axes_does_not_matter():
    """A body described with its axes in another order, its frame turned accordingly: the same collisions."""
    system = fluids.fluid("prolate", 32, 0.4, seed=6)
    times, _ = event_times(system, 60)
    # new body axes (x, y, z) are the old (z, x, y): R' = R C with the columns of C the old axes
    cyclic = np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0.0]])
    old = Rotation.from_quat(system.orientations[:, [1, 2, 3, 0]])
    quaternions = (old * Rotation.from_matrix(cyclic)).as_quat()[:, [3, 0, 1, 2]]
    semi_axes = system.semi_axes[:, [2, 0, 1]]
    assert independent.shape_matrices(quaternions, semi_axes) == pytest.approx(
        independent.shape_matrices(system.orientations, system.semi_axes), abs=1e-13)
    other, _ = event_times(changed(system, orientations=quaternions, semi_axes=semi_axes), 60)
    assert other == pytest.approx(times, rel=1e-9)


def test_nearly_equal_axes_are_the_limit_of_equal_ones():
    """c -> a from both sides: a sphere, treated as a body that turns, collides as a sphere does."""
    spheres = fluids.fluid("sphere", 32, 0.4, seed=6)
    times, _ = event_times(changed(spheres, angular_velocities=np.zeros((32, 3))), 40)
    for difference in (1e-12, -1e-12):
        axes = spheres.semi_axes * np.array([1, 1, 1 + difference])
        nearly, _ = event_times(changed(spheres, semi_axes=axes, angular_velocities=np.zeros((32, 3))), 40)
        assert nearly == pytest.approx(times, rel=1e-6)
