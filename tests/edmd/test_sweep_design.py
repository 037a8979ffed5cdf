"""Which runs a sweep is made of: points, replicas, names and seeds; what a file and a call may say, and how they are refused."""

import numpy as np
import pytest
import swept

import edmd
from edmd.cli import main
from edmd.sweeps.design import combined, plan, points_of
from edmd.sweeps.file import read_sweep

RUN = '[run.system]\nkind = "random"\nn = 16\n[[run.stage]]\nkind = "run"\ntime = 1.0\n'
SHORT = {"stage": [{"kind": "run", "time": 1.0}]}


def names(points, replicas=1, seed=0):
    return {run.name: run.seed for run in plan(points, replicas, seed)}


# points

def test_a_grid_is_every_combination():
    points = points_of({"a": [1, 2], "b": np.linspace(0, 1, 3), "c": range(2)})
    assert len(points) == 12
    assert points[:3] == [{"a": 1, "b": 0.0, "c": 0}, {"a": 1, "b": 0.0, "c": 1}, {"a": 1, "b": 0.5, "c": 0}]
    assert points_of([{"a": (1, 2)}, {"b": np.float64(3)}]) == [{"a": [1, 2]}, {"b": 3.0}]


def test_random_points_lie_in_their_ranges_and_grow():
    ranges = {"u": {"uniform": [2, 3]}, "l": {"log": [1e-4, 1]}, "i": {"integer": [1, 3]}, "c": {"choice": ["x", "y"]}}
    points = edmd.random_points(ranges, 2000, seed=5)
    assert edmd.random_points(ranges, 20, seed=5) == points[:20]
    assert edmd.random_points(ranges, 20, seed=6) != points[:20]
    u, l, i = (np.array([point[key] for point in points]) for key in "uli")
    assert (u >= 2).all()
    assert (u < 3).all()
    assert u.mean() == pytest.approx(2.5, abs=0.03)
    assert np.log10(l).mean() == pytest.approx(-2, abs=0.1)
    assert np.bincount(i)[1:] == pytest.approx(2000 / 3, rel=0.1)
    assert {point["c"] for point in points} == {"x", "y"}
    assert abs(np.corrcoef(u, np.log(l))[0, 1]) < 0.06          # each its own stream
    assert edmd.random_points(ranges | {"more": {"uniform": [0, 1]}}, 5, seed=5)[0]["u"] == points[0]["u"]


# names and seeds

def test_names_and_seeds_stay_when_a_design_grows():
    small = names(points_of({"a": [1, 3]}), 2)
    for larger in (names(points_of({"a": [1, 2, 3]}), 3), names(points_of([{"a": 3.0}, {"a": 7}, {"a": 1}]), 2)):
        assert small.items() <= larger.items()


def test_every_run_has_its_own_seed():
    seeds = list(names(points_of({"a": range(500)}), 4).values())
    assert len(set(seeds)) == 2000
    assert min(seeds) >= 0
    assert max(seeds) < 2**53
    assert np.mean(seeds) == pytest.approx(2**52, rel=0.05)
    assert not set(seeds) & set(names(points_of({"a": range(500)}), 4, seed=1).values())


@pytest.mark.parametrize("points", [[{"a": 1, "b": 2}, {"b": 2.0, "a": 1}], [{"a": [1, 2]}, {"a": [1.0, 2]}], [{}, {}]])
def test_two_runs_never_share_a_directory(points):
    with pytest.raises(ValueError, match=r"comes twice, as points 0 and 1.*one directory"):
        plan(points, 1, 0)


# what is refused, before anything is written

