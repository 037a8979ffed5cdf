"""Open a run with `mda.Universe("run.h5md")`: the topology and every frame of an edmd file, as MDAnalysis sees them.

MDAnalysis learns a format when the class that reads it is defined, so `import analysis` is all it takes. The layout is
docs/file_format.md.
"""

import os

import h5py
import numpy as np
from MDAnalysis.coordinates.core import triclinic_box
from MDAnalysis.coordinates.H5MD import H5MDReader
from MDAnalysis.core.topology import Topology
from MDAnalysis.core.topologyattrs import AtomAttr, Atomids, Atomtypes, Masses
from MDAnalysis.exceptions import NoDataError
from MDAnalysis.topology.base import TopologyReaderBase

SUFFIXES = (".h5md", ".h5", ".hdf5")
PARTICLES = "particles/trajectory"


def is_edmd_file(thing):
    """Is this the path of a file that edmd wrote? MDAnalysis asks it of everything a Universe is made from: it never raises."""
    if not isinstance(thing, (str, os.PathLike)):
        return False
    path = os.fspath(thing)
    if not isinstance(path, str) or not path.lower().endswith(SUFFIXES) or not os.path.isfile(path):
        return False
    try:
        with h5py.File(path, "r") as file:
            return file["h5md/creator"].attrs["name"] == "edmd"
    except (OSError, KeyError):
        return False


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
            raise NoDataError(f"{self.attrname}: these frames have none, they are not of an edmd file") from None


class Orientations(FrameAttribute):
    """`orientations` (n, 4): unit quaternions, scalar first, that turn the body's frame into the lab's."""

    attrname, singular, key = "orientations", "orientation", "orientation"


class SemiAxes(FrameAttribute):
    """`semi_axes` (n, 3): lengths, in the body's frame; they change under growth."""

    attrname, singular, key = "semi_axes", "semi_axes", "semi_axes"


class AngularVelocities(FrameAttribute):
    """`angular_velocities` (n, 3): radians a time, in the lab frame."""

    attrname, singular, key = "angular_velocities", "angular_velocity", "angular_velocity"


class EDMDParser(TopologyReaderBase):
    """The bodies of an edmd file as atoms: `types` are the species as text ("0", "1", ...), `masses`.

    `ids` and the frame attributes.
    """

    format = "EDMD"
    _format_hint = staticmethod(is_edmd_file)

    def parse(self, **kwargs):
        """The Topology; ValueError where the file has no frame yet."""
        with h5py.File(os.fspath(self.filename), "r") as file:
            particles = file[PARTICLES]
            frames, n = particles["position/value"].shape[:2]
            if frames == 0:
                raise ValueError(f"{self.filename}: no frames in the file; at least one is needed")
            types = particles["species"][()].astype(str).astype(object)
            standing = [Atomids(particles["id"][()]), Atomtypes(types), Masses(particles["mass"][()])]
            following = [Orientations(np.zeros((n, 4))), SemiAxes(np.zeros((n, 3))), AngularVelocities(np.zeros((n, 3)))]
            return Topology(n, 1, 1, attrs=standing + following)


class EDMDReader(H5MDReader):
    """The frames of an edmd file.

    As the stock reader, and besides: any of the suffixes .h5md, .h5, .hdf5; a path may be a Path; `dt` is the first
    interval between frames (1.0 when there is one frame; `ts.time` is exact for each); `ts.data["cell"]` (3, 3) holds the
    cell vectors as rows in full precision. The datasets are looked up once, which makes it about three times as fast.
    Lengths and times keep the file's units.
    """

    format = "EDMD"
    _format_hint = staticmethod(is_edmd_file)

    def __init__(self, filename, **kwargs):
        path = os.fspath(filename)
        kwargs.setdefault("dt", first_interval(path))
        super().__init__(path, **kwargs)

    def open_trajectory(self):
        super().open_trajectory()
        self._find_datasets()

    def _find_datasets(self):
        particles = self._file[PARTICLES]
        self._steps, self._times = particles["position/step"], particles["position/time"]
        self._edges, self._velocities = particles["box/edges/value"], particles["velocity/value"]
        self._observables = {name: group["value"] for name, group in self._file["observables"].items()}

    def __getstate__(self):
        state = super().__getstate__()
        for name in ("_steps", "_times", "_edges", "_velocities", "_observables"):
            del state[name]
        return state

    def __setstate__(self, state):
        super().__setstate__(state)
        self._find_datasets()

    def _read_frame(self, frame):
        if not 0 <= frame < self.n_frames:
            raise OSError(f"frame {frame} asked of {self.n_frames}")
        self._frame = frame
        ts = self.ts
        ts.frame, ts.time = frame, self._times[frame]
        ts.data["step"] = self._steps[frame]
        ts.data["cell"] = self._edges[frame]
        for name, values in self._observables.items():
            ts.data[name] = values[frame]
        ts.dimensions = triclinic_box(*ts.data["cell"])
        ts.positions = ts.data["position"]
        ts.velocities = self._velocities[frame]
        return ts


def first_interval(path):
    """Time between the first two frames of the file; 1.0 when there is only one."""
    with h5py.File(path, "r") as file:
        times = file[f"{PARTICLES}/position/time"][:2]
    return float(times[1] - times[0]) if len(times) == 2 else 1.0
