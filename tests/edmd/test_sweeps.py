"""A sweep on one machine: its table, what is done again and what is not, and what it survives: kills, failures, a full disk."""

import csv
import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import psutil
import pyarrow.parquet
import pytest
import swept
from test_runs import datasets
from waiting import wait_for

import edmd
from edmd.cli import main
from edmd.sweeps.pools import attempt

pytestmark = pytest.mark.usefixtures("no_summary")

ROOT = Path(__file__).parents[2]
HERE = os.environ | {"PYTHONPATH": str(ROOT)}
GRID = {"width": [1, 2, 3], "height": [0.5, 4.0]}
CONFIG = """
directory = "{directory}"
seed = 11
[run.system]
kind = "random"
n = 24
semi_axes = [1, 1, 1.5]
[[run.stage]]
kind = "compress"
until_pressure = 1e6
[run.output]
checkpoint = 0.02
frames = {{packing_fraction = 0.02, pressure_factor = 1.5}}
[grid]
stage.0.rate = [0.02, 0.05]
"""
TABLES = ("table.csv", "table.parquet")


def logged(directory):
    return [json.loads(line) for line in (Path(directory) / "sweep.log.jsonl").read_text().splitlines()]


def same_tables(one, other):
    return all((Path(one) / name).read_bytes() == (Path(other) / name).read_bytes() for name in TABLES)


def command(*arguments, **options):
    return subprocess.Popen([sys.executable, "-m", "edmd", "sweep", *arguments], env=HERE,
                            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options)


# the table

