"""Open a run with `mda.Universe("run.h5md")`: the topology and every frame of an edmd file, as MDAnalysis sees them.

MDAnalysis learns a format when the class that reads it is defined, so `import analysis` is all it takes. The layout is
docs/file_format.md.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import numpy as np
from MDAnalysis.coordinates.core import triclinic_box
from MDAnalysis.coordinates.H5MD import H5MDReader, H5PYPicklable
from MDAnalysis.core.topology import Topology
from MDAnalysis.core.topologyattrs import AtomAttr, Atomids, Atomtypes, Masses
from MDAnalysis.exceptions import NoDataError
from MDAnalysis.topology.base import TopologyReaderBase

from ccd.annotations import Any, AnyPath

if TYPE_CHECKING:
    from MDAnalysis.coordinates.timestep import Timestep

HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
FORMAT = 1                      # the newest edmd.attrs["format"] that is understood here
PARTICLES = "particles/trajectory"


class RunFile(H5PYPicklable):
    """An HDF5 file open for reading, also while a run still writes it; it pickles by its name."""

    def __init__(self, name, mode="r", driver=None):
        try:
            super().__init__(name, mode, driver=driver)
        except OSError:                         # a run holds it, or this process has it open in this way: HDF5 wants both alike
            super().__init__(name, mode, driver=driver, locking=False)


def is_edmd_file(thing):
    """Is this the path of a file that edmd wrote, whatever its suffix? MDAnalysis asks it of everything a Universe is made from.

    It never raises.
    """
    if not isinstance(thing, (str, os.PathLike)) or not isinstance(os.fspath(thing), str):
        return False
    path = os.fspath(thing)
    if not os.path.isfile(path):                # a pipe would wait for a writer
        return False
    try:
        with open(path, "rb") as file:
            if file.read(len(HDF5_SIGNATURE)) != HDF5_SIGNATURE:
                return False
        with RunFile(path) as file:
            return file["h5md/creator"].attrs["name"] == "edmd"
    except (OSError, KeyError):
        return False


def frame_series(file):
    """All that has one row a frame in an open file: a dict of datasets, "step", "time", "cell", "velocity" and the observables."""
    particles = file[PARTICLES]
    return {"step": particles["position/step"], "time": particles["position/time"], "cell": particles["box/edges/value"],
            "velocity": particles["velocity/value"], **{name: group["value"] for name, group in file["observables"].items()}}


def whole_frames(series):
    """How many frames are there in every series: of a run that was killed the last may be written in part."""
    return min(map(len, series.values()))


class FrameAttribute(AtomAttr):
    """One row an atom that follows the frame: a view of `ts.data[key]`, float64, where topology attributes stand still."""

    def get_atoms(self, ag):
        return self._frame_values(ag)[ag.ix]

    def set_atoms(self, ag, values):
        self._frame_values(ag)[ag.ix] = values

    def _frame_values(self, ag):
        try:
            return ag.universe.trajectory.ts.data[self.key]
        except KeyError:
            raise NoDataError(f"{self.attrname}: these frames have none; they are not read from an edmd file") from None


class Orientations(FrameAttribute):
    """`orientations` (n, 4): unit quaternions, scalar first, that turn the body's frame into the lab's."""

    attrname, singular, key = "orientations", "orientation", "orientation"


class SemiAxes(FrameAttribute):
    """`semi_axes` (n, 3): lengths, in the body's frame; they change under growth."""

    attrname, singular, key = "semi_axes", "semi_axes", "semi_axes"


class AngularVelocities(FrameAttribute):
    """`angular_velocities` (n, 3): radians a time, in the lab frame."""

    attrname, singular, key = "angular_velocities", "angular_velocity", "angular_velocity"


class UnwrappedPositions(FrameAttribute):
    """`unwrapped_positions` (n, 3): where the centres would be had they never been put back into the cell.

    Position plus image times the frame's cell vectors, float64. `atoms.positions` are float32 and inside the cell.
    """

    attrname, singular, key = "unwrapped_positions", "unwrapped_position", "position"

    def get_atoms(self, ag):
        return unwrapped(ag.universe.trajectory.ts)[ag.ix]

    def set_atoms(self, ag, values):
        raise AttributeError("unwrapped_positions: they follow from the positions, images and cell of the frame; set atoms.positions")


class Species(AtomAttr):
    """`species` (n,): whole numbers; `select_atoms("species 1")`, `select_atoms("species 0:2")`."""

    attrname, singular, dtype = "species", "species", int

    @staticmethod
    def _gen_initial_values(n_atoms, n_residues, n_segments):
        return np.zeros(n_atoms, dtype=int)


