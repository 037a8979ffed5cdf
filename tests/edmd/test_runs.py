"""A run from its config: what it writes, how it is continued after whatever ended it, how it is repeated, what it refuses."""

import json
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import fluids
import h5py
import independent
import numpy as np
import pytest

import edmd
from edmd.cli import main
from edmd.config import config_text
from edmd.runs import RunFailed, checkpoint_path, log_path
from edmd.trajectory import read_system, verify_file

ROOT = Path(__file__).parents[2]
DOCUMENT = {
    "seed": 3, "system": {"kind": "random", "n": [20, 12], "semi_axes": [[1, 1, 2], [0.8, 0.8, 0.8]], "packing_fraction": 0.35},
    "stage": [{"kind": "run", "collisions_per_particle": 60, "frames": {"time": 0.25}},
              {"kind": "compress", "rate": 0.05, "until_pressure": 1e3, "frames": {"packing_fraction": 0.01, "pressure_factor": 1.5}},
              {"kind": "compress", "rate": -0.1, "until_packing_fraction": 0.45},
              {"kind": "run", "time": 5.0, "frames": {"time": 0.01, "per_decade": 8}}]}


def datasets(path):
    """Every dataset of a file, under each of its names, as (shape, bytes)."""
    found = {}

    def walk(group, name):
        for key, item in group.items():
            if isinstance(item, h5py.Group):
                walk(item, f"{name}/{key}")
            else:
                found[f"{name}/{key}"] = (item.shape, item[()].tobytes())

    with h5py.File(path, "r") as file:
        walk(file, "")
    return found


def frames(path):
    with h5py.File(path, "r") as file:
        return len(file["particles/trajectory/position/step"])


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """(path, simulation) of a run of all stages that nothing interrupted."""
    path = tmp_path_factory.mktemp("runs") / "whole.h5md"
    return path, edmd.run(DOCUMENT, output=path)


def interrupted(path, moment, act, checkpoint=1e-9):
    """The same run, in which something happens at a moment; with a checkpoint at every one."""
    document = DOCUMENT | {"output": {"checkpoint": checkpoint}}
    seen = []

    def see(view):
        seen.append(view)
        if len(seen) == moment:
            act()
    return edmd.run(document, output=path, observers=[edmd.Observer(edmd.Every(collisions=100), see)])


def test_a_run_is_its_stages_by_hand(whole):
    path, simulation = whole
    system = edmd.random_system([20, 12], [(1, 1, 2), (0.8, 0.8, 0.8)], 0.35, seed=3)
    by_hand = edmd.Simulation(system).run(collisions_per_particle=60).compress(0.05, until_pressure=1e3)
    by_hand.compress(-0.1, until_packing_fraction=0.45).run(time=5.0)
    assert independent.same_bits(simulation.system, by_hand.system)
    assert simulation.pressure == by_hand.pressure
    assert np.array_equal(read_system(path).positions, by_hand.system.positions)
    assert np.array_equal(read_system(path, 0).positions, system.positions)
    assert verify_file(path)[2] == []


def test_what_lies_beside_it_at_the_end(whole):
    assert {path.name for path in whole[0].parent.iterdir()} == {"whole.h5md", "whole.log.jsonl"}


def test_names_of_what_lies_beside_it():
    """Two files in a folder never share a checkpoint, however they are called."""
    for name in ("a.h5md", "a", "phi0.25", "phi0.30", "a.h5"):
        assert checkpoint_path(f"x/{name}") == Path(f"x/{name.removesuffix('.h5md')}.checkpoint.npz")
        assert log_path(f"x/{name}") == Path(f"x/{name.removesuffix('.h5md')}.log.jsonl")


def test_frames_of_every_stage_come_when_the_stage_says(whole):
    with h5py.File(whole[0]) as file:
        times = file["particles/trajectory/position/time"][:]
        fractions = file["observables/packing_fraction/value"][:]
    steady = times[fractions == fractions[0]]
    assert np.diff(steady)[:-1] == pytest.approx(0.25, abs=1e-12)
    last = times[-1] - 5.0
    logarithmic = [0.01 * 10**(k / 8) for k in range(22)]
    assert times[-23:-1] - last == pytest.approx(logarithmic, abs=1e-9)


def test_the_log_is_json_lines(whole):
    lines = [json.loads(line) for line in whole[0].with_suffix(".log.jsonl").read_text().splitlines()]
    assert {line["stage"] for line in lines} == {0, 1, 2, 3}
    for stage in range(4):
        done = [line["done"] for line in lines if line["stage"] == stage]
        assert done == sorted(done)
        assert 0.5 < done[-1] <= 1          # lines come by the clock: the last one as near the end as the machine was quick
    assert lines[-1]["packing_fraction"] == pytest.approx(0.45)
    assert all(line["collisions_per_second"] >= 0 and line["at"].startswith("20") for line in lines)