def test_a_function_over_a_grid(tmp_path, monkeypatch):
    monkeypatch.undo()                                                  # this one draws its summary
    table = edmd.sweep(swept.area, GRID, tmp_path / "sweep", replicas=2)
    assert (table["status"] == "done").all()
    assert table["width"].tolist() == [1] * 4 + [2] * 4 + [3] * 4
    assert np.array_equal(table["area"], table["width"] * table["height"])
    assert len(set(table["seed"])) == len(set(table["run"])) == 12
    assert np.array_equal(table["noise"], table["seed"] % 1000 / 1000)
    for name in table["run"]:
        assert (tmp_path / "sweep" / "runs" / name / "result.json").exists()
    with open(tmp_path / "sweep" / "table.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    parquet = pyarrow.parquet.read_table(tmp_path / "sweep" / "table.parquet").to_pydict()
    assert list(rows[0]) == list(table) == list(parquet)
    for name, column in table.items():
        assert parquet[name] == column.tolist()
        assert [type(column.tolist()[0])(row[name]) for row in rows] == column.tolist()
    assert (tmp_path / "sweep" / "summary.png").read_bytes().startswith(b"\x89PNG")


def test_called_again_it_does_only_what_is_missing(tmp_path):
    directory, calls = tmp_path / "sweep", tmp_path / "sweep" / "runs" / "calls.txt"
    first = edmd.sweep(swept.counted, {"width": [1, 3]}, directory)
    before = calls.read_text()
    again = edmd.sweep(swept.counted, {"width": [1, 3]}, directory)
    assert calls.read_text() == before
    assert all(np.array_equal(first[name], again[name]) for name in first)
    longer = edmd.sweep(swept.counted, {"width": [1, 2, 3, 4]}, directory, replicas=2)
    done = sorted(calls.read_text().split())
    assert done == sorted([*before.split(), "1", "2", "2", "3", "4", "4"])
    whole = edmd.sweep(swept.counted, {"width": [1, 2, 3, 4]}, tmp_path / "at once", replicas=2)
    assert same_tables(directory, tmp_path / "at once")
    assert set(first["seed"]) < set(longer["seed"]) == set(whole["seed"])
    (directory / "runs" / longer["run"][3] / "result.json").unlink()
    edmd.sweep(swept.counted, {"width": [1, 2, 3, 4]}, directory, replicas=2)
    assert len(calls.read_text().split()) == len(done) + 1
    assert same_tables(directory, tmp_path / "at once")


def test_results_of_workers_whose_disk_is_not_ours(tmp_path, monkeypatch):
    def elsewhere(task, children):
        outcome = attempt(task, children)
        shutil.rmtree(task["directory"])
        return outcome

    monkeypatch.setattr("edmd.sweeps.pools.attempt", elsewhere)
    assert edmd.sweep(swept.area, GRID, tmp_path / "far")["status"].tolist() == ["done"] * 6
    monkeypatch.undo()
    edmd.sweep(swept.area, GRID, tmp_path / "here")
    assert same_tables(tmp_path / "far", tmp_path / "here")


# whose directory it is

@pytest.mark.parametrize(("change", "words"), [
    ({"grid": {"width": [1]}}, "1 of whose 2 runs this design has not, such as width = 2"), ({"seed": 1}, "seed was 0 there and is 1 now"),
    ({"function_or_config": swept.counted}, "function was"), ({"grid": {"width": [1, 2], "height": [3]}}, "2 of whose 2 runs"),
    ({"function_or_config": {"stage": [{"kind": "run", "time": 1.0}]}, "grid": {"stage.0.time": [1]}}, "belongs to another sweep"),
])
def test_a_directory_of_another_sweep(change, words, tmp_path):
    call = {"function_or_config": swept.area, "grid": {"width": [1, 2]}, "directory": tmp_path}
    edmd.sweep(**call)
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    with pytest.raises(ValueError, match="expected") as problem:
        edmd.sweep(**call | change)
    assert words in str(problem.value)
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before


def test_a_config_that_has_changed_is_another_sweep(whole, capsys):
    assert main(["sweep", str(whole.parent / "sweep.toml"), "--set", "run.system.n=25"]) == 2
    assert "config: system.n was 24 there and is 25 now" in capsys.readouterr().err


def test_a_directory_that_is_none_of_a_sweep(tmp_path):
    (tmp_path / "precious").write_text("mine")
    for directory, words in ((tmp_path, "no sweep's"), (tmp_path / "precious", "is a file")):
        with pytest.raises(ValueError, match=words):
            edmd.sweep(swept.area, {"width": [1]}, directory)
    assert [path.name for path in tmp_path.iterdir()] == ["precious"]


def test_two_sweeps_in_one_directory_at_once(tmp_path):
    other = threading.Thread(target=edmd.sweep, args=(swept.slow, {"width": [1, 2]}, tmp_path))
    other.start()
    wait_for(lambda: list(tmp_path.glob("runs/*/pid")))
    with pytest.raises(ValueError, match="another sweep is at work"):
        edmd.sweep(swept.slow, {"width": [1, 2]}, tmp_path)
    other.join()
    assert len(list(tmp_path.glob("runs/*/result.json"))) == 2


def test_the_result_of_another_run(tmp_path):
    table = edmd.sweep(swept.area, {"width": [1, 2]}, tmp_path)
    one, other = (tmp_path / "runs" / name / "result.json" for name in table["run"])
    one.write_bytes(other.read_bytes())
    with pytest.raises(ValueError, match="the result of another run"):
        edmd.sweep(swept.area, {"width": [1, 2]}, tmp_path)
    one.write_text("{")
    with pytest.raises(ValueError, match="not what a sweep wrote"):
        edmd.sweep(swept.area, {"width": [1, 2]}, tmp_path)


# failures

def test_a_run_that_fails_is_tried_again_and_told_and_the_rest_goes_on(tmp_path):
    with pytest.warns(RuntimeWarning, match="1 of 3 runs failed.*no width of two"):
        table = edmd.sweep(swept.fails, {"width": [1, 2, 3]}, tmp_path, retries=1)
    assert table["status"].tolist() == ["done", "failed", "done"]
    assert np.isnan(table["area"]).tolist() == [False, True, False]
    attempts = [line["status"] for line in logged(tmp_path) if line["run"] == table["run"][1]]
    assert attempts == ["failed", "failed"]
    assert "Traceback" in (tmp_path / "runs" / table["run"][1] / "output.txt").read_text()


def test_a_run_that_is_killed_is_tried_again(tmp_path):
    table = edmd.sweep(swept.killed, {"width": [1, 2]}, tmp_path, retries=2)
    assert table["area"].tolist() == [2.0, 4.0]
    problems = [line["problem"] for line in logged(tmp_path) if line["run"] == table["run"][1]]
    assert problems == ["killed by signal 9", "killed by signal 9", ""]


def test_answers_that_are_no_numbers(tmp_path):
    with pytest.warns(RuntimeWarning, match="2 of 2 runs failed"):
        edmd.sweep(swept.answers, {"width": [1, 2]}, tmp_path, retries=0)
    problems = {line["problem"] for line in logged(tmp_path)}
    assert problems == {"TypeError: the function returned 'text': 'long'; expected a dict of numbers",
                        "TypeError: the function returned [2]: expected a dict of numbers"}


def test_a_run_that_must_fail_again_is_not_tried_again(tmp_path, capsys):
    path = tmp_path / "sweep.toml"
    path.write_text(CONFIG.format(directory=tmp_path / "sweep").replace("until_pressure = 1e6", "until_packing_fraction = 0.95")
                    .replace("[0.02, 0.05]", "[0.5]"))
    assert main(["sweep", str(path)]) == 1
    assert "the bodies jam" in capsys.readouterr().err
    assert [line["status"] for line in logged(tmp_path / "sweep")] == ["refused"]


# kills

@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The directory of a sweep of a config that nothing interrupted."""
    folder = tmp_path_factory.mktemp("sweep")
    (folder / "sweep.toml").write_text(CONFIG.format(directory=folder / "whole"))
    assert main(["sweep", str(folder / "sweep.toml"), "--quiet"]) == 0
    return folder / "whole"


def same_runs(one, other):
    names = [path.name for path in (one / "runs").iterdir()]
    return len(names) == 2 and all(datasets(one / "runs" / name / "run.h5md") == datasets(other / "runs" / name / "run.h5md")
                                   for name in names)


def under_way(directory):
    """(run directory, process) of runs that have made a checkpoint and are going on."""
    found = []
    if not any(directory.glob("runs/*/run.checkpoint.npz")):                # to look at all processes takes a while
        return found
    for child in psutil.Process().children(recursive=True):
        try:
            files = [Path(file.path) for file in child.open_files()]
        except psutil.Error:
            continue
        found += [(file.parent, child) for file in files if file.name == "lock" and directory in file.parents
                  and (file.parent / "run.checkpoint.npz").exists()]
    return found


def test_a_config_and_what_it_measures(whole):
    table = pyarrow.parquet.read_table(whole / "table.parquet").to_pydict()
    assert table["stage.0.rate"] == [0.02, 0.05]
    for i, name in enumerate(table["run"]):
        config = edmd.read_config(whole / "runs" / name / "config.toml")
        assert (config.seed, config.stages[0].rate) == (table["seed"][i], table["stage.0.rate"][i])
        simulation = edmd.Simulation(edmd.random_system(24, (1, 1, 1.5), 0.3, config.seed), config.seed)
        simulation.compress(config.stages[0].rate, until_pressure=1e6)
        assert table["packing_fraction"][i] == simulation.packing_fraction
        assert table["reduced_pressure"][i] == simulation.last_means.reduced_pressure > 1e6
        assert table["collisions"][i] == simulation.collisions
        assert 0 <= table["rattlers"][i] < 24
        assert table["contact_number"][i] > 4


def test_without_pyarrow_there_is_the_csv(whole, tmp_path, capsys, monkeypatch):
    directory = shutil.copytree(whole, tmp_path / "moved")
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    assert main(["sweep", str(whole.parent / "sweep.toml"), "-o", str(directory)]) == 0
    assert "no table.parquet without pyarrow: pip install 'edmd[sweep]'" in capsys.readouterr().err
    assert not (directory / "table.parquet").exists()
    assert (directory / "table.csv").read_bytes() == (whole / "table.csv").read_bytes()


def test_workers_killed_in_the_middle(whole, tmp_path):
    """SIGKILL to processes that have made a checkpoint: they go on from there, and all comes out as if nothing had happened."""
    directory, killed = tmp_path / "sweep", []

    def kill():
        while len(killed) < 2:
            for run, process in under_way(directory):
                if run not in killed and len(killed) < 2:
                    process.kill()
                    killed.append(run)
            time.sleep(0.02)

    murderer = threading.Thread(target=kill, daemon=True)
    murderer.start()
    assert main(["sweep", str(whole.parent / "sweep.toml"), "-o", str(directory), "--quiet"]) == 0
    murderer.join(1)
    assert [line["problem"] for line in logged(directory) if line["status"] == "failed"] == ["killed by signal 9"] * 2
    assert same_tables(whole, directory)
    assert same_runs(whole, directory)
    for run in killed:
        assert (run / "output.txt").read_text() == "goes on from its checkpoint\n"


def test_the_command_itself_interrupted_and_killed(whole, tmp_path):
    """Its processes end by themselves, after a last checkpoint; the same command does the rest."""
    directory = tmp_path / "sweep"
    for number, status in ((signal.SIGINT, 130), (signal.SIGKILL, -9)):
        first = command(str(whole.parent / "sweep.toml"), "-o", str(directory))
        runs, children = zip(*wait_for(lambda: under_way(directory)))
        first.send_signal(number)
        told = first.communicate()[1]
        assert first.returncode == status
        _, alive = psutil.wait_procs(children, timeout=10)
        assert not alive
        assert len(list(directory.glob("runs/*/result.json"))) < 2
        assert all((run / "run.checkpoint.npz").exists() for run in runs)
        if number == signal.SIGINT:
            assert "interrupted; 0 of 2 runs are done, and the same command does the rest" in told
            assert (directory / "table.csv").read_text().count("missing") == 2
    assert main(["sweep", str(whole.parent / "sweep.toml"), "-o", str(directory), "--quiet"]) == 0
    assert same_tables(whole, directory)
    assert same_runs(whole, directory)


def test_a_full_disk(whole, tmp_path):
    """Files cannot grow beyond 64 kB: the sweep stops, says so, and goes on when there is room."""
    directory = tmp_path / "sweep"
    full = command(str(whole.parent / "sweep.toml"), "-o", str(directory), "--workers", "1",
                   preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 16, resource.RLIM_INFINITY)))
    told = full.communicate()[1]
    assert full.returncode == 1
    assert "the disk is full" in told
    assert "0 of 2 runs are done, and the same command does the rest" in told
    assert "Traceback" not in told
    assert main(["sweep", str(whole.parent / "sweep.toml"), "-o", str(directory), "--quiet"]) == 0
    assert same_tables(whole, directory)


def test_a_script_without_a_guard(tmp_path):
    """Each run imports the script for its function; it says what is missing instead of sweeping for ever."""
    (tmp_path / "script.py").write_text("import edmd\ndef f(x):\n    return {'y': x}\nedmd.sweep(f, {'x': [1]}, 'sweep', retries=0)\n")
    done = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, env=HERE, capture_output=True, text=True)
    assert 'expected the call under if __name__ == "__main__":' in done.stderr
