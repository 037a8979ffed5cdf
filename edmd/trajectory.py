"""Trajectories in H5MD (docs/file_format.md): an observer that writes them, and the way back to a System."""

from __future__ import annotations

import json
import time
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import h5py
import numpy as np

import edmd
from ccd.annotations import Any, AnyPath
from edmd.averages import Interval
from edmd.journal import BeingWritten, JournaledFile, put_back
from edmd.observers import Every, Observer
from edmd.outputs import check_output
from edmd.provenance import provenance
from edmd.system import System, wrap
from edmd.tolerances import OVERLAP

if TYPE_CHECKING:
    from edmd.observers import Schedule, View

FORMAT = 1
FLUSH_SECONDS = 1.0
SELDOM = 20             # frames are flushed at once unless flushing would take more than one part in so many of the time
LOG_CHUNK = 1024
UNITS = {"position": "Angstrom", "velocity": "Angstrom ps-1"}      # MDAnalysis' base units: the numbers stay as they are
VECTORS = ("velocity", "angular_velocity", "semi_axes", "moments")
SERIES = ("packing_fraction", "pressure", "reduced_pressure", "temperature", "energy", "collisions")
LOG = ("time", "collisions", "packing_fraction", "reduced_pressure", "pressure", "temperature", "collision_rate")