@pytest.mark.parametrize(("moment", "number"), [(1, signal.SIGTERM), (14, signal.SIGINT), (30, signal.SIGTERM)])
def test_interrupted_and_resumed(whole, tmp_path, moment, number):
    path = tmp_path / "run.h5md"
    with pytest.raises(KeyboardInterrupt, match="resume"):
        interrupted(path, moment, lambda: signal.raise_signal(number), checkpoint=3600)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    assert any("incomplete" in problem for problem in verify_file(path)[2])
    simulation = edmd.resume(path)
    assert independent.same_bits(simulation.system, whole[1].system)
    assert simulation.pressure == whole[1].pressure
    assert datasets(path) == datasets(whole[0])
    assert verify_file(path)[2] == []
    assert {beside.name for beside in tmp_path.iterdir()} == {"run.h5md", "run.log.jsonl"}


def test_what_was_written_after_the_checkpoint_is_cut_off(whole, tmp_path):
    """An observer that fails, twice, long after the only checkpoint, which is made before the stage."""
    path = tmp_path / "run.h5md"

    def fail():
        raise RuntimeError("power cut")

    with pytest.raises(RuntimeError, match="power cut"):
        interrupted(path, 12, fail, checkpoint=3600)
    written = frames(path)
    assert written > 10
    seen = []
    with pytest.raises(RuntimeError, match="power cut"):
        edmd.resume(path, observers=[edmd.Observer(edmd.Every(collisions=77), lambda view: seen.append(view) or len(seen) < 2 or fail())])
    assert frames(path) < written
    edmd.resume(path)
    assert datasets(path) == datasets(whole[0])
    collisions = [json.loads(line)["collisions"] for line in path.with_suffix(".log.jsonl").read_text().splitlines()]
    assert collisions == sorted(set(collisions))


@pytest.mark.parametrize("stage", range(4))
def test_ended_as_a_stage_begins_and_resumed(whole, tmp_path, stage):
    """Before its first event: the run goes on from the checkpoint that was made before the stage."""
    class PowerCut(edmd.Observer):
        begun = 0

        def start(self, view):
            self.begun += 1
            if self.begun > stage:
                raise RuntimeError("power cut")

    path = tmp_path / "run.h5md"
    with pytest.raises(RuntimeError, match="power cut"):
        edmd.run(DOCUMENT, output=path, observers=[PowerCut(edmd.Every(time=1e9))])
    assert independent.same_bits(edmd.resume(path).system, whole[1].system)
    assert datasets(path) == datasets(whole[0])


def command(*arguments, **options):
    return subprocess.Popen([sys.executable, "-m", "edmd", *map(str, arguments)], cwd=ROOT, stderr=subprocess.PIPE, text=True,
                            env={**os.environ, "PYTHONPATH": str(ROOT)}, **options)


def test_killed_at_random_moments_and_resumed(whole, tmp_path):
    """SIGKILL, twice, in a run that checkpoints itself every tenth of a second; then to its end: every dataset is the same."""
    path, config, seed = tmp_path / "run.h5md", tmp_path / "run.toml", time.time_ns()
    document = DOCUMENT | {"stage": [DOCUMENT["stage"][0] | {"collisions_per_particle": 1000, "frames": {"time": 1.0}},
                                     *DOCUMENT["stage"][1:]]}
    config.write_text(config_text(document))
    draw, checkpoint = random.Random(seed), path.with_suffix(".checkpoint.npz")
    for arguments, wanted in ((["run", config, "-o", path, "--set", "output.checkpoint=0.1", "--quiet"], 2),
                              (["resume", path, "--quiet"], 1)):
        began, process, made = time.time(), command(*arguments), set()          # the first is made before the first event
        while process.poll() is None and len(made) < wanted:
            if checkpoint.exists() and checkpoint.stat().st_mtime > began:
                made.add(checkpoint.stat().st_mtime_ns)
            time.sleep(0.01)
        time.sleep(draw.uniform(0, 0.25))
        process.kill()
        process.communicate()
        assert process.returncode == -signal.SIGKILL, f"too quick to be killed, seed {seed}"
        assert independent.smallest_scale(read_system(path)) > 1 - 1e-9, f"seed {seed}"
        assert frames(path) > 2
    assert main(["resume", str(path), "--quiet"]) == 0
    edmd.run(document, output=tmp_path / "straight.h5md")
    assert datasets(path) == datasets(tmp_path / "straight.h5md"), f"seed {seed}"


