"""A System or a run to the files of other programs, and back: extended XYZ, GSD, LAMMPS data and dump (docs/file_format.md)."""

from __future__ import annotations

import importlib
import operator
import os
from pathlib import Path

from ccd.annotations import Any, AnyPath, ArrayLike
from edmd.outputs import check_output, written_whole
from edmd.system import System, wrap
from edmd.trajectory import Frame, frame_of, open_run
from edmd.trajectory import read_system as read_h5md

SUFFIXES = {".xyz": "extxyz", ".extxyz": "extxyz", ".gsd": "gsd", ".data": "lammps-data", ".dump": "lammps-dump",
            ".lammpstrj": "lammps-dump"}
FORMATS = tuple(dict.fromkeys(SUFFIXES.values()))
ONE_FRAME = ("edmd.formats.lammps_data",)


def export(source: System | AnyPath, path: AnyPath, format: str | None = None, frames: Any = None, overwrite: bool = False,
           progress: bool = False) -> int:
    """Write a System, or frames of a run, for other programs to read.

    source: a System, or the path of an H5MD file of ours. path: the file to write; it appears when it is complete, and an existing one is
    refused unless overwrite is true. format: "extxyz", "gsd", "lammps-data" or "lammps-dump", else told by the suffix (.xyz, .extxyz;
    .gsd; .data; .dump, .lammpstrj). frames, of a file: an index, a slice, or text such as "10:", "::5", "-1"; default all, or the last
    for LAMMPS data, which hold one. progress: a bar, on a terminal. What each format keeps, and how exactly: docs/file_format.md.

    -> the number of frames written. ValueError in words for bad input, before anything is written.
    """
    room = _room(path, format)
    if isinstance(source, System):
        if frames is not None:
            raise ValueError(f"frames = {frames!r}: a System is one state; expected None")
        whole = source.copy()
        whole.positions, images = wrap(source.positions, source.box)
        _write(room, check_output(path, overwrite), [Frame(whole, images)])
        return 1
    if not isinstance(source, str | os.PathLike):
        raise ValueError(f"source = {source!r}: expected a System or the path of a run")
    with open_run(source) as file:
        if Path(path).exists() and Path(path).samefile(source):
            raise ValueError(f"output = {str(path)!r}: is the file to read; expected another name")
        path, one = check_output(path, overwrite), room.__name__ in ONE_FRAME
        indices = selected(-1 if frames is None and one else frames, len(file["particles/trajectory/position/step"]))
        if one and len(indices) > 1:
            raise ValueError(f"frames = {frames!r}: selects {len(indices)} frames, and a LAMMPS data file holds one; expected one index")
        _write(room, path, (frame_of(file, source, index) for index in (_shown(indices) if progress else indices)))
        return len(indices)


def read_system(path: AnyPath, frame: int = -1, format: str | None = None, inertia: str | ArrayLike | None = None) -> System:
    """The System of a frame of an H5MD file of ours, in full precision, or of extended XYZ, GSD, LAMMPS data or dump, ours or another's.

    format: "h5md", "extxyz", "gsd", "lammps-data" or "lammps-dump", else told by the suffix, and H5MD for any other. inertia: as in
    System, in place of what the file has (H5MD, GSD and extended XYZ have the moments; LAMMPS files do not: "solid").

    ValueError when the file is none of these or has no such frame.
    """
    try:
        frame = operator.index(frame)
    except TypeError:
        raise ValueError(f"frame = {frame!r}: expected a whole number; negative counts from the end") from None
    if format == "h5md" or (format is None and Path(path).suffix.lower() not in SUFFIXES):
        system = read_h5md(path, frame)
        return system if inertia is None else System(system.positions, system.orientations, system.semi_axes, system.box, system.velocities,
                                                     system.angular_velocities, system.masses, inertia, system.species)
    room = _room(path, format)
    if not Path(path).is_file():
        raise ValueError(f"path = {str(path)!r}: no such file")
    try:
        return room.read(path, frame, inertia)
    except ValueError as problem:
        if str(problem).startswith(("path", "frame", "format")):
            raise
        raise ValueError(f"path = {str(path)!r}: {problem}") from None


def _room(path, format):
    """The module of a format, given by name or by the suffix of the path."""
    if format is None:
        format = SUFFIXES.get(Path(path).suffix.lower())
        if format is None:
            raise ValueError(f"path = {str(path)!r}: no known suffix; expected one of {', '.join(SUFFIXES)}, or a format")
    elif format not in FORMATS:
        raise ValueError(f"format = {format!r}: expected one of {', '.join(FORMATS)}")
    return importlib.import_module(f"edmd.formats.{format.replace('-', '_')}")


def selected(frames, count):
    """The indices from 0, as a range."""
    what = f"an index, a slice, or text such as '10:', '::5', '-1', of {count} frames"
    if isinstance(frames, str):
        try:
            bounds = [int(bound) if bound.strip() else None for bound in frames.split(":")]
            frames = slice(*bounds) if ":" in frames else int(frames)
        except (ValueError, TypeError):
            raise ValueError(f"frames = {frames!r}: expected {what}") from None
    try:
        chosen = range(count)[slice(None) if frames is None else frames]
    except (IndexError, ValueError, TypeError):
        raise ValueError(f"frames = {frames!r}: expected {what}") from None
    chosen = range(chosen, chosen + 1) if isinstance(chosen, int) else chosen
    if not chosen:
        raise ValueError(f"frames = {frames!r}: selects none of the {count} frames")
    return chosen


def _shown(indices):
    """The indices, with a bar that tqdm draws on a terminal only."""
    from tqdm import tqdm

    return tqdm(indices, unit="frame", leave=False, disable=None)


def _write(room, path, frames):
    with written_whole(path) as partial:
        room.write(partial, frames)
