"""Compression and expansion: schedules of rates, where they end, restart in their course; bodies that shrink from contact."""

import fluids
import independent
import numpy as np
import pytest

import edmd
from edmd.config import read_config

SHAPES = [(1, 1, 1), (1, 1, 2.0), (1.25, 1, 0.8)]


def mixture():
    return edmd.random_system((20, 12), [(1, 1, 1.5), (0.7, 0.7, 0.7)], 0.4, seed=5)


class Growth(edmd.Observer):
    """(reduced pressure, packing fraction, time) at every upkeep."""

    def __init__(self):
        super().__init__(edmd.Schedule())
        self.rows = []

    def upkeep(self, view):
        self.rows.append((view.means.reduced_pressure, view.packing_fraction, view.time))


def rates_seen(rows):
    """Growth rate of the length scale in every upkeep interval but the first, times the size at its start."""
    pressure, packing_fraction, time = np.array(rows).T
    size = np.cbrt(packing_fraction)
    return pressure[:-1], np.diff(size) / np.diff(time) / size[:-1]


def test_the_rate_is_lowered_as_the_pressure_rises():
    schedule = {0: 0.2, 30: 0.05, 1000: 0.01}
    simulation, seen = edmd.Simulation(fluids.fluid("prolate", 64, 0.4)), Growth()
    simulation.compress(schedule, until_pressure=1e4, observers=[seen])
    pressure, rate = rates_seen(seen.rows)
    highest = np.maximum.accumulate(pressure)
    expected = np.select([highest >= 1000, highest >= 30], [0.01, 0.05], 0.2)
    # rates are of the size at which they take hold
    assert (rate <= expected * (1 + 1e-9)).all()
    assert (rate >= expected * 0.8).all()
    assert {0.2, 0.05, 0.01} == set(expected)
    simulation.verify()


def test_a_schedule_is_the_same_as_one_compression_after_the_other_but_for_the_upkeep_between():
    a, b = (edmd.Simulation(fluids.fluid("sphere", 64, 0.4)) for _ in range(2))
    a.compress([(0, 0.1), (50, 0.02)], until_pressure=500)
    b.compress(0.1, until_pressure=50)
    b.compress(0.02, until_pressure=500)
    assert a.packing_fraction == pytest.approx(b.packing_fraction, abs=0.02)
    assert edmd.Simulation(fluids.fluid("sphere", 64, 0.4)).compress({0: 0.1}, until_pressure=50).time == pytest.approx(
        edmd.Simulation(fluids.fluid("sphere", 64, 0.4)).compress(0.1, until_pressure=50).time, rel=1e-15)


def test_a_schedule_meets_a_packing_fraction_exactly():
    simulation = edmd.Simulation(fluids.fluid("triaxial", 64, 0.4))
    simulation.compress({1: 0.1, 15: 0.02}, until_packing_fraction=0.58)
    assert simulation.packing_fraction == pytest.approx(0.58, abs=1e-15)
    assert simulation.temperature == pytest.approx(1, abs=1e-12)


