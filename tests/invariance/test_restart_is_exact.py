"""Save, load and go on: the same bits as the run that was never interrupted, and the same words for files that are no state."""

import fluids
import independent
import numpy as np
import pytest
from cross_section import cross_section

import edmd

NUMBERS = ("time", "collisions", "size", "packing_fraction", "energy", "temperature", "nematic_order", "pressure",
           "compressibility_factor", "collision_rate", "seed", "n")


def fresh(shape):
    return edmd.Simulation(fluids.fluid(shape, 40, 0.4, seed=3), seed=17)


def mixture():
    return edmd.Simulation(edmd.random_system((20, 12), [(1, 1, 2.0), (0.8, 0.6, 0.5)], 0.35, seed=5, masses=2.5), seed=17)


STAGES = {
    "at the start": lambda simulation: simulation,
    "mid-epoch": lambda simulation: simulation.run(collisions=37),
    "after several epochs": lambda simulation: simulation.run(collisions=777),
    "between events": lambda simulation: simulation.run(time=0.4321),
    "after a compression": lambda simulation: simulation.compress(0.05, until_packing_fraction=0.5),
    "mid-epoch after a compression": lambda simulation: simulation.compress(0.05, until_packing_fraction=0.5).run(collisions=91),
    "after an expansion": lambda simulation: simulation.compress(-0.05, until_packing_fraction=0.3).run(time=0.1),
}
CONTINUED = {
    "run": lambda simulation: simulation.run(collisions=1234),
    "run a time": lambda simulation: simulation.run(time=0.777),
    "compress": lambda simulation: simulation.compress(0.03, until_packing_fraction=0.52).run(collisions=50),
}


def assert_same(a, b):
    assert independent.same_bits(a.system, b.system)
    assert np.array_equal(a.synchronised()[1], b.synchronised()[1])
    for name in NUMBERS:
        x, y = getattr(a, name), getattr(b, name)
        assert x == y or (x != x and y != y), name


@pytest.mark.parametrize(("shape", "stage"), cross_section([*fluids.SHAPES, "mixture"], STAGES))
def test_restart(shape, stage, tmp_path):
    simulation = STAGES[stage](mixture() if shape == "mixture" else fresh(shape))
    simulation.save(tmp_path / "state")
    for go_on in CONTINUED.values():
        loaded, again = (edmd.Simulation.load(tmp_path / "state") for _ in range(2))
        assert_same(loaded, simulation)
        go_on(loaded)
        go_on(again)
        assert_same(loaded, again)
    CONTINUED["compress"](simulation)
    assert_same(loaded, simulation)
    loaded.verify()


def test_restart_of_a_restart(tmp_path):
    simulation, straight = fresh("oblate"), fresh("oblate").run(collisions=900)
    for step in range(9):
        simulation.run(collisions=100)
        simulation.save(tmp_path / f"{step}")
        simulation = edmd.Simulation.load(tmp_path / f"{step}")
    assert simulation.time == straight.time
    assert independent.same_bits(simulation.system, straight.system)


@pytest.mark.parametrize("inertia", ["sphere", (0.7, 0.7, 0.2)])
def test_inertia_comes_back(inertia, tmp_path):
    start = fluids.fluid("prolate", 40, 0.4, seed=3)
    simulation = edmd.Simulation(edmd.System(start.positions, start.orientations, start.semi_axes, start.box, start.velocities,
                                             start.angular_velocities, inertia=inertia))
    simulation.run(collisions=100).save(tmp_path / "state")
    loaded = edmd.Simulation.load(tmp_path / "state")
    assert np.array_equal(loaded.system.moments, simulation.system.moments)
    assert_same(loaded.run(collisions=500), simulation.run(collisions=500))


def test_every_public_number_is_there_after_loading(tmp_path):
    simulation = fresh("prolate").run(collisions=400)
    simulation.save(tmp_path / "state")
    loaded = edmd.Simulation.load(tmp_path / "state")
    for name in (name for name in dir(simulation) if not name.startswith("_")):
        if not callable(getattr(simulation, name)):
            getattr(loaded, name)
    assert loaded.last_means == simulation.last_means


def test_a_save_that_fails_leaves_the_old_file(tmp_path, monkeypatch):
    simulation = fresh("sphere").run(collisions=50)
    simulation.save(tmp_path / "state")
    before = (tmp_path / "state").read_bytes()

    def broken(*_, **__):
        raise OSError("disk full")

    monkeypatch.setattr(np, "savez", broken)
    with pytest.raises(OSError, match="disk full"):
        simulation.run(collisions=50).save(tmp_path / "state")
    assert (tmp_path / "state").read_bytes() == before


def not_states(folder):
    simulation = fresh("sphere")
    simulation.save(folder / "state")
    whole = (folder / "state").read_bytes()
    other = folder / "other"
    with open(other, "wb") as file:
        np.savez(file, a=np.zeros(3))
    return {"missing": None, "empty": b"", "text": b"hello", "half": whole[:len(whole) // 2], "tail lost": whole[:-100],
            "of something else": other.read_bytes(), "an array": b"\x93NUMPY\x01\x00" + b"\0" * 200}


@pytest.mark.parametrize("kind", ["missing", "empty", "text", "half", "tail lost", "of something else", "an array"])
def test_what_is_no_state_is_refused_in_words(kind, tmp_path):
    content = not_states(tmp_path)[kind]
    path = tmp_path / "bad"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(ValueError, match=r"path.*bad") as told:
        edmd.Simulation.load(path)
    assert "pickle" not in str(told.value)                  # numpy's advice for a text: to load it unsafely


COURSES = {
    "a run": lambda simulation, seen: simulation.run(collisions=1500, observers=seen),
    "a time": lambda simulation, seen: simulation.run(time=3.0, observers=seen),
    "a compression": lambda simulation, seen: simulation.compress(0.03, until_packing_fraction=0.5, observers=seen),
    "a compression to a pressure": lambda simulation, seen: simulation.compress(0.05, until_pressure=200, observers=seen),
    "an expansion": lambda simulation, seen: simulation.compress(-0.02, until_packing_fraction=0.3, observers=seen),
}


class Always(edmd.Schedule):
    """Whenever the engine gives control back, the end of an upkeep interval included."""

    def due(self, view):
        return True


@pytest.mark.parametrize(("shape", "course"), cross_section(["sphere", "triaxial", "mixture"], COURSES))
def test_resumed_in_the_course_of_a_run(shape, course, tmp_path):
    """Saved while it goes on, at several moments; every one of them ends as the run did."""
    simulation, saved = mixture() if shape == "mixture" else fresh(shape), []

    def save(view):
        saved.append(tmp_path / str(len(saved)))
        simulation.save(saved[-1], {"moment": len(saved)})

    COURSES[course](simulation, [edmd.Observer(edmd.Every(collisions=101), lambda view: None), edmd.Observer(Always(), save)])
    assert len(saved) >= 2
    for number, path in enumerate(saved, 1):
        loaded = edmd.Simulation.load(path)
        assert loaded.notes == {"moment": number}
        if loaded.course.grows:
            with pytest.raises(ValueError, match="in the course of a compression"):
                loaded.run(collisions=1)
        assert_same(loaded.resume(), simulation)
        with pytest.raises(ValueError, match="nothing to resume"):
            loaded.resume()
    loaded.verify()
