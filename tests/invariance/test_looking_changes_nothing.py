"""The same run with and without observers, in small and in large blocks, gives the same bits."""

import fluids
import independent
import pytest

import edmd
import edmd.building

COLLISIONS = 3000


def finished(shape, n=48, packing_fraction=0.45):
    return edmd.Simulation(fluids.fluid(shape, n, packing_fraction, seed=9))


@pytest.fixture(scope="module", params=fluids.SHAPES)
def undisturbed(request):
    return request.param, finished(request.param).run(collisions=COLLISIONS)


def assert_same_run(simulation, other):
    assert (simulation.time, simulation.collisions, simulation.energy) == (other.time, other.collisions, other.energy)
    assert independent.same_bits(simulation.system, other.system)


def test_run_repeats(undisturbed):
    shape, run = undisturbed
    assert_same_run(finished(shape).run(collisions=COLLISIONS), run)


def test_a_slightly_different_start_is_another_run(undisturbed):
    """The comparison can fail: 1e-12 of one velocity is enough."""
    shape, run = undisturbed
    start = fluids.fluid(shape, 48, 0.45, seed=9)
    start.velocities[0, 0] *= 1 + 2**-40
    assert not independent.same_bits(edmd.Simulation(start).run(collisions=COLLISIONS).system, run.system)


@pytest.mark.parametrize("block", [1, 7, 96, 1000])
def test_blocks_of_collisions(undisturbed, block):
    shape, run = undisturbed
    simulation = finished(shape)
    while simulation.collisions < COLLISIONS:
        simulation.run(collisions=min(block, COLLISIONS - simulation.collisions))
    assert_same_run(simulation, run)


def test_blocks_of_time_between_events(undisturbed):
    """Stopping at any time, in the middle of everybody's flight, moves no body."""
    shape, run = undisturbed
    simulation = finished(shape)
    span = run.time / 301.7
    while simulation.time + span < run.time:
        simulation.run(time=span)
    simulation.run(collisions=COLLISIONS - simulation.collisions)
    assert_same_run(simulation, run)


@pytest.mark.parametrize("when", [edmd.Every(collisions=5), edmd.Every(collisions_per_particle=0.7), edmd.Every(time=0.0123)],
                         ids=["collisions", "per particle", "time"])
def test_observers(undisturbed, when):
    shape, run = undisturbed
    seen = []

    def look(view):
        seen.append(view.energy + view.system.positions[0, 0] + view.images[0, 0] + view.packing_fraction)
        view.system.positions[:] = 0.0
        view.system.velocities[:] = 7.0
        view.system.box[:] = 1.0

    simulation = finished(shape).run(collisions=COLLISIONS, observers=[edmd.Observer(when, look)])
    assert len(seen) > 20
    assert_same_run(simulation, run)


def test_trajectory(undisturbed, tmp_path):
    shape, run = undisturbed
    with edmd.Trajectory(tmp_path / "run.h5md", edmd.Every(collisions=47)) as trajectory:
        simulation = finished(shape).run(collisions=COLLISIONS, observers=[trajectory])
    assert_same_run(simulation, run)


def test_reading_and_verifying_between_blocks(undisturbed, tmp_path):
    shape, run = undisturbed
    simulation = finished(shape)
    for _ in range(8):
        simulation.run(collisions=COLLISIONS // 8)
        copy = simulation.system
        copy.positions += 1.0
        copy.orientations[:] = 0.0
        simulation.verify()
        simulation.save(tmp_path / "state.npz")
        assert simulation.nematic_order <= 1
        assert simulation.temperature == pytest.approx(1)
    assert_same_run(simulation, run)


def test_the_system_handed_over_is_neither_kept_nor_changed():
    start, untouched = fluids.fluid("prolate", 48, 0.45, seed=9), fluids.fluid("prolate", 48, 0.45, seed=9)
    simulation = edmd.Simulation(start).run(collisions=100)
    assert independent.same_bits(start, untouched)
    simulation = edmd.Simulation(start)
    start.positions[:] = 0.0
    start.velocities[:] = 0.0
    start.semi_axes[:] = 9.0
    assert_same_run(simulation.run(collisions=COLLISIONS), edmd.Simulation(untouched).run(collisions=COLLISIONS))


@pytest.mark.parametrize("shape", fluids.SHAPES)
def test_compression_with_and_without_observers(shape, tmp_path):
    def compressed(observers):
        simulation = finished(shape, packing_fraction=0.4)
        simulation.compress(0.05, until_packing_fraction=0.5, observers=observers)
        return simulation.run(collisions=500, observers=observers)

    plain = compressed([])
    seen = []
    watched = compressed([edmd.Observer(edmd.Every(collisions=13), lambda view: seen.append(view.system.packing_fraction)),
                          edmd.Observer(edmd.Every(time=0.003), lambda view: seen.append(view.energy)),
                          edmd.Trajectory(tmp_path / "run.h5md", edmd.Milestones(packing_fraction=0.003))])
    assert len(seen) > 50
    assert_same_run(watched, plain)


@pytest.mark.parametrize("room", [2, 5, 64])
@pytest.mark.parametrize("shape", ["prolate", "triaxial"])
def test_capacity_of_the_neighbour_lists(monkeypatch, shape, room):
    """Lists that overflow in the middle of a run, or never, give the same run."""
    plain = finished(shape).compress(0.05, until_packing_fraction=0.5).run(collisions=1000)
    monkeypatch.setattr(edmd.building, "LIST_ROOM", room)
    simulation = finished(shape).compress(0.05, until_packing_fraction=0.5).run(collisions=1000)
    assert_same_run(simulation, plain)
    simulation.verify()
