"""Killed between any two of its writes, a file is put back to where it was last whole."""

import os

import h5py
import numpy as np
import pytest

from edmd import journal
from edmd.journal import BeingWritten, JournaledFile, journal_path, put_back

FRAMES = 150


@pytest.fixture
def moments(tmp_path, monkeypatch):
    """(file, journal, frames that were flushed) as a kill would leave them after every single change of either file."""
    path, kept, flushed = tmp_path / "run.h5", [], [None]

    def remembering(change):
        def changed(*arguments):
            change(*arguments)
            if flushed[0] is not None:
                kept.append((path.read_bytes(), journal_path(path).read_bytes(), flushed[0]))
        return changed

    monkeypatch.setattr(journal, "_write_all", remembering(journal._write_all))
    monkeypatch.setattr(os, "ftruncate", remembering(os.ftruncate))
    disk = JournaledFile(path, "x")
    with h5py.File(disk, "w") as file:
        series = [file.create_dataset(name, (0, 3), maxshape=(None, 3), chunks=(1, 3), dtype=float) for name in "ab"]
        for frame in range(FRAMES):
            for values in series:
                values.resize(frame + 1, axis=0)
                values[frame] = frame
            if frame % 10 == 9:
                file.flush()
                disk.commit()
                flushed[0] = frame + 1
    disk.commit()
    disk.close()
    monkeypatch.undo()
    return kept


def readable(path, frames):
    """Whether so many frames are there, each with its numbers."""
    try:
        with h5py.File(path, "r") as file:
            return all(len(file[name]) >= frames and (file[name][:frames] == np.arange(frames)[:, None]).all() for name in "ab")
    except OSError:
        return False


def test_killed_between_any_two_writes(moments, tmp_path):
    path, broken = tmp_path / "killed.h5", 0
    assert len(moments) > 300
    for file, kept, frames in moments:
        path.write_bytes(file)
        journal_path(path).write_bytes(kept)
        broken += not readable(path, frames)
        put_back(path)
        assert readable(path, frames)
        assert not journal_path(path).exists()
    assert broken, "no moment was dangerous: this test would see nothing"


def test_killed_while_a_record_was_written(moments, tmp_path):
    """A record that is not whole is of something that was not changed yet."""
    path = tmp_path / "killed.h5"
    _, kept, frames = max(moments, key=lambda moment: len(moment[1]))
    before = next(file for file, _, flushed in moments if flushed == frames)
    path.write_bytes(before)
    journal_path(path).write_bytes(kept[:20])
    put_back(path)
    assert path.read_bytes() == before


def test_a_file_is_written_by_one_process(tmp_path):
    path = tmp_path / "run.h5"
    disk = JournaledFile(path, "x")
    for another in (lambda: JournaledFile(path, "r+"), lambda: JournaledFile(path, "w"), lambda: put_back(path)):
        with pytest.raises(BeingWritten, match=r"run\.h5.*another process"):
            another()
    disk.close()
    JournaledFile(path, "r+").close()
    with pytest.raises(FileExistsError):
        JournaledFile(path, "x")
    assert list(tmp_path.iterdir()) == [path]


def test_after_a_full_disk_the_file_is_as_it_was(tmp_path, monkeypatch):
    path = tmp_path / "run.h5"
    disk = JournaledFile(path, "x")
    with h5py.File(disk, "w") as file:
        file["a"] = np.arange(1000)
    disk.commit()
    disk.close()
    whole = path.read_bytes()

    def full(*arguments):
        raise OSError(28, "No space left on device")

    disk = JournaledFile(path, "r+")
    file = h5py.File(disk, "r+")
    file["a"][:500] = 0
    file.flush()
    monkeypatch.setattr(os, "pwrite", full)
    file["b"] = np.arange(10_000)
    file.flush()
    with pytest.raises(OSError, match="No space"):
        disk.commit()
    monkeypatch.undo()
    file.close()
    disk.close()
    assert path.read_bytes() == whole
    assert list(tmp_path.iterdir()) == [path]


def test_a_journal_without_its_file_is_of_no_consequence(moments, tmp_path):
    path = tmp_path / "new.h5"
    _, kept, _ = max(moments, key=lambda moment: len(moment[1]))
    journal_path(path).write_bytes(kept)
    put_back(path)
    disk = JournaledFile(path, "x")
    disk.write(b"hello")
    disk.commit()
    disk.close()
    assert path.read_bytes() == b"hello"
