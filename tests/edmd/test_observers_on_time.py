"""Observers are called at exactly the times, collisions and milestones they ask for."""

import fluids
import numpy as np
import pytest

import edmd


@pytest.fixture
def simulation():
    return edmd.Simulation(fluids.fluid("triaxial", 32, 0.4))


class Recorder(edmd.Observer):
    def __init__(self, when):
        super().__init__(when)
        self.calls, self.seen = [], []

    def start(self, view):
        self.calls.append(("start", view.time, view.collisions))

    def upkeep(self, view):
        self.calls.append(("upkeep", view.time, view.collisions))
        self.last = view.means

    def see(self, view):
        self.calls.append(("see", view.time, view.collisions))
        self.seen.append(view)

    def finish(self, view):
        self.calls.append(("finish", view.time, view.collisions))


def test_every_so_many_collisions(simulation):
    recorder = Recorder(edmd.Every(collisions=37))
    simulation.run(collisions=500, observers=[recorder])
    assert [view.collisions for view in recorder.seen] == list(range(37, 501, 37))
    assert recorder.calls[0] == ("start", 0.0, 0)
    assert recorder.calls[-1] == ("finish", simulation.time, 500)
    assert [name for name, *_ in recorder.calls].count("start") == 1
    assert "upkeep" in {name for name, *_ in recorder.calls}


def test_every_so_many_collisions_per_particle(simulation):
    recorder = Recorder(edmd.Every(collisions_per_particle=2))
    simulation.run(collisions=100, observers=[recorder])
    assert [view.collisions for view in recorder.seen] == [32, 64, 96]


def test_every_time(simulation):
    recorder = Recorder(edmd.Every(time=0.25))
    simulation.run(time=10.0, observers=[recorder])
    assert [view.time for view in recorder.seen] == pytest.approx(np.arange(1, 41) * 0.25, abs=1e-13)
    collisions = [view.collisions for view in recorder.seen]
    assert collisions == sorted(collisions)


@pytest.mark.parametrize("unit", ["time", "collisions"])
def test_logarithmic(simulation, unit):
    """At first * 10**(k / per_decade), counted from where the run starts; whole collisions that come twice count once."""
    simulation.run(collisions=50)
    began = getattr(simulation, unit)
    recorder = Recorder(edmd.Logarithmic(**{unit: 2 if unit == "collisions" else 0.01}, per_decade=4))
    simulation.run(collisions=600, observers=[recorder])
    seen = np.array([getattr(view, unit) for view in recorder.seen]) - began
    if unit == "time":
        assert seen == pytest.approx(0.01 * 10**(np.arange(len(seen)) / 4), abs=1e-12)
        assert seen[-1] * 10**0.25 > simulation.time - began
    else:
        assert seen.tolist() == [2, 4, 7, 12, 20, 36, 64, 113, 200, 356]


def test_nothing_that_others_look_at_moves_a_milestone(simulation):
    alone, among_others = (Recorder(edmd.Milestones(packing_fraction=0.01, pressure_factor=1.3)) for _ in range(2))
    simulation.compress(0.02, until_packing_fraction=0.5, observers=[alone])
    edmd.Simulation(fluids.fluid("triaxial", 32, 0.4)).compress(0.02, until_packing_fraction=0.5, observers=[
        among_others, Recorder(edmd.Every(collisions=13))])
    assert [view.time for view in among_others.seen] == [view.time for view in alone.seen]


def test_counting_goes_on_from_where_a_run_starts(simulation):
    simulation.run(collisions=50)
    recorder = Recorder(edmd.Every(collisions=20))
    simulation.run(collisions=50, observers=[recorder])
    assert [view.collisions for view in recorder.seen] == [70, 90]


def test_several_observers_at_their_own_moments(simulation):
    a, b, c = Recorder(edmd.Every(collisions=11)), Recorder(edmd.Every(collisions=7)), Recorder(edmd.Every(time=0.11))
    simulation.run(collisions=154, observers=[a, b, c])
    assert [view.collisions for view in a.seen] == list(range(11, 155, 11))
    assert [view.collisions for view in b.seen] == list(range(7, 155, 7))
    assert [view.time for view in c.seen] == pytest.approx(np.arange(1, len(c.seen) + 1) * 0.11, abs=1e-12)
    assert len(c.seen) == int(simulation.time / 0.11)


