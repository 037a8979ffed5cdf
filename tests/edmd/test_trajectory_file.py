"""The file as others see it: stock MDAnalysis, h5py, our own reader; and what happens to files that are not whole."""

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import fluids
import h5py
import independent
import numpy as np
import pytest
from waiting import wait_for

import edmd
from edmd.trajectory import open_run, read_system, verify_file

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A run, a compression and another run of triaxial bodies, in one file: (path, simulation, what an observer saw)."""
    path = tmp_path_factory.mktemp("trajectory") / "run.h5md"
    simulation = edmd.Simulation(fluids.fluid("triaxial", 32, 0.4), seed=42)
    seen = []
    observer = edmd.Observer(edmd.Every(collisions=100), lambda view: seen.append((view.collisions, view.system, view.images)))
    with edmd.Trajectory(path, edmd.Every(collisions=100), {"purpose": "test"}) as trajectory:
        simulation.run(collisions=1000, observers=[trajectory, observer])
        simulation.compress(0.1, until_packing_fraction=0.45, observers=[trajectory])
        simulation.run(time=20.0, observers=[trajectory])
    return path, simulation, seen


def test_layout(run):
    path, simulation, _ = run
    with h5py.File(path) as file:
        assert file["h5md"].attrs["version"].tolist() == [1, 1]
        assert file["h5md/creator"].attrs["name"] == "edmd"
        assert file["h5md/creator"].attrs["version"] == edmd.__version__
        group = file["particles/trajectory"]
        frames = len(group["position/step"])
        assert frames > 12
        assert group["box"].attrs["dimension"] == 3
        assert [str(b) if isinstance(b, str) else b.decode() for b in group["box"].attrs["boundary"]] == ["periodic"] * 3
        shapes = {"position": (32, 3), "velocity": (32, 3), "orientation": (32, 4), "angular_velocity": (32, 3), "semi_axes": (32, 3),
                  "image": (32, 3), "box/edges": (3, 3)}
        for name, shape in shapes.items():
            values = group[f"{name}/value"]
            assert values.shape == (frames, *shape)
            assert values.dtype == (np.int32 if name == "image" else np.float64)
            assert values.chunks[0] == 1
            for what in ("step", "time"):
                assert group[f"{name}/{what}"].id == group[f"position/{what}"].id or group[f"{name}/{what}"] == group[f"position/{what}"]
        for name in ("packing_fraction", "pressure", "reduced_pressure", "temperature", "energy", "collisions"):
            assert file[f"observables/{name}/value"].shape == (frames,)
        steps, times = group["position/step"][:], group["position/time"][:]
        assert steps.dtype == np.int64
        assert (np.diff(steps) >= 0).all()
        assert (np.diff(times) > 0).all()
        assert steps[:11].tolist() == list(range(0, 1001, 100))
        assert steps[-1] == simulation.collisions
        assert np.isnan(file["observables/pressure/value"][0])
        lengths = {len(values) for values in file["edmd/log"].values()}
        assert len(lengths) == 1
        assert lengths.pop() > 5
        assert len(group["species"]) == len(group["id"]) == len(group["mass"]) == 32


def test_provenance(run):
    with h5py.File(run[0]) as file:
        own = file["edmd"].attrs
        assert own["complete"]
        assert own["seed"] == 42
        assert own["version"] == edmd.__version__
        assert json.loads(own["parameters"]) == {"purpose": "test"}
        assert "numpy" in own["platform"]
        assert own["created"].startswith("20")
        assert int(own["format"]) == 1


def test_numbers_are_exact(run):
    path, simulation, seen = run
    with h5py.File(path) as file:
        group = file["particles/trajectory"]
        end, images = simulation.synchronised()
        pairs = [(-1, end, images), *((frame, system, images) for frame, (_, system, images) in enumerate(seen, 1))]
        for frame, system, images in pairs:
            for name, values in (("position", system.positions), ("velocity", system.velocities), ("orientation", system.orientations),
                                 ("angular_velocity", system.angular_velocities), ("semi_axes", system.semi_axes), ("image", images)):
                assert np.array_equal(group[f"{name}/value"][frame], values), name
            assert np.array_equal(group["box/edges/value"][frame], system.box)
        assert group["position/time"][-1] == simulation.time
        assert file["observables/packing_fraction/value"][-1] == simulation.packing_fraction
        assert (file["observables/temperature/value"][:] >= 1 - 1e-9).all()          # growth warms, an upkeep brings kT = 1 back


def test_pressure_belongs_to_the_interval_that_ends_at_the_frame(run):
    path, _, _ = run
    with h5py.File(path) as file:
        pressure = file["observables/reduced_pressure/value"][1:11]
    assert (pressure > 1).all()
    assert len(set(pressure)) == 10


def test_unwrapped_paths_are_continuous(tmp_path):
    with edmd.Trajectory(tmp_path / "run.h5md", edmd.Every(time=0.05)) as trajectory:
        simulation = edmd.Simulation(fluids.fluid("prolate", 32, 0.3)).run(time=10.0, observers=[trajectory])
    with h5py.File(tmp_path / "run.h5md") as file:
        group = file["particles/trajectory"]
        wrapped = group["position/value"][:]
        path = wrapped + np.einsum("tni,tij->tnj", group["image/value"][:], group["box/edges/value"][:])
    half = simulation.system.box[0, 0] / 2
    assert abs(np.diff(wrapped, axis=0)).max() > half, "no body crossed a face: this test would see nothing"
    assert abs(np.diff(path, axis=0)).max() < 0.1 * half


STOCK = """
import sys, json
import MDAnalysis as mda
u = mda.Universe.empty(32, trajectory=False)
u.load_new(sys.argv[1], format="H5MD", convert_units=False)
ts = u.trajectory[-1]
assert not any(name.split(".")[0] in ("edmd", "ccd", "analysis") for name in sys.modules)
print(json.dumps({"frames": len(u.trajectory), "positions": u.atoms.positions.tolist(), "velocities": u.atoms.velocities.tolist(),
    "dimensions": ts.dimensions.tolist(), "orientation": ts.data["orientation"].tolist(), "time": ts.time,
    "axes": ts.data["semi_axes"].tolist(), "exact": ts.data["position"].tolist()}))
