"""`edmd export`, and bad input to it and to edmd.export and edmd.read_system: words, exit status 2, nothing written."""

import sys

import fluids
import h5py
import numpy as np
import other_programs as other
import pytest

import edmd
from edmd.cli import main

GOOD = {"extxyz": "run.xyz", "lammps-data": "run.data", "lammps-dump": "run.dump"}       # gsd is optional


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A run of twelve frames."""
    path = tmp_path_factory.mktemp("export") / "run.h5md"
    with edmd.Trajectory(path, edmd.Every(collisions=10)) as trajectory:
        edmd.Simulation(fluids.fluid("prolate", 32, 0.3)).run(collisions=110, observers=[trajectory])
    return path


def refused(capsys, arguments, folder, words, kept=()):
    """Exit status 2, one line that says so, and only these files in the folder."""
    assert main(["export", *map(str, arguments)]) == 2
    told = capsys.readouterr().err.strip()
    assert told.startswith("edmd export: ")
    assert words in told
    assert len(told.splitlines()) == 1
    assert sorted(path.name for path in folder.iterdir()) == sorted(kept)


@pytest.mark.parametrize(("name", "options", "frames", "last"), [
    ("a.xyz", [], 12, 11), ("a.extxyz", ["--frames", "3:"], 9, 11), ("a.dump", ["--frames", "::5"], 3, 10),
    ("a.lammpstrj", ["--frames", "2"], 1, 2), ("a.data", [], 1, 11), ("a.data", ["--frames=-3"], 1, 9),
    ("a.xyz", ["--frames=-4:-1"], 3, 10),
    ("a.xyz", ["--frames", "::-1"], 12, 0), ("a.xyz", ["--format", "lammps-dump"], 12, 11), ("a.xyz", ["--frames", "10:99"], 2, 11),
])
def test_frames_and_formats(run, tmp_path, capsys, name, options, frames, last):
    assert main(["export", str(run), "-o", str(tmp_path / name), *options]) == 0
    told = capsys.readouterr().out
    assert f"frames  {frames}\n" in told
    assert str(tmp_path / name) in told
    assert [path.name for path in tmp_path.iterdir()] == [name]
    written = edmd.read_system(tmp_path / name, format="lammps-dump" if "--format" in options else None)
    assert written.positions == pytest.approx(edmd.read_system(run, last).positions, abs=1e-12)


def test_gsd_by_command(run, tmp_path):
    other.needs_format("gsd")
    assert main(["export", str(run), "-o", str(tmp_path / "run.gsd"), "--frames", "2:4"]) == 0
    assert edmd.read_system(tmp_path / "run.gsd", 1).orientations == pytest.approx(edmd.read_system(run, 3).orientations, abs=1e-6)


@pytest.mark.parametrize(("options", "words"), [
    (["-o", "out.pdb"], "no known suffix"), (["-o", "out"], ".lammpstrj"), (["-o", "out.xyz", "--format", "xyz"], "expected one of extxyz"),
    (["-o", "missing/out.xyz"], "does not exist"), (["-o", "."], "no known suffix"), (["-o", ".", "--format", "extxyz"], "folder"),
    (["-o", "out.xyz", "--frames", "12"], "of 12 frames"), (["-o", "out.xyz", "--frames=-13"], "of 12 frames"),
    (["-o", "out.xyz", "--frames", "20:"], "selects none of the 12"), (["-o", "out.xyz", "--frames", "a:b"], "expected an index"),
    (["-o", "out.xyz", "--frames", "1:2:3:4"], "expected an index"), (["-o", "out.xyz", "--frames", "::0"], "expected an index"),
    (["-o", "out.xyz", "--frames", ""], "expected an index"), (["-o", "out.data", "--frames", "2:4"], "holds one"),
])
def test_bad_options(run, options, words, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    refused(capsys, [run, *options], tmp_path, words)


def test_an_existing_file_is_kept_unless_told_otherwise(run, capsys, tmp_path):
    target = tmp_path / "run.xyz"
    target.write_text("precious")
    refused(capsys, [run, "-o", target], tmp_path, "exists already", ["run.xyz"])
    assert target.read_text() == "precious"
    assert main(["export", str(run), "-o", str(target), "--overwrite"]) == 0
    assert edmd.read_system(target).n == 32


def test_the_run_itself_is_never_overwritten(run, capsys, tmp_path):
    copy = tmp_path / "run.xyz"
    copy.write_bytes(run.read_bytes())
    refused(capsys, [copy, "-o", copy, "--overwrite"], tmp_path, "file to read", ["run.xyz"])
    assert copy.read_bytes() == run.read_bytes()


@pytest.mark.parametrize("kind", ["missing", "text", "half", "folder"])
def test_files_that_are_not_ours(run, kind, capsys, tmp_path):
    path = tmp_path / "in.h5md"
    if kind == "text":
        path.write_text("hello")
    elif kind == "half":
        path.write_bytes(run.read_bytes()[:5000])
    elif kind == "folder":
        path.mkdir()
    refused(capsys, [path, "-o", tmp_path / "out.xyz"], tmp_path, "path = ", [] if kind == "missing" else ["in.h5md"])


@pytest.mark.parametrize("format", GOOD)
def test_a_bad_frame_on_the_way_leaves_nothing(run, format, capsys, tmp_path):
    damaged, target = tmp_path / "in.h5md", tmp_path / GOOD[format]
    damaged.write_bytes(run.read_bytes())
    target.write_text("precious")
    with h5py.File(damaged, "a") as file:
        file["particles/trajectory/position/value"][11, 3] = np.nan
    refused(capsys, [damaged, "-o", target, "--overwrite"], tmp_path, "frame 11", ["in.h5md", target.name])
    assert target.read_text() == "precious"


@pytest.mark.parametrize(("problem", "status"), [(KeyboardInterrupt, 130), (OSError("no space left on device"), 1)])
def test_interrupted_or_out_of_space(run, problem, status, capsys, tmp_path, monkeypatch):
    from edmd.formats import extxyz

    lines = []

    def stop_at_the_third(*columns):
        lines.append(1)
        if len(lines) == 3:
            raise problem
        return "X\n"

    monkeypatch.setattr(extxyz, "table", stop_at_the_third)
    assert main(["export", str(run), "-o", str(tmp_path / "out.xyz")]) == status
    assert "frames already written" not in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_without_the_library_of_gsd(run, capsys, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "gsd", None)
    monkeypatch.setitem(sys.modules, "gsd.hoomd", None)
    refused(capsys, [run, "-o", tmp_path / "out.gsd"], tmp_path, "pip install")


def test_a_system_has_no_frames_to_choose_and_nothing_is_no_system(tmp_path):
    with pytest.raises(ValueError, match="frames = 0: a System is one state"):
        edmd.export(other.system(1), tmp_path / "a.xyz", frames=0)
    with pytest.raises(ValueError, match="source = None"):
        edmd.export(None, tmp_path / "a.xyz")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("format", other.FORMATS)
@pytest.mark.parametrize("damage", ["empty", "words", "noise", "half", "folder", "missing"])
def test_reading_what_is_no_such_file(format, damage, tmp_path):
    other.needs_format(format)
    path = tmp_path / f"in{other.FORMATS[format]}"
    edmd.export(other.system(2), path)
    whole = path.read_bytes()
    path.unlink()
    noise = np.random.default_rng(1).bytes(3000)
    if damage == "folder":
        path.mkdir()
    elif damage != "missing":
        path.write_bytes({"empty": b"", "words": b"hello\nworld\n", "noise": noise, "half": whole[:len(whole) // 2]}[damage])
    with pytest.raises(ValueError, match=r"^path = .*in\.") as told:
        edmd.read_system(path)
    assert len(str(told.value)) < 400


@pytest.mark.parametrize("format", other.FORMATS)
@pytest.mark.parametrize("frame", [1, -2, 0.5, "first", None])
def test_reading_a_frame_that_is_not_there(format, frame, tmp_path):
    other.needs_format(format)
    path = tmp_path / f"in{other.FORMATS[format]}"
    edmd.export(other.system(2), path)
    with pytest.raises(ValueError, match=r"^frame = "):
        edmd.read_system(path, frame)


@pytest.mark.parametrize(("name", "old", "new", "words"), [
    ("a.xyz", "aspherical_shape:R:3", "something:R:3", "semi_axes"),
    ("a.xyz", 'pbc="T T T"', 'pbc="T T F"', "pbc"),
    ("a.xyz", "\nX ", "\nQq ", "Qq"),
    ("a.data", "Ellipsoids\n", "Lines\n", "section Ellipsoids"),
    ("a.data", " 1 1 ", " 1 0 ", "ellipsoidflag"),
    ("a.data", "0.0 ", "x.0 ", "not a LAMMPS data file"),
    ("a.dump", "shapex", "size", "shapex"),
    ("a.dump", "quatw", "q", "quatw"),
    ("a.dump", "ITEM: NUMBER OF ATOMS\n1", "ITEM: NUMBER OF ATOMS\n2", "1 lines for 2 atoms"),
    ("a.dump", "ITEM: BOX BOUNDS", "ITEM: BOUNDS", "BOX BOUNDS"),
])
def test_reading_files_with_something_missing(name, old, new, words, tmp_path):
    path = tmp_path / name
    edmd.export(edmd.System([[1, 1, 1]], [[1, 0, 0, 0]], (1, 1, 2), 10, masses=8 * np.pi / 3), path)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(ValueError, match=r"^path = ") as told:
        edmd.read_system(path)
    assert words in str(told.value)