def test_the_view_is_of_that_moment(simulation):
    """Taken at the moment, the copy agrees with a run that stops there."""
    kept = []
    simulation.run(collisions=120, observers=[edmd.Observer(edmd.Every(collisions=60), lambda view: kept.append(view.system))])
    stopped = edmd.Simulation(fluids.fluid("triaxial", 32, 0.4)).run(collisions=60)
    assert np.array_equal(kept[0].positions, stopped.system.positions)
    assert np.array_equal(kept[0].velocities, stopped.system.velocities)


def test_time_during_compression(simulation):
    recorder = Recorder(edmd.Every(time=0.05))
    simulation.compress(0.1, until_packing_fraction=0.5, observers=[recorder])
    times = [view.time for view in recorder.seen]
    assert times == pytest.approx(np.arange(1, len(times) + 1) * 0.05, abs=1e-12)
    expected = 0.4 * (1 + 0.1 * np.array(times))**3
    assert [view.packing_fraction for view in recorder.seen] == pytest.approx(expected, rel=1e-9)


def test_milestones_of_the_packing_fraction(simulation):
    recorder = Recorder(edmd.Milestones(packing_fraction=0.02, pressure_factor=1e9))
    simulation.compress(0.02, until_packing_fraction=0.55, observers=[recorder])
    fractions = np.array([view.packing_fraction for view in recorder.seen])
    assert 4 <= len(fractions) <= 7
    assert (np.diff(np.concatenate([[0.4], fractions])) >= 0.02 - 1e-12).all()
    assert (np.diff(fractions) < 0.035).all()           # looked at after an upkeep only, of which each is up to 0.015 after the last


def test_milestones_of_the_pressure(simulation):
    recorder = Recorder(edmd.Milestones(packing_fraction=0.9, pressure_factor=4.0))
    simulation.compress(0.02, until_pressure=1e5, observers=[recorder])
    assert 4 <= len(recorder.seen) <= 8
    pressures = [view.means.reduced_pressure for view in recorder.seen]
    assert (np.array(pressures[1:]) > 4 * np.array(pressures[:-1])).all()


def test_an_observer_is_a_function_or_a_subclass(simulation):
    seen = []
    simulation.run(collisions=10, observers=[edmd.Observer(edmd.Every(collisions=5), seen.append)])
    assert [view.collisions for view in seen] == [5, 10]
    assert seen[0].n == 32


def test_what_an_observer_raises_reaches_the_caller_and_the_run_can_go_on(simulation):
    def stop(view):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        simulation.run(collisions=100, observers=[edmd.Observer(edmd.Every(collisions=40), stop)])
    assert simulation.collisions == 40
    simulation.run(collisions=60)
    straight = edmd.Simulation(fluids.fluid("triaxial", 32, 0.4)).run(collisions=100)
    assert np.array_equal(simulation.system.positions, straight.system.positions)


def test_an_interrupted_compression_stops_growing(simulation):
    def stop(view):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulation.compress(0.1, until_packing_fraction=0.5, observers=[edmd.Observer(edmd.Every(collisions=40), stop)])
    packing_fraction = simulation.packing_fraction
    assert 0.4 < packing_fraction < 0.5
    simulation.run(collisions=100).verify()
    assert simulation.packing_fraction == pytest.approx(packing_fraction, rel=1e-14)
    assert simulation.temperature == pytest.approx(1, rel=1e-12)


@pytest.mark.parametrize("arguments", [{}, {"time": 1, "collisions": 2}, {"time": 0}, {"collisions": -1}, {"time": np.nan},
                                       {"collisions_per_particle": "often"}])
def test_every_refuses_in_words(arguments):
    with pytest.raises(ValueError, match=r"exactly one|time|collisions"):
        edmd.Every(**arguments)


@pytest.mark.parametrize("arguments", [{}, {"time": 1, "collisions": 2}, {"time": 0}, {"time": 1, "per_decade": 0}])
def test_logarithmic_refuses_in_words(arguments):
    with pytest.raises(ValueError, match=r"exactly one|time|per_decade"):
        edmd.Logarithmic(**arguments)


@pytest.mark.parametrize("arguments", [{"packing_fraction": 0}, {"packing_fraction": -0.1}, {"pressure_factor": 1.0},
                                       {"pressure_factor": np.nan}])
def test_milestones_refuse_in_words(arguments):
    with pytest.raises(ValueError, match=next(iter(arguments))):
        edmd.Milestones(**arguments)