"""


def test_stock_mdanalysis_reads_it(run, tmp_path):
    """In a process that knows nothing of our packages."""
    path, simulation, _ = run
    done = subprocess.run([sys.executable, "-c", STOCK, str(path)], cwd=tmp_path, capture_output=True, text=True,
                          env={k: v for k, v in os.environ.items() if k != "PYTHONPATH"})
    assert done.returncode == 0, done.stderr
    got, end = json.loads(done.stdout), simulation.system
    assert np.array(got["positions"]) == pytest.approx(end.positions, abs=1e-5)
    assert np.array(got["velocities"]) == pytest.approx(end.velocities, abs=1e-5)
    assert got["dimensions"] == pytest.approx([*np.diag(end.box), 90, 90, 90], rel=1e-6)
    assert np.array_equal(got["exact"], end.positions)
    assert np.array_equal(got["orientation"], end.orientations)
    assert np.array_equal(got["axes"], end.semi_axes)
    assert got["time"] == pytest.approx(simulation.time)


def test_our_reader_follows_the_frames(run):
    import MDAnalysis

    import analysis  # noqa: F401

    path, _, seen = run
    u = MDAnalysis.Universe(str(path))
    assert len(u.atoms) == 32
    for frame, (collisions, system, _) in enumerate(seen, 1):
        ts = u.trajectory[frame]
        assert ts.data["step"] == collisions
        assert np.array_equal(u.atoms.orientations, system.orientations)
        assert np.array_equal(u.atoms.semi_axes, system.semi_axes)
    with h5py.File(path) as file:
        times = file["particles/trajectory/position/time"][:2]
    assert u.trajectory.dt == pytest.approx(times[1] - times[0])
    u.trajectory.close()


def test_a_file_that_mdanalysis_holds_open_can_be_read(run):
    """In one process: HDF5 refuses to open a file twice with different locking."""
    import MDAnalysis

    import analysis  # noqa: F401

    universe = MDAnalysis.Universe(str(run[0]))
    try:
        assert np.array_equal(read_system(run[0]).positions, run[1].system.positions)
    finally:
        universe.trajectory.close()


def test_read_system_goes_on_where_the_run_was(run):
    path, simulation, seen = run
    end = read_system(path)
    assert np.array_equal(end.positions, simulation.system.positions)
    assert end.packing_fraction == pytest.approx(0.45, abs=1e-14)
    assert np.array_equal(read_system(path, 3).velocities, seen[2][1].velocities)
    edmd.Simulation(end).run(collisions=50).verify()
    for frame in (1000, -1000):
        with pytest.raises(ValueError, match=r"^frame"):
            read_system(path, frame)


def test_verify_file_finds_nothing_in_a_good_file(run):
    frames, smallest, wrong = verify_file(run[0])
    assert wrong == []
    assert frames > 12
    assert 1 - 1e-12 < smallest < 1.1


def test_existing_files_are_not_overwritten(tmp_path):
    path = tmp_path / "run.h5md"
    path.write_text("precious")
    with pytest.raises(ValueError, match=r"^output.*exists already"):
        edmd.Trajectory(path)
    assert path.read_text() == "precious"
    with edmd.Trajectory(path, overwrite=True) as trajectory:
        edmd.Simulation(fluids.fluid("sphere")).run(collisions=10, observers=[trajectory])
    assert read_system(path).n == 32


@pytest.mark.parametrize("name", ["missing/run.h5md", "."])
def test_places_that_cannot_be_written(tmp_path, name):
    with pytest.raises(ValueError, match=r"^output"):
        edmd.Trajectory(tmp_path / name)


def test_a_folder_that_takes_no_file():
    """Whoever asks, root too: the folder is tried, its permissions are not believed."""
    with pytest.raises(ValueError, match=r"^output.*(cannot be written|does not exist)"):
        edmd.Trajectory("/proc/run.h5md")


def test_a_run_that_fails_is_not_complete(tmp_path):
    path = tmp_path / "run.h5md"

    def stop(view):
        raise RuntimeError("power cut")

    simulation = edmd.Simulation(fluids.fluid("sphere"))
    with pytest.raises(RuntimeError, match="power cut"), edmd.Trajectory(path, edmd.Every(collisions=10)) as trajectory:
        simulation.run(collisions=1000, observers=[trajectory, edmd.Observer(edmd.Every(collisions=100), stop)])
    with h5py.File(path) as file:
        assert not file["edmd"].attrs["complete"]
        assert len(file["particles/trajectory/position/step"]) >= 10
    assert any("incomplete" in problem for problem in verify_file(path)[2])


def bad_files(folder, whole):
    (folder / "text").write_text("hello")
    (folder / "empty").write_bytes(b"")
    (folder / "half").write_bytes(whole[:len(whole) // 2])
    (folder / "head").write_bytes(whole[:3000])
    with h5py.File(folder / "foreign", "w") as file:
        file["x"] = [1, 2, 3]
    newer = folder / "newer"
    newer.write_bytes(whole)
    with h5py.File(newer, "a") as file:
        file["edmd"].attrs["format"] = 99


@pytest.mark.parametrize("name", ["text", "empty", "half", "head", "foreign", "newer", "missing"])
def test_files_that_are_not_ours_or_not_whole(run, tmp_path, name):
    bad_files(tmp_path, run[0].read_bytes())
    for read in (read_system, verify_file):
        with pytest.raises(ValueError, match=f"^path.*{name}"):
            read(tmp_path / name)


KILLED = """
import sys, edmd
simulation = edmd.Simulation(edmd.random_system(32, (1, 1, 1), 0.4, seed=1))
with edmd.Trajectory(sys.argv[1], edmd.Every(collisions=2000)) as trajectory:
    print("started", flush=True)
    simulation.run(collisions=10**9, observers=[trajectory])