def test_a_full_disk(whole, tmp_path):
    """A limit on the size of files stands for it: exit status 1, one sentence, and with room again the run goes on to the same end."""
    path, config = tmp_path / "run.h5md", tmp_path / "run.toml"
    config.write_text(config_text(DOCUMENT))
    process = command("run", config, "-o", path, "--quiet", "--set", "output.checkpoint=0.01",
                      preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (600_000, 600_000)))
    told = process.communicate()[1]
    assert process.returncode == 1
    assert "Traceback" not in told
    assert "too large" in told
    assert f"edmd resume {path}" in told
    assert frames(path) > 2
    edmd.resume(path)
    assert datasets(path) == datasets(whole[0])


def test_from_a_file_the_run_is_repeated(whole, tmp_path, capsys):
    path = tmp_path / "again.h5md"
    assert main(["run", "--from", str(whole[0]), "-o", str(path), "--quiet"]) == 0
    assert datasets(path) == datasets(whole[0])
    assert main(["run", "--from", str(whole[0]), "-o", str(tmp_path / "other.h5md"), "--seed", "4", "--quiet"]) == 0
    assert datasets(tmp_path / "other.h5md") != datasets(whole[0])
    assert capsys.readouterr().out == ""
    for arguments in (["run", "--from", str(whole[0])], ["run", "--from", str(whole[0]), "x.toml", "-o", "y"], ["run"]):
        assert main(arguments) == 2
        assert "expected" in capsys.readouterr().err


def test_from_a_file_whose_start_has_changed(whole, tmp_path):
    """A run that starts from another file is not repeated from a different one."""
    start, path = tmp_path / "start.h5md", tmp_path / "run.h5md"
    for seed in (1, 2):
        edmd.run({"seed": seed, "system": {"kind": "random", "n": 32}, "stage": [{"kind": "run", "time": 0.1}]}, output=start,
                 overwrite=True)
        if seed == 1:
            edmd.run({"system": {"kind": "file", "file": str(start)}, "stage": [{"kind": "run", "time": 0.1}]}, output=path)
            assert np.array_equal(read_system(path, 0).positions, read_system(start).positions)
    assert main(["run", "--from", str(path), "-o", str(tmp_path / "again.h5md")]) == 2
    assert not (tmp_path / "again.h5md").exists()


def test_a_packing_is_resumed_like_any_run(tmp_path):
    seen = []
    with pytest.raises(KeyboardInterrupt):
        edmd.pack(32, (1, 1, 1.5), rate=5e-2, seed=4, until_pressure=1e3, output=tmp_path / "run.h5md", observers=[edmd.Observer(
            edmd.Every(collisions=500), lambda view: seen.append(view) or len(seen) < 7 or signal.raise_signal(signal.SIGINT))])
    straight = edmd.pack(32, (1, 1, 1.5), rate=5e-2, seed=4, until_pressure=1e3, output=tmp_path / "straight.h5md")
    assert independent.same_bits(edmd.resume(tmp_path / "run.h5md").system, straight.system)
    assert datasets(tmp_path / "run.h5md") == datasets(tmp_path / "straight.h5md")


@pytest.fixture(scope="module")
def stopped(tmp_path_factory):
    """The folder of a run that was interrupted."""
    folder = tmp_path_factory.mktemp("stopped")
    with pytest.raises(KeyboardInterrupt):
        interrupted(folder / "run.h5md", 20, lambda: signal.raise_signal(signal.SIGINT), checkpoint=3600)
    return folder


