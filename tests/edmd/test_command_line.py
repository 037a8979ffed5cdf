"""The command line: what it prints, what it writes, and its exit status."""

import json
import os
import re
import resource
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import h5py
import independent
import numpy as np
import pytest

import edmd
from edmd.cli import main
from edmd.trajectory import read_system

ROOT = Path(__file__).parents[2]
SMALL = ["pack", "-n", "32", "--rate", "2e-2", "--until-pressure", "1e4"]


@pytest.fixture(scope="module")
def packed(tmp_path_factory):
    """A small packing made by a process of its own: (path, finished process)."""
    path = tmp_path_factory.mktemp("cli") / "small.h5md"
    done = subprocess.run([sys.executable, "-m", "edmd", *SMALL, "-o", str(path)], cwd=ROOT, capture_output=True, text=True,
                          env={**os.environ, "PYTHONPATH": str(ROOT)})
    assert done.returncode == 0, done.stderr
    return path, done


def test_pack_writes_a_file_and_a_summary(packed):
    path, done = packed
    system = read_system(path)
    fraction = float(re.search(r"packing fraction +([\d.]+)", done.stdout)[1])
    assert fraction == pytest.approx(independent.packing_fraction(system), abs=1e-6)
    assert 0.65 < fraction < 0.75
    for words in ("reduced pressure", "contacts a body", "rattlers", "nematic order", "collisions", str(path)):
        assert words in done.stdout
    assert "\r" not in done.stdout
    assert "Traceback" not in done.stderr
    assert independent.smallest_scale(system) > 1 - 1e-9
    with h5py.File(path) as file:
        assert file["edmd"].attrs["complete"]
        assert file["observables/packing_fraction/value"][0] == pytest.approx(0.3)


def test_info(packed, capsys):
    assert main(["info", str(packed[0])]) == 0
    told = capsys.readouterr().out
    assert re.search(r"bodies +32\n", told)
    assert re.search(r"complete +yes\n", told)
    assert re.search(r"written by +edmd " + re.escape(edmd.__version__), told)
    assert f"{read_system(packed[0]).packing_fraction:.9f}" in told
    contacts = re.search(r"contacts a body +([\d.]+)", packed[1].stdout)[1]
    assert f"{contacts} (gap below 1.0e-02" in told          # as `edmd pack` counted them
    assert main(["info", str(packed[0]), "--contact-gap", "1e-14"]) == 0
    assert "contacts a body   nan (gap below 1.0e-14" in capsys.readouterr().out


def test_info_ends_with_the_config_as_it_can_be_run(packed, capsys):
    assert main(["info", str(packed[0])]) == 0
    text = capsys.readouterr().out.split("parameters:\n\n")[1]
    with h5py.File(packed[0]) as file:
        assert edmd.read_config(tomllib.loads(text)) == edmd.read_config(json.loads(file["edmd"].attrs["parameters"]))
    assert "or:" not in text


def test_info_for_machines(packed, capsys):
    assert main(["info", "--json", str(packed[0]), "--contact-gap", "1e-14"]) == 0
    told = json.loads(capsys.readouterr().out, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))
    assert (told["complete"], told["bodies"], told["seed"], told["rule"]) == (True, 32, 0, {"kind": "elastic"})
    assert told["packing_fraction"] == pytest.approx(read_system(packed[0]).packing_fraction, rel=1e-12)
    assert told["parameters"]["stage"][-1]["until_pressure"] == 1e4
    assert told["contact_number"] is None
    assert told["rattlers"] == 32


def test_verify(packed, capsys):
    assert main(["verify", str(packed[0])]) == 0
    assert re.search(r"problems +0\n", capsys.readouterr().out)


@pytest.mark.parametrize(("command", "suffix"), [("plot", "plot"), ("render", "picture")])
def test_pictures(packed, capsys, tmp_path, monkeypatch, command, suffix):
    monkeypatch.setattr("analysis.shading.SKY_LAMPS", 6)             # they take most of the time
    path = tmp_path / "copy.h5md"
    path.write_bytes(packed[0].read_bytes())
    more = ["--size", "120", "100"] if command == "render" else []
    assert main([command, str(path), *more]) == 0
    beside = tmp_path / f"copy.{suffix}.png"
    assert capsys.readouterr().out.strip() == str(beside)
    assert beside.read_bytes().startswith(b"\x89PNG")
    assert main([command, str(path), *more]) == 2
    assert main([command, str(path), *more, "--overwrite"]) == 0
    assert main([command, str(path), *more, "-o", str(tmp_path / "other.png")]) == 0
    assert (tmp_path / "other.png").stat().st_size > 500