class Trajectory(Observer):
    """Writes what it sees to an H5MD file; a context manager, for one or several runs of one simulation.

    when: Every(...), Logarithmic(...) or Milestones(...). The first and the last state of every run are frames too, each state once.
    Every upkeep interval becomes a row of the log. Flushed at least every second while events go on. parameters: recorded in the file;
    start: so is this digest of the state it all starts from. An existing file is refused unless overwrite is true.
    """

    def __init__(self, path: AnyPath, when: Schedule | None = None, parameters: dict[str, Any] | None = None, overwrite: bool = False,
                 start: str | None = None) -> None:
        super().__init__(when if when is not None else Every(collisions_per_particle=100))
        self.path = check_output(path, overwrite)
        self._parameters, self._start = parameters or {}, start
        self._overwrite, self._closed = overwrite, False
        self._file: Any = None
        self._rows: list[Any] = []

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        self.close(complete=kind is None)

    def close(self, complete: bool = True) -> None:
        self._closed = True
        if self._file is not None:
            try:
                if self._disk.failure is None:
                    self._write_log()
                    self._file["edmd"].attrs["complete"] = complete
            finally:
                self._end()

    def _end(self):
        file, self._file = self._file, None
        file.close()
        try:
            self._disk.commit()
        finally:
            self._disk.close()

    def memory(self) -> dict[str, Any]:
        """Its place in the file, which is flushed."""
        self._flush()
        return {**super().memory(), "frames": len(self._file["particles/trajectory/position/step"]),
                "rows": len(self._file["edmd/log/time"]), "since": self._since, "begun": self._begun}

    def restore(self, memory: dict[str, Any]) -> None:
        """Go on in the file of the trajectory whose memory this is; what was written after that is cut off."""
        super().restore(memory)
        self._since, self._begun = Interval(*memory["since"]), Interval(*memory["begun"])
        self._rows, self._flushed, self._flush_seconds = [], time.monotonic(), 0.0
        self._disk = JournaledFile(self.path, "r+")
        self._file = h5py.File(self._disk, "r+")
        lengths = [*((series, memory["frames"]) for series in _frame_series(self._file)),
                   *((series, memory["rows"]) for series in self._file["edmd/log"].values())]
        for series, length in lengths:
            if len(series) < length:
                problem = f"{series.name} has {len(series)} entries, and the checkpoint was made after {length}"
                self._end()
                raise ValueError(f"path = {str(self.path)!r}: {problem}; expected the file that belongs to the checkpoint, whole")
        for series, length in lengths:
            series.resize(length, axis=0)

    def start(self, view: View) -> None:
        if self._closed:
            raise ValueError(f"output = {str(self.path)!r}: this trajectory is closed; expected a new one for another file")
        if self._file is None:
            self._create(view)
        self._since, self._begun = Interval(), view.begun
        self._frame(view)

    def upkeep(self, view: View) -> None:
        self._since, self._begun = self._since.plus(view.interval).minus(self._begun), Interval()
        means = view.means
        self._rows.append((view.time, view.collisions, view.packing_fraction, means.reduced_pressure, means.pressure, means.temperature,
                           means.collision_rate))
        if time.monotonic() - self._flushed > FLUSH_SECONDS:
            self._flush()

    def see(self, view: View) -> None:
        self._frame(view)
        if time.monotonic() - self._flushed > SELDOM * self._flush_seconds:
            self._flush()

    def finish(self, view: View) -> None:
        self._frame(view)
        self._file["edmd"].attrs["contact_time_collisions"] = view.contact_time_collisions
        self._flush()

    def _frame(self, view):
        steps = self._file["particles/trajectory/position/step"]
        at = self._file["particles/trajectory/position/time"]
        frame = len(steps)
        if frame and steps[-1] == view.collisions and at[-1] == view.time:
            return
        system, means = view.system, view.means_over(self._since.plus(view.begun).minus(self._begun))
        self._since, self._begun = Interval(), view.begun
        values = {"position": system.positions, "image": view.images, "orientation": system.orientations, "velocity": system.velocities,
                  "angular_velocity": system.angular_velocities, "semi_axes": system.semi_axes, "moments": system.moments}
        group = self._file["particles/trajectory"]
        for name, value in values.items():
            _append(group[f"{name}/value"], frame, value)
        _append(group["box/edges/value"], frame, system.box)
        series = {"packing_fraction": view.packing_fraction, "pressure": means.pressure, "reduced_pressure": means.reduced_pressure,
                  "temperature": view.temperature, "energy": view.energy, "collisions": view.collisions}
        for name, value in series.items():
            _append(self._file[f"observables/{name}/value"], frame, value)
        _append(at, frame, view.time)
        _append(steps, frame, view.collisions)       # last: a frame counts when its step is there

    def _create(self, view):
        system, n = view.system, view.n
        self._disk = JournaledFile(self.path, "w" if self._overwrite else "x")
        self._file = file = h5py.File(self._disk, "w")
        self._rows, self._flushed, self._flush_seconds = [], time.monotonic(), 0.0
        header = file.create_group("h5md")
        header.attrs["version"] = np.array([1, 1], dtype=np.int32)
        header.create_group("author").attrs["name"] = "edmd"
        header.create_group("creator").attrs.update({"name": "edmd", "version": edmd.__version__})
        group = file.create_group("particles/trajectory")
        position = _series(group, "position", (n, 3))
        step, at = _grow(position, "step", (), np.int64), _grow(position, "time", ())
        position["value"].attrs["unit"] = UNITS["position"]
        at.attrs["unit"] = "ps"
        position.attrs["unit"] = UNITS["position"]
        box = group.create_group("box")
        box.attrs["dimension"] = 3
        box.attrs["boundary"] = ["periodic"] * 3
        for element in (_series(group, "image", (n, 3), np.int32), _series(group, "orientation", (n, 4)), _series(box, "edges", (3, 3)),
                        *(_series(group, name, (n, 3)) for name in VECTORS)):
            element["step"], element["time"] = step, at
        group["velocity/value"].attrs["unit"] = UNITS["velocity"]
        box["edges/value"].attrs["unit"] = UNITS["position"]
        group["species"], group["id"], group["mass"] = system.species, np.arange(n, dtype=np.int32), system.masses
        observables = file.create_group("observables")
        for name in ("position", "orientation", "angular_velocity", "semi_axes", "image"):
            observables[name] = group[name]
        for name in SERIES:
            element = _series(observables, name, ())
            element["step"], element["time"] = step, at
        own = file.create_group("edmd")
        own.attrs.update({"format": FORMAT, "complete": False, "rule": json.dumps(view.rule.document()),
                          **provenance(self._parameters, view.seed, self._start)})
        for name in LOG:
            _grow(own.require_group("log"), name, (), chunk=LOG_CHUNK)

    def _flush(self):
        began = time.monotonic()
        self._write_log()
        self._file.flush()
        self._disk.commit()
        self._flushed = time.monotonic()
        self._flush_seconds = self._flushed - began

    def _write_log(self):
        if self._rows:
            log = self._file["edmd/log"]
            first, more = len(log["time"]), len(self._rows)
            for name, column in zip(LOG, np.array(self._rows, dtype=float).T):
                log[name].resize(first + more, axis=0)
                log[name][first:] = column
            self._rows = []


def _series(group, name, shape, dtype=np.float64):
    element = group.create_group(name)
    _grow(element, "value", shape, dtype)
    return element


def _grow(group, name, shape, dtype=np.float64, chunk=1):
    """An empty dataset that grows along its first axis; frames are chunks of one, single numbers of many."""
    chunk = chunk if shape else max(chunk, LOG_CHUNK)
    return group.create_dataset(name, (0, *shape), maxshape=(None, *shape), chunks=(chunk, *shape), dtype=dtype)