@pytest.mark.parametrize(("changes", "words"), [
    ({"grid": {"widht": [1]}}, ["widht: no such key", "did you mean width?"]), ({"grid": {"width": 3}}, ["grid.width = 3", "list"]),
    ({"grid": {"width": []}}, ["grid.width = []"]), ({"grid": {"width": [{1, 2}]}}, ["grid.width"]),
    ({"grid": "width"}, ["grid = 'width'"]),
    ({"grid": {"height": [1]}}, ["width: the function needs it"]), ({"grid": {"width": [1], "seed": [2]}}, ["seed", "replicas"]),
    ({"grid": {"width": [1, 1]}}, ["width = 1: comes twice"]), ({"replicas": 0}, ["replicas = 0"]), ({"seed": -1}, ["seed = -1"]),
    ({"retries": 1.5}, ["retries = 1.5"]), ({"workers": 0}, ["workers = 0"]), ({"scheduler": "slrum"}, ["scheduler = 'slrum'", "slurm"]),
    ({"scheduler": 4}, ["scheduler = 4"]), ({"scheduler": "slurm", "slurm": {"walltime": "1 day"}}, ["slurm.walltime = '1 day'"]),
    ({"scheduler": "slurm", "slurm": 3}, ["slurm = 3"]), ({"plot": {"x": "widht"}}, ["plot.x = 'widht'", "width"]),
    ({"plot": {"z": "width"}}, ["plot"]), ({"plot": {"y": "area"}}, ["plot.y = 'area'", "list"]),
    ({"function_or_config": lambda width: {"a": 1}}, ["at the top of a module"]),
    ({"function_or_config": swept.area.__call__}, ["function"]),
    ({"function_or_config": SHORT, "grid": {"stage.0.tme": [1]}}, ["did you mean time?", "stage.0.tme = 1"]),
    ({"function_or_config": SHORT, "grid": {"stage.0.time": [1, -1]}}, ["stage.0.time = -1"]),
    ({"function_or_config": SHORT, "grid": {"output.file": ["a"]}}, ["output.file", "its own"]),
])
def test_bad_input_to_sweep(changes, words, tmp_path):
    call = {"function_or_config": swept.area, "grid": {"width": [1, 2]}, "directory": tmp_path / "sweep"} | changes
    with pytest.raises(ValueError, match=r"expected|twice") as problem:
        edmd.sweep(**call)
    for word in words:
        assert word in str(problem.value)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("ranges", "words"), [
    ({}, "ranges"), ({"a": [1, 2]}, "random.a"), ({"a": {"unifrom": [1, 2]}}, "did you mean uniform?"),
    ({"a": {"uniform": [2, 1]}}, "low < high"),
    ({"a": {"log": [0, 1]}}, "positive"), ({"a": {"integer": [0.5, 2]}}, "whole"), ({"a": {"choice": []}}, "choice"),
    ({"a": {"uniform": [1, 2], "log": [1, 2]}}, "random.a"), ({"a": {"uniform": 3}}, "two numbers"),
])
def test_bad_ranges(ranges, words):
    with pytest.raises(ValueError, match="expected") as problem:
        edmd.random_points(ranges, 3)
    assert words in str(problem.value)


# the file

def test_a_design_in_a_file(tmp_path):
    path = tmp_path / "sweep.toml"
    path.write_text(RUN + """
[grid]
stage.0.time = [1.0, 2.0]
[[point]]
"system.n" = 16
system.packing_fraction = 0.2
[[point]]
system.n = 32
[random]
draws = 3
system.temperature = {log = [0.1, 10]}
""")
    file = read_sweep(path, ["seed=4", "replicas=2"])
    points = file.design()
    assert len(points) == 2 * 2 * 3
    drawn = edmd.random_points({"system.temperature": {"log": [0.1, 10]}}, 3, seed=4)
    assert points[0] == {"system.n": 16, "system.packing_fraction": 0.2, "stage.0.time": 1.0, **drawn[0]}
    assert file.replicas == 2


def test_the_parts_of_a_design_name_different_parameters():
    with pytest.raises(ValueError, match="a: is named twice"):
        combined([{"a": 1}], [{"b": 1, "a": 2}])


@pytest.mark.parametrize(("text", "words"), [
    (RUN + "[gird]\na = [1]", ["gird: no such key", "did you mean grid?"]), ("[grid]\na = [1]", ["exactly one of config, run"]),
    ('config = "x.toml"\n' + RUN, ["exactly one of config, run"]), (f"replicas = 0\n{RUN}", ["replicas = 0"]),
    (f"workers = 1.5\n{RUN}", ["workers = 1.5"]), ('config = "missing.toml"', ["missing.toml", "No such file"]),
    ("replicas = ", ["not TOML"]),
    (RUN + "[random]\nsystem.n = {integer = [1, 2]}", ["random.draws"]), (RUN + "[random]\ndraws = 3", ["ranges"]),
    (RUN + '[grid]\nsystem.n = [8]\n"system.n" = [9]', ["grid.system.n: is named twice"]),
    (RUN + "[grid]\nsystem.n = [8]\n[[point]]\nsystem.n = 9", ["system.n: is named twice"]), (f"point = 3\n{RUN}", ["point = 3"]),
    (RUN + "[grid]\nsystem.m = [8]", ["system.m: no such key", "system.m = 8"]), (RUN + "[grid]\nseed = [8]", ["seed", "its own"]),
])
def test_bad_files(text, words, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "sweep.toml").write_text(text)
    assert main(["sweep", "sweep.toml"]) == 2
    told = capsys.readouterr().err
    assert told.startswith("edmd sweep: ")
    assert len(told.strip().splitlines()) == 1
    for word in words:
        assert word in told
    assert [path.name for path in tmp_path.iterdir()] == ["sweep.toml"]


def test_what_is_not_installed_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "distributed", None)
    with pytest.raises(ValueError, match=r"distributed is not installed.*edmd\[sweep\]"):
        edmd.sweep(swept.area, {"width": [1]}, tmp_path / "sweep", "tcp://localhost:1")
    assert list(tmp_path.iterdir()) == []