def test_a_file_in_which_frames_are_missing(packed, capsys, tmp_path):
    """What is whole is used, what is not is named, with exit status 1 by verify and 2 where it is needed."""
    path = tmp_path / "short.h5md"
    path.write_bytes(packed[0].read_bytes())
    with h5py.File(path, "a") as file:
        frames = len(file["particles/trajectory/position/step"])
        file["particles/trajectory/velocity/value"].resize(frames - 2, axis=0)
    assert main(["verify", str(path)]) == 1
    told = capsys.readouterr()
    assert f"frame {frames - 2} is not whole" in told.err
    assert re.search(r"problems +2\n", told.out)
    assert main(["info", str(path)]) == 0
    assert f"{frames - 2} of {frames}: the others are not whole" in capsys.readouterr().out
    assert main(["export", str(path), "-o", str(tmp_path / "out.xyz")]) == 2
    assert f"frame {frames - 2} is not whole" in capsys.readouterr().err
    assert main(["export", str(path), "-o", str(tmp_path / "out.xyz"), "--frames", f":{frames - 2}"]) == 0


def test_a_full_disk_is_told_with_the_file(packed, tmp_path):
    """A limit on the size of files stands for it."""
    output = tmp_path / "picture.png"
    done = subprocess.run([sys.executable, "-m", "edmd", "plot", str(packed[0]), "-o", str(output)], cwd=ROOT, capture_output=True,
                          text=True, env={**os.environ, "PYTHONPATH": str(ROOT)},
                          preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, 10_000)))
    assert done.returncode == 1
    assert done.stderr.startswith(f"edmd plot: output = {str(output)!r}: File too large")


def test_verify_of_a_tampered_file(packed, capsys, tmp_path):
    """A body moved onto another in one frame: exit status 1, and the frame is named."""
    path = tmp_path / "tampered.h5md"
    path.write_bytes(packed[0].read_bytes())
    with h5py.File(path, "a") as file:
        positions = file["particles/trajectory/position/value"]
        positions[2, 5] = positions[2, 6] + 0.01
    assert main(["verify", str(path)]) == 1
    told = capsys.readouterr()
    assert "frame 2" in told.err
    assert "overlap" in told.err
    assert re.search(r"problems +1\n", told.out)


@pytest.mark.parametrize("change", ["orientation", "step", "complete", "position"])
def test_verify_of_other_damage(packed, capsys, tmp_path, change):
    path = tmp_path / "tampered.h5md"
    path.write_bytes(packed[0].read_bytes())
    with h5py.File(path, "a") as file:
        if change == "orientation":
            file["particles/trajectory/orientation/value"][1, 3] *= 1.001
        elif change == "step":
            file["particles/trajectory/position/step"][2] = 0
        elif change == "complete":
            file["edmd"].attrs["complete"] = False
        else:
            file["particles/trajectory/position/value"][1, 3] = np.nan
    assert main(["verify", str(path)]) in ((1, 2) if change == "position" else (1,))
    assert len(capsys.readouterr().err) > 20