"""


def test_a_killed_run_leaves_a_readable_file(tmp_path):
    """SIGKILL in the middle: what was flushed, at least every second, is there, and marked as incomplete."""
    path = tmp_path / "run.h5md"
    process = subprocess.Popen([sys.executable, "-c", KILLED, str(path)], cwd=ROOT, stdout=subprocess.PIPE, text=True,
                               env={**os.environ, "PYTHONPATH": str(ROOT)})
    assert process.stdout.readline() == "started\n"

    def on_disk():                                      # while it grows, with nothing of ours
        with suppress(OSError, KeyError), h5py.File(path, "r") as file:
            return len(file["particles/trajectory/position/step"])
        return 0

    growing = wait_for(lambda: (frames := on_disk()) > 5 and frames)
    time.sleep(1.5)
    process.send_signal(signal.SIGKILL)
    process.wait()
    with open_run(path) as file:                        # what was written after the last flush, in part, is cut off
        assert not file["edmd"].attrs["complete"]
        frames = len(file["particles/trajectory/position/step"])
        assert frames > growing
        assert (np.diff(file["particles/trajectory/position/step"][:]) == 2000).all()
        assert len(file["edmd/log/time"]) > 5
    for frame in (0, frames // 2, frames - 1):
        assert independent.smallest_scale(read_system(path, frame)) > 1 - 1e-12