def unwrapped(ts):
    """Unwrapped positions (n, 3) of a frame of an edmd file, float64: position + image @ cell."""
    try:
        return ts.data["position"] + ts.data["image"] @ ts.data["cell"]
    except KeyError:
        raise NoDataError("unwrapped_positions: these frames have no images, they are not of an edmd file") from None


def unwrap(ts: Timestep) -> Timestep:
    """A transformation of MDAnalysis: `universe.trajectory.add_transformations(analysis.unwrap)` gives unwrapped `atoms.positions`.

    For MDAnalysis' own EinsteinMSD, and whatever follows a body through the cell's faces. Float32, as all `atoms.positions`.
    """
    ts.positions = unwrapped(ts)
    return ts


unwrap.parallelizable = True                # type: ignore[attr-defined]  # each frame by itself: MDAnalysis asks before it spreads frames over processes


class EDMDParser(TopologyReaderBase):
    """The bodies of an edmd file as atoms: `species`, `types` (the species as text: "0", "1", ...), `masses`, `ids`.

    And the attributes that follow the frame.
    """

    format = "EDMD"
    _format_hint = staticmethod(is_edmd_file)

    def parse(self, **kwargs: Any) -> Topology:
        """The Topology; ValueError where the file has no frame yet, or is of a newer format than this reader knows."""
        with RunFile(os.fspath(self.filename)) as file:
            written = int(file["edmd"].attrs["format"])
            if written > FORMAT:
                raise ValueError(f"{self.filename}: format {written} is newer than this version of analysis knows ({FORMAT})")
            if whole_frames(frame_series(file)) == 0:
                raise ValueError(f"{self.filename}: no frames in the file; at least one is needed")
            particles = file[PARTICLES]
            n, species = particles["position/value"].shape[1], particles["species"][()]
            standing = [Atomids(particles["id"][()]), Atomtypes(species.astype(str).astype(object)), Masses(particles["mass"][()]),
                        Species(species)]
            following = [kind(np.zeros((n, width))) for kind, width in
                         ((Orientations, 4), (SemiAxes, 3), (AngularVelocities, 3), (UnwrappedPositions, 3))]
            return Topology(n, 1, 1, attrs=standing + following)


class EDMDReader(H5MDReader):
    """The frames of an edmd file.

    As the stock reader, and besides: any suffix; a path may be a str or a Path; a file that is still being written opens too, with the
    frames that are whole by then; `dt` is the first interval between frames (1.0 when there is one frame; `ts.time` is exact
    for each); `ts.data["cell"]` (3, 3) holds the cell vectors as rows in full precision, `ts.data["position"]` (n, 3) the
    positions. A frame is read when it is asked for (the first on opening). The datasets are looked up once, which makes it
    about four times as fast. Lengths and times keep the file's units.
    """

    format = "EDMD"
    _format_hint = staticmethod(is_edmd_file)

    def __init__(self, filename: AnyPath, **kwargs: Any) -> None:
        path = os.fspath(filename)
        kwargs.setdefault("dt", first_interval(path))
        super().__init__(path, **kwargs)

    def open_trajectory(self) -> Any:
        self._frame = -1
        self._file = RunFile(self.filename)
        self._particle_group = self._file[PARTICLES]
        self._find_datasets()

    @property
    def n_frames(self) -> int:
        """Whole frames in the file when it was opened."""
        return self._n_frames

    def _find_datasets(self):
        self._series = frame_series(self._file)
        self._n_frames = whole_frames(self._series)

    def __getstate__(self):
        state = super().__getstate__()
        del state["_series"]
        return state

    def __setstate__(self, state):
        super().__setstate__(state)
        self._find_datasets()

    def _read_frame(self, frame):
        if not 0 <= frame < self.n_frames:
            raise OSError(f"frame {frame} asked of {self.n_frames}")
        self._frame = frame
        ts = self.ts
        values = {name: series[frame] for name, series in self._series.items()}
        ts.frame, ts.time = frame, values.pop("time")
        ts.dimensions = triclinic_box(*values["cell"])
        ts.positions = values["position"]
        ts.velocities = values.pop("velocity")
        ts.data.update(values)
        return ts


def first_interval(path):
    """Time between the first two frames of the file; 1.0 when there is only one."""
    with RunFile(path) as file:
        times = file[f"{PARTICLES}/position/time"][:2]
    return float(times[1] - times[0]) if len(times) == 2 else 1.0