@pytest.mark.parametrize("arguments", [
    ["-n", "0"], ["-n", "3"], ["-n", "-5"], ["--semi-axes", "1", "1", "0"], ["--semi-axes", "1", "1", "nan"], ["--rate", "0"],
    ["--rate", "-1"], ["--rate", "nan"], ["--until-pressure", "0.5"], ["--until-pressure", "1e30"], ["--start-fraction", "0.9"],
    ["--start-fraction", "-0.1"], ["--melt", "-1"], ["--seed", "-1"], ["-n", "many"], ["--semi-axes", "1", "1"], ["--no-such-option"],
])
def test_bad_input_to_pack(arguments, capsys, tmp_path, monkeypatch):
    """Exit status 2, one sentence, no traceback, nothing written."""
    monkeypatch.chdir(tmp_path)
    try:
        status = main([*SMALL, *arguments])
    except SystemExit as leaving:               # argparse's own way out
        status = leaving.code
    assert status == 2
    told = capsys.readouterr().err
    assert told.strip().splitlines()[-1].startswith("edmd")
    assert "Traceback" not in told
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("place", ["missing/x.h5md", "."])
def test_pack_where_nothing_can_be_written(place, capsys, tmp_path):
    assert main([*SMALL, "-o", str(tmp_path / place)]) == 2
    assert "output" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_pack_does_not_overwrite(packed, capsys, tmp_path):
    path = tmp_path / "taken.h5md"
    path.write_text("precious")
    assert main([*SMALL, "-o", str(path)]) == 2
    assert "exists already" in capsys.readouterr().err
    assert path.read_text() == "precious"
    assert main([*SMALL, "-o", str(path), "--overwrite", "--quiet"]) == 0
    assert capsys.readouterr().out == ""
    assert np.array_equal(read_system(path).positions, read_system(packed[0]).positions)


def test_render_of_a_movie(packed, capsys, tmp_path, monkeypatch):
    monkeypatch.setattr("analysis.shading.SKY_LAMPS", 6)             # they take most of the time
    order = ["render", str(packed[0]), "--size", "40", "40", "--frames"]
    movie = tmp_path / "movie"
    assert main([*order, ":3", "-o", str(movie)]) == 0
    assert sorted(path.name for path in movie.iterdir()) == ["00000.png", "00001.png", "00002.png"]
    assert f"-i {movie}/%05d.png" in capsys.readouterr().out
    assert main([*order, ":2", "-o", str(movie)]) == 2
    assert "not empty" in capsys.readouterr().err
    assert main([*order, ":2", "-o", str(movie), "--overwrite"]) == 0
    assert sorted(path.name for path in movie.iterdir()) == ["00000.png", "00001.png"]
    assert main([*order, ":2", "-o", str(tmp_path / "movie.gif")]) == 0
    assert (tmp_path / "movie.gif").read_bytes().startswith(b"GIF89a")
    assert main([*order, "7:3", "-o", str(tmp_path / "none")]) == 2
    assert "selects none" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["info", "verify", "plot", "render"])
@pytest.mark.parametrize("kind", ["missing", "text", "half", "folder"])
def test_bad_files(packed, command, kind, capsys, tmp_path):
    path = tmp_path / f"{kind}.h5md"
    if kind == "text":
        path.write_text("hello")
    elif kind == "half":
        whole = packed[0].read_bytes()
        path.write_bytes(whole[:len(whole) // 2])
    elif kind == "folder":
        path.mkdir()
    assert main([command, str(path)]) == 2
    told = capsys.readouterr().err
    assert told.startswith(f"edmd {command}: path = ")
    assert len(told.strip().splitlines()) == 1
    assert list(tmp_path.glob("*.png")) == []


@pytest.mark.parametrize("frame", ["1000", "-1000"])
def test_render_of_a_frame_that_is_not_there(packed, frame, capsys, tmp_path):
    assert main(["render", str(packed[0]), "--frame", frame, "-o", str(tmp_path / "x.png")]) == 2
    assert "frame" in capsys.readouterr().err
    assert not (tmp_path / "x.png").exists()


@pytest.mark.parametrize("arguments", [["--help"], ["--version"], ["pack", "--help"], ["info", "--help"], ["verify", "--help"],
                                       ["plot", "--help"], ["render", "--help"], ["export", "--help"], ["sweep", "--help"]])
def test_help(arguments, capsys):
    with pytest.raises(SystemExit) as leaving:
        main(arguments)
    assert leaving.value.code == 0
    assert "edmd" in capsys.readouterr().out


def test_help_is_quick():
    """Within 0.2 s, which no machine under load keeps: the best of five against the bare interpreter."""
    def seconds(*arguments):
        best = np.inf
        for _ in range(5):
            began = time.perf_counter()
            subprocess.run([sys.executable, *arguments], cwd=ROOT, capture_output=True, check=True)
            best = min(best, time.perf_counter() - began)
        return best

    assert seconds("-m", "edmd", "--help") - seconds("-c", "pass") < 0.2


def test_no_command_is_bad_input(capsys):
    with pytest.raises(SystemExit) as leaving:
        main([])
    assert leaving.value.code == 2
