"""Simulation: what run and compress accept, where they stop, what the numbers mean."""

import fluids
import independent
import numpy as np
import pytest

import edmd


@pytest.fixture
def simulation():
    return edmd.Simulation(fluids.fluid("prolate", 32, 0.4))


@pytest.mark.parametrize("arguments", [
    {}, {"time": 1.0, "collisions": 5}, {"collisions": 5, "collisions_per_particle": 1}, {"time": 0.0}, {"time": -1.0}, {"time": np.nan},
    {"time": np.inf}, {"time": "long"}, {"collisions": 0}, {"collisions": -5}, {"collisions_per_particle": 0.0}, {"collisions": np.inf},
])
def test_run_wants_exactly_one_positive_length(simulation, arguments):
    with pytest.raises(ValueError, match="exactly one" if len(arguments) != 1 else next(iter(arguments))):
        simulation.run(**arguments)
    assert simulation.collisions == 0
    assert simulation.time == 0


@pytest.mark.parametrize("arguments", [
    {"rate": 0.0, "until_pressure": 100}, {"rate": np.nan, "until_pressure": 100}, {"rate": "fast", "until_pressure": 100},
    {"rate": np.inf, "until_pressure": 100}, {"rate": 0.1}, {"rate": 0.1, "until_pressure": 100, "until_packing_fraction": 0.5},
    {"rate": 0.1, "until_pressure": 1.0}, {"rate": 0.1, "until_pressure": -5}, {"rate": 0.1, "until_pressure": np.nan},
    {"rate": 0.1, "until_pressure": 1e15}, {"rate": -0.1, "until_pressure": 0.9}, {"rate": 0.1, "until_packing_fraction": 0.3},
    {"rate": 0.1, "until_packing_fraction": 1.0}, {"rate": 0.1, "until_packing_fraction": np.nan},
    {"rate": -0.1, "until_packing_fraction": 0.5}, {"rate": -0.1, "until_packing_fraction": 0.0},
])
def test_compress_refuses_in_words(simulation, arguments):
    before = simulation.system
    with pytest.raises(ValueError, match=r"rate|until_pressure|until_packing_fraction"):
        simulation.compress(**arguments)
    assert independent.same_bits(simulation.system, before)


def test_bodies_at_rest_cannot_be_compressed():
    start = fluids.fluid("prolate", 32, 0.4)
    start = edmd.System(start.positions, start.orientations, start.semi_axes, start.box)
    simulation = edmd.Simulation(start)
    with pytest.raises(ValueError, match="at rest"):
        simulation.compress(0.1, until_packing_fraction=0.5)
    simulation.run(time=3.0)
    assert simulation.collisions == 0
    assert simulation.system.positions == pytest.approx(start.positions, abs=1e-14)
    assert simulation.system.orientations == pytest.approx(start.orientations, abs=1e-15)


@pytest.mark.parametrize("system", [None, 3, "fcc", np.zeros((3, 3))])
def test_only_a_system_starts_a_simulation(system):
    with pytest.raises(ValueError, match=r"^system"):
        edmd.Simulation(system)


def test_overlapping_start_is_refused():
    start = edmd.System([[2, 2, 2], [3.9, 2, 2], [8, 8, 8]], [[1, 0, 0, 0]] * 3, (1, 1, 1), 12.0)
    with pytest.raises(ValueError, match=r"bodies 0 and 1 overlap.*0\.95"):
        edmd.Simulation(start)
    through_the_face = edmd.System([[0.5, 2, 2], [11.5, 2, 2]], [[1, 0, 0, 0]] * 2, (1, 1, 1), 12.0)
    with pytest.raises(ValueError, match="overlap"):
        edmd.Simulation(through_the_face)


@pytest.mark.parametrize("box", [2.2, (20, 2.2, 20), [[20, 0, 0], [0, 20, 0], [0, 19, 2.2]]])
def test_a_cell_too_small_for_its_bodies_is_refused(box):
    with pytest.raises(ValueError, match=r"^box.*too small"):
        edmd.Simulation(edmd.System([[1, 1, 1]], [[1, 0, 0, 0]], (1, 1, 1), box))


def test_bodies_that_outgrow_their_cell_are_told_in_words():
    """Few needles in a narrow cell: during the compression a body comes near its own image."""
    start = edmd.random_system(8, (0.3, 0.3, 1.5), 0.1, seed=1)
    simulation = edmd.Simulation(start)
    with pytest.raises(ValueError, match="cell is too small"):
        simulation.compress(0.5, until_packing_fraction=0.7)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_very_few_bodies(n):
    positions = np.array([[2, 2, 2], [6, 6, 6], [2, 6, 2.0]])[:n]
    start = edmd.thermalized(edmd.System(positions, [[1, 0, 0, 0]] * n, (1, 1, 1.5), 9.0), 3)
    simulation = edmd.Simulation(start).run(time=50.0)
    simulation.verify()
    assert simulation.time == 50.0
    assert simulation.temperature == pytest.approx(1, rel=1e-12)


def test_lengths_of_runs(simulation):
    simulation.run(collisions=17)
    assert simulation.collisions == 17
    simulation.run(collisions_per_particle=2.5)
    assert simulation.collisions == 17 + 40
    before = simulation.time
    assert simulation.run(time=0.375) is simulation
    assert simulation.time == pytest.approx(before + 0.375, abs=1e-15)
    many = edmd.Simulation(fluids.fluid("sphere", 32, 0.4)).run(time=64.0)
    assert many.time == 64.0
    assert many.collisions > 10_000