def _frame_series(file):
    """Every dataset that has an entry a frame."""
    found = []
    for group in (file["particles/trajectory"], file["observables"]):
        group.visititems(lambda _, item: found.append(item) if isinstance(item, h5py.Dataset) and item.maxshape[:1] == (None,) else None)
    return found


def _append(dataset, frame, value):
    dataset.resize(frame + 1, axis=0)
    dataset[frame] = value


def open_run(path):
    """The h5py.File of a run, for reading, even while it is being written; ValueError in words when it is none of ours."""
    path = Path(path)
    if not path.is_file():
        raise ValueError(f"path = {str(path)!r}: {'is a folder' if path.is_dir() else 'no such file'}; expected a run, NAME.h5md")
    with suppress(BeingWritten, PermissionError):
        put_back(path)
    try:
        try:
            file = h5py.File(path, "r")
        except BlockingIOError:                 # it is being written
            file = h5py.File(path, "r", locking=False)
    except OSError:
        raise ValueError(f"path = {str(path)!r}: not an HDF5 file, or a truncated one") from None
    try:
        written = int(file["edmd"].attrs["format"])
        frames = len(file["particles/trajectory/position/step"])
    except (KeyError, OSError):
        file.close()
        raise ValueError(f"path = {str(path)!r}: not a trajectory written by edmd, or a truncated one") from None
    if written > FORMAT or frames == 0:
        file.close()
        raise ValueError(f"path = {str(path)!r}: " + ("no frame was written" if written <= FORMAT else
                                                      f"format {written} is newer than this version of edmd knows ({FORMAT})"))
    return file


def read_system(path, frame=-1):
    """The System of a frame, in full precision, with its velocities, semi-axes, moments of inertia and cell.

    ValueError when the file is not ours or has no such frame.
    """
    with open_run(path) as file:
        frames = len(file["particles/trajectory/position/step"])
        if not -frames <= frame < frames:
            raise ValueError(f"frame = {frame}: expected one from {-frames} to {frames - 1}")
        return frame_of(file, path, frame % frames).system


class Frame(NamedTuple):
    """A state as files keep it: the bodies inside the cell, the images (n, 3) they were in, time, and collisions so far."""

    system: System
    images: np.ndarray
    time: float = 0.0
    step: int = 0


def frame_of(file, path, frame):
    """The Frame of this index, from 0, in a file that `open_run` opened."""
    group = file["particles/trajectory"]
    try:
        value = {name: group[f"{name}/value"][frame] for name in ("position", "orientation", *VECTORS)}
        box = group["box/edges/value"][frame]
        images, masses, species = group["image/value"][frame], group["mass"][:], group["species"][:]
        at, step = group["position/time"][frame], group["position/step"][frame]
    except (OSError, KeyError, IndexError) as problem:
        raise ValueError(f"path = {str(path)!r}: frame {frame} is not whole, the file was truncated or changed "
                         f"({problem.args[0]})") from None
    if not np.isfinite(value["position"]).all():
        raise ValueError(f"path = {str(path)!r}: frame {frame} has positions that are not finite")
    inside, more = wrap(value["position"], box)
    system = System(inside, value["orientation"], value["semi_axes"], box, value["velocity"], value["angular_velocity"], masses,
                    value["moments"], species)
    return Frame(system, images + more, float(at), int(step))


def verify_file(path):
    """Check every frame: unit quaternions, steps in order, no overlap.

    -> number of frames, the smallest scale at which a pair touches (below 1: an overlap), and a list of what is wrong in words.
    """
    wrong, smallest, before = [], np.inf, [-1.0, -np.inf]
    with open_run(path) as file:
        frames = len(file["particles/trajectory/position/step"])
        for frame in range(frames):
            try:
                system = frame_of(file, path, frame).system
            except ValueError as problem:
                wrong.append(str(problem))
                continue
            scale = system.smallest_scale()
            smallest = min(smallest, scale)
            if scale < 1 - OVERLAP:
                wrong.append(f"frame {frame}: two bodies overlap, they touch when scaled by {scale!r}")
            length = np.sqrt((file["particles/trajectory/orientation/value"][frame]**2).sum(axis=1))
            if abs(length - 1).max() > 1e-12:
                wrong.append(f"frame {frame}: an orientation has length {length[abs(length - 1).argmax()]!r}")
            now = [float(file[f"particles/trajectory/position/{name}"][frame]) for name in ("step", "time")]
            if now[0] < before[0] or now[1] < before[1]:
                wrong.append(f"frame {frame}: step and time {now} come after {before}")
            before = now
        if not file["edmd"].attrs["complete"]:
            wrong.append("the run did not end as it should: the file is marked incomplete")
    return frames, smallest, wrong