def half(path, whole):
    path.write_bytes(whole[:len(whole) // 2])


def newer(path, whole):
    path.write_bytes(whole)
    with h5py.File(path, "a") as file:
        file["edmd"].attrs["format"] = 99


def frames_missing(path, whole):
    path.write_bytes(whole)
    with h5py.File(path, "a") as file:
        file["particles/trajectory/velocity/value"].resize(1, axis=0)


def checkpoint_missing(path, whole):
    path.write_bytes(whole)
    path.with_suffix(".checkpoint.npz").unlink()


def checkpoint_half(path, whole):
    path.write_bytes(whole)
    half(path.with_suffix(".checkpoint.npz"), path.with_suffix(".checkpoint.npz").read_bytes())


def checkpoint_no_checkpoint(path, whole):
    path.write_bytes(whole)
    edmd.Simulation(fluids.fluid("sphere")).save(path.with_suffix(".checkpoint.npz"))


def not_of_a_config(path, whole):
    with edmd.Trajectory(path, overwrite=True) as trajectory:
        edmd.Simulation(fluids.fluid("sphere")).run(collisions=10, observers=[trajectory])


@pytest.mark.parametrize(("damage", "words"), [
    (half, "truncated"), (newer, "newer"), (frames_missing, "velocity/value has 1 entries"), (checkpoint_missing, "no checkpoint"),
    (checkpoint_half, "not a state"), (checkpoint_no_checkpoint, "no checkpoint"), (not_of_a_config, "not written by `edmd run`"),
    (lambda path, whole: path.unlink(), "no such file"), (lambda path, whole: path.write_text("hello"), "not an HDF5 file"),
])
def test_resume_of_files_that_are_not_whole(stopped, damage, words, tmp_path, capsys):
    path = shutil.copytree(stopped, tmp_path / "copy") / "run.h5md"
    damage(path, path.read_bytes())
    before = {beside: beside.read_bytes() for beside in path.parent.iterdir()}
    assert main(["resume", str(path)]) == 2
    told = capsys.readouterr().err
    assert words in told
    assert len(told.strip().splitlines()) == 1
    assert {beside: beside.read_bytes() for beside in path.parent.iterdir()} == before


def test_resume_of_a_run_that_is_complete_or_going_on(whole, tmp_path, capsys):
    before = whole[0].read_bytes()
    assert main(["resume", str(whole[0])]) == 0
    assert capsys.readouterr() == (f"{whole[0]}: the run is complete, nothing is left to do\n", "")
    with pytest.raises(edmd.RunComplete, match="complete"):
        edmd.resume(whole[0])
    assert whole[0].read_bytes() == before
    path, told = tmp_path / "run.h5md", []

    def meddle():
        for act in (lambda: edmd.resume(path), lambda: edmd.run(DOCUMENT, output=path, overwrite=True)):
            with pytest.raises(ValueError, match="written by another process"):
                act()
            told.append(True)

    interrupted(path, 20, meddle)
    assert len(told) == 2
    assert datasets(path) == datasets(whole[0])


@pytest.mark.parametrize("override", [
    "system.packing_fraction=0.95", "stage.1.rate=0", "stage.3.frames={time = 0}", "stage.2.until_packing_fraction=2",
    "stage.0={kind = 'compress', rate = -0.1, until_packing_fraction = 0.4}", "output.file=missing/run.h5md", "system.kind=file",
    "system={kind = 'lattice', packing_fraction = 0.9}", "system={kind = 'crystal', n = 3}", "seed=one", "system.n=1",
])
def test_bad_input_writes_nothing(override, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("run.toml").write_text(config_text(DOCUMENT))
    if override == "system.kind=file":
        override = "system={kind = 'file', file = 'missing.h5md'}"
    assert main(["run", "run.toml", "--set", override]) == 2
    told = capsys.readouterr().err
    assert told.startswith("edmd run: ")
    assert len(told.strip().splitlines()) == 1
    assert [path.name for path in tmp_path.iterdir()] == ["run.toml"]


def test_bodies_at_rest(tmp_path):
    still, path = fluids.fluid("sphere"), tmp_path / "still.h5md"
    still.velocities[:], still.angular_velocities[:] = 0, 0
    with edmd.Trajectory(path) as trajectory:
        edmd.Simulation(still).run(time=1.0, observers=[trajectory])
    document = {"system": {"kind": "file", "file": str(path)}, "stage": [{"kind": "run", "collisions": 10}]}
    with pytest.raises(ValueError, match=r"stage\.0: the bodies are at rest"):
        edmd.run(document, output=tmp_path / "run.h5md")
    assert edmd.run(document, ["system.temperature=2.0"], tmp_path / "run.h5md").temperature == pytest.approx(2)


def test_a_stage_that_cannot_end_fails_and_keeps_its_frames(tmp_path):
    path = tmp_path / "run.h5md"
    with pytest.raises(RunFailed, match=r"stage\.0: until_packing_fraction = 0\.9: the bodies jam"):
        edmd.run({"system": {"kind": "crystal", "n": 32, "semi_axes": [1, 1, 1]},
                  "stage": [{"kind": "compress", "rate": 0.1, "until_packing_fraction": 0.9}]}, output=path)
    assert read_system(path).packing_fraction > 0.6


def test_an_output_that_exists(whole, capsys, tmp_path):
    config, before = tmp_path / "run.toml", whole[0].read_bytes()
    config.write_text(config_text(DOCUMENT))
    assert main(["run", str(config), "-o", str(whole[0])]) == 2
    assert "exists already" in capsys.readouterr().err
    assert whole[0].read_bytes() == before


def test_the_command_tells_how_it_went_and_how_it_ended(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["run", "--print-config", "--seed", "5", "--set", "system.cells=[2, 2, 2]"]) == 0
    text = capsys.readouterr().out
    assert "seed = 5" in text
    Path("run.toml").write_text(text)
    monkeypatch.setattr("edmd.progress.LINE_SECONDS", 0.0)
    assert main(["run", "run.toml"]) == 0
    told = capsys.readouterr()
    assert "packing fraction  0.500000" in told.out
    assert "stage 1 (compress)" in told.err
    for words in ("packing fraction 0.", "collisions/s", "s left"):
        assert words in told.err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run.h5md", "run.log.jsonl", "run.toml"]