@pytest.mark.parametrize("schedule", [{0: 0.1, 20: 0.03, 100: 0.01}, -0.05])
def test_restart_in_the_course_of_a_compression(schedule, tmp_path):
    def compressed(observers=()):
        simulation = edmd.Simulation(mixture())
        return simulation.compress(schedule, until_pressure=300 if isinstance(schedule, dict) else 3, observers=observers)

    def save(view):
        if view.course is not None:
            view._simulation.save(tmp_path / f"{len(list(tmp_path.iterdir()))}")
    straight = compressed()
    compressed([edmd.Observer(edmd.Every(collisions=1500 if isinstance(schedule, dict) else 100), save)])
    saved = sorted(tmp_path.iterdir(), key=lambda path: int(path.name))
    assert len(saved) > 1
    for path in saved[:: max(len(saved) // 3, 1)]:
        loaded = edmd.Simulation.load(path)
        for refused, arguments in ((loaded.rescale, (1.0,)), (loaded.thermalize, ()), (loaded.compress, (0.1, 5))):
            with pytest.raises(ValueError, match="resume"):
                refused(*arguments)
        loaded.resume()
        assert (loaded.time, loaded.collisions) == (straight.time, straight.collisions)
        assert independent.same_bits(loaded.system, straight.system)


@pytest.mark.parametrize("rate", [
    {}, [], {50: 0.1}, {0: 0.1, 100: -0.1}, {0: 0.1, 100: 0}, [(0, 0.1), (0, 0.2)], [0.1, 0.2], {0: "fast"}, {-1: 0.1}, {0: np.nan},
    {0: 0.1, 100: 99},
])
def test_schedules_that_are_none_are_refused(rate):
    simulation = edmd.Simulation(fluids.fluid("sphere", 32, 0.3))
    with pytest.raises(ValueError, match=r"^rate"):
        simulation.compress(rate, until_pressure=100)
    assert simulation.time == 0


def test_exactly_one_end_is_wanted():
    simulation = edmd.Simulation(fluids.fluid("sphere", 32, 0.3))
    with pytest.raises(ValueError, match=r"until_pressure = 9, until_packing_fraction = 0.5: expected exactly one"):
        simulation.compress(0.1, until_pressure=9, until_packing_fraction=0.5)
    with pytest.raises(ValueError, match=r"packing fraction is 0.3 and rate = -0.1 leads away.*expected one below it, or a positive rate"):
        simulation.compress(-0.1, until_packing_fraction=0.5)


def test_a_schedule_in_a_config():
    stage = {"kind": "compress", "rate": [[0, 0.1], [20, 0.02]], "until_pressure": 1e12}
    config = read_config({"stage": [stage]})
    assert config.stages[0].rate == ((0.0, 0.1), (20.0, 0.02))
    assert read_config(config.document()) == config
    for wrong in ([], [[0, -1.0]], [[5, 0.1]], 0.0, "fast", [0.1]):
        with pytest.raises(ValueError, match=r"stage.0.rate"):
            read_config({"stage": [{**stage, "rate": wrong}]})
    with pytest.raises(ValueError, match=r"until_pressure.*at most 1e.12"):
        read_config({"stage": [{**stage, "until_pressure": 1.1e12}]})


def test_a_run_with_a_schedule(tmp_path):
    config = {"seed": 3, "system": {"kind": "random", "n": 32, "semi_axes": [1, 1, 1.5], "packing_fraction": 0.3},
              "stage": [{"kind": "compress", "rate": [[0, 0.2], [20, 0.05]], "until_pressure": 100},
                        {"kind": "compress", "rate": -0.1, "until_pressure": 10}]}
    simulation = edmd.run(config, output=tmp_path / "run.h5md")
    assert simulation.last_means.reduced_pressure <= 10
    simulation.verify()


@pytest.mark.parametrize("shape", SHAPES)
def test_decompression_to_a_pressure(shape):
    simulation = edmd.Simulation(fluids.fluid(shape, 64, 0.5)).compress(0.1, until_pressure=1e4)
    jammed, seen = simulation.packing_fraction, Growth()
    simulation.compress(-0.02, until_pressure=20, observers=[seen])
    pressures = np.array(seen.rows)[:, 0]
    assert (pressures[:-2] > 20).all()              # the last interval is cut short
    assert simulation.last_means.reduced_pressure <= 20
    assert simulation.packing_fraction < jammed
    assert simulation.temperature == pytest.approx(1, abs=1e-12)
    simulation.verify()


@pytest.mark.parametrize("gap", [1e-11, 1e-13, 1e-15, -4e-16])
@pytest.mark.parametrize("shape", SHAPES)
def test_bodies_that_touch_can_shrink(shape, gap):
    """An fcc crystal at contact to the last bit, expanding fast: at no gap time would stand still, and later the surfaces outrun the
    bodies, which then wait for collisions that never come."""
    start = edmd.lattice("fcc", shape, np.pi / np.sqrt(18) * (1 - gap), cells=(2, 2, 2), stretched=True)
    simulation = edmd.Simulation(start)
    simulation.compress(-0.1, until_packing_fraction=0.7)
    assert simulation.packing_fraction == pytest.approx(0.7, abs=1e-14)
    assert simulation.collisions < 1e5
    simulation.verify()


@pytest.mark.parametrize("bodies", ["spheres", "mixture"])
def test_the_highest_reduced_pressure(bodies):
    """Gaps of some 1e-12 of a body are still resolved: no overlap, no contact missed, energy accounted for."""
    simulation = edmd.Simulation(mixture() if bodies == "mixture" else fluids.fluid("sphere", 32, 0.5))
    simulation.compress({0: 0.1, 100: 0.05}, until_pressure=1e12)
    assert 1e12 <= simulation.last_means.reduced_pressure < 1e13
    simulation.verify()
    assert independent.smallest_scale(simulation.system) > 1 - 1e-13
    loosened = simulation.compress(-0.05, until_pressure=1e3)
    assert loosened.last_means.reduced_pressure <= 1e3
    loosened.verify()