@pytest.mark.parametrize("target", [0.41, 0.5, 0.55])
@pytest.mark.parametrize("shape", fluids.SHAPES)
def test_compression_stops_exactly(shape, target):
    simulation = edmd.Simulation(fluids.fluid(shape, 32, 0.4))
    ended = simulation.compress(0.1, until_packing_fraction=target)
    assert ended is simulation
    assert simulation.packing_fraction == pytest.approx(target, abs=1e-14)
    assert simulation.system.packing_fraction == pytest.approx(target, abs=1e-14)
    assert independent.packing_fraction(simulation.system) == pytest.approx(target, abs=1e-14)
    assert simulation.temperature == pytest.approx(1, abs=1e-12)
    assert simulation.time == pytest.approx((np.cbrt(target / 0.4) - 1) / 0.1, rel=1e-9)
    assert independent.smallest_scale(simulation.system) > 1 - 1e-12
    simulation.run(collisions=100).verify()


@pytest.mark.parametrize("rate", [-0.1, -2.0])
def test_expansion(rate):
    simulation = edmd.Simulation(fluids.fluid("triaxial", 32, 0.5))
    simulation.compress(rate, until_packing_fraction=0.2)
    assert simulation.packing_fraction == pytest.approx(0.2, abs=1e-14)
    assert simulation.temperature == pytest.approx(1, abs=1e-12)
    simulation.verify()
    simulation.run(collisions=100).verify()


def test_bodies_that_touch_can_be_expanded():
    """From contact the reduced pressure of the first moments is beyond any at which a compression gives up."""
    simulation = edmd.Simulation(edmd.lattice("fcc", (1, 1, 1), np.pi / np.sqrt(18) * (1 - 1e-11), cells=(3, 3, 3)))
    simulation.compress(-0.1, until_packing_fraction=0.7)
    assert simulation.packing_fraction == pytest.approx(0.7, abs=1e-14)
    simulation.verify()


def test_a_second_compression_grows_from_the_present_size():
    simulation = edmd.Simulation(fluids.fluid("sphere", 32, 0.3))
    simulation.compress(0.2, until_packing_fraction=0.4)
    began = simulation.time
    simulation.compress(0.2, until_packing_fraction=0.5)
    assert simulation.time - began == pytest.approx((np.cbrt(0.5 / 0.4) - 1) / 0.2, rel=1e-9)


def test_compression_to_a_pressure():
    simulation = edmd.Simulation(fluids.fluid("triaxial", 64, 0.5))
    simulation.compress(0.05, until_pressure=1e3)
    assert 1e3 <= simulation.last_means.reduced_pressure < 1e4
    assert 0.6 < simulation.packing_fraction < 0.74
    simulation.verify()


def test_numbers_belong_to_the_most_recent_run(simulation):
    assert np.isnan(simulation.pressure)
    simulation.run(collisions=500)
    began = simulation.time
    simulation.run(collisions=777)
    span = simulation.time - began
    assert simulation.collision_rate == pytest.approx(2 * 777 / (32 * span), rel=1e-12)
    z, volume = simulation.compressibility_factor, simulation.system.volume
    assert simulation.pressure == pytest.approx(z * 32 * simulation.temperature / volume, rel=1e-9)
    assert 4 < z < 14


def test_numbers_of_now(simulation):
    simulation.run(collisions=321)
    translation, rotation = independent.energies(simulation.system)
    assert simulation.energy == pytest.approx(translation + rotation[:2].sum(), rel=1e-12)
    assert simulation.temperature == pytest.approx(2 * simulation.energy / (3 * 32 - 3 + 2 * 32), rel=1e-12)
    u = independent.rotation_matrices(simulation.system.orientations)[:, :, 2]
    order = np.linalg.eigvalsh(1.5 * u.T @ u / 32 - 0.5 * np.eye(3))[-1]
    assert simulation.nematic_order == pytest.approx(order, abs=1e-12)
    assert edmd.Simulation(edmd.lattice("fcc", (1, 1, 2), 0.3, cells=(2, 2, 2))).nematic_order == pytest.approx(1, abs=1e-12)


def test_positions_are_in_the_cell_and_images_unwrap_them(simulation):
    """Without the images bodies jump; with them every path is continuous, and slow over short times."""
    edge = simulation.system.box[0, 0]
    wrapped, unwrapped = [], []
    for _ in range(400):
        simulation.run(time=0.05)
        system, images = simulation.synchronised()
        assert (system.positions >= 0).all()
        assert (system.positions < edge).all()
        wrapped.append(system.positions)
        unwrapped.append(system.positions + images @ system.box)
    assert abs(np.diff(wrapped, axis=0)).max() > 0.9 * edge
    assert abs(np.diff(unwrapped, axis=0)).max() < 0.05 * 6
    assert abs(images).max() >= 1


def test_momentum_moves_the_whole_and_images_count_the_turns():
    start = fluids.fluid("sphere", 32, 0.4)
    start.velocities += [3.0, 0, 0]
    simulation = edmd.Simulation(start)
    first, images = simulation.synchronised()
    x = (first.positions + images @ first.box).mean(axis=0)
    simulation.run(time=40.0)
    last, images = simulation.synchronised()
    assert (last.positions + images @ last.box).mean(axis=0) - x == pytest.approx([120.0, 0, 0], abs=1e-9)


def test_a_body_in_a_cell_that_it_does_not_fit_into():
    with pytest.raises(ValueError, match=r"body 0 and its own periodic image overlap.*0\.75.*larger box"):
        edmd.Simulation(edmd.System([[1, 1, 1]], [[1, 0, 0, 0]], (1, 1, 2), 3.0))


def test_of_a_large_array_the_message_names_the_first_bad_number():
    axes = np.ones((1000, 3))
    axes[600, 2] = -1
    with pytest.raises(ValueError, match=r"^semi_axes\[600, 2\] = -1\.0: expected positive semi-axes$"):
        edmd.System(np.zeros((1000, 3)), np.ones((1000, 4)), axes, 50.0)
