"""Frame by frame: what the analyses here share. Each frame is answered by itself, so MDAnalysis may spread frames over processes."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import TYPE_CHECKING

import numpy as np
from MDAnalysis.analysis.backends import BackendBase, BackendMultiprocessing
from MDAnalysis.analysis.base import AnalysisBase
from MDAnalysis.analysis.results import ResultsGroup

from analysis.axes import body_axes
from ccd.annotations import Any, Floats

if TYPE_CHECKING:
    from MDAnalysis import AtomGroup


class FrameAnalysis(AnalysisBase):
    """A plain function applied to the atoms in every frame: `Subclass(u.atoms).run()`, `run(backend="multiprocessing", n_workers=4)`.

    A subclass names its `SERIES`, and `_frame` returns a value for each of them; in `results` each is an array with one row a frame, which
    `_conclude` may condense. Positions and cell are those of the file in float64 (`ts.data`), not those that a transformation has made;
    of files of other programs they are MDAnalysis' float32.
    """

    SERIES: tuple[str, ...] = ()
    _analysis_algorithm_is_parallelizable = True

    @classmethod
    def get_supported_backends(cls) -> tuple[str, ...]:
        return ("serial", "multiprocessing", "dask")

    def __init__(self, atomgroup: AtomGroup, **kwargs: Any) -> None:
        super().__init__(atomgroup.universe.trajectory, **kwargs)
        self.atomgroup = atomgroup

    def _prepare(self):
        for name in self.SERIES:
            self.results[name] = []

    def _single_frame(self):
        for name, value in zip(self.SERIES, self._frame(), strict=True):
            self.results[name].append(value)

    def _get_aggregator(self):
        return ResultsGroup(lookup=dict.fromkeys(self.SERIES, ResultsGroup.flatten_sequence))

    def _conclude(self):
        for name in self.SERIES:
            self.results[name] = np.array(self.results[name])

    @property
    def positions(self) -> Floats:
        data = self._ts.data
        return data["position"][self.atomgroup.ix] if "position" in data else self.atomgroup.positions.astype(float)

    @property
    def cell(self) -> Floats:
        return cell_of(self._ts)

    @property
    def bodies(self) -> tuple[Floats, Floats, Floats]:
        """Positions (n, 3), orientations (n, 4) and semi-axes (n, 3)."""
        return self.positions, self.atomgroup.orientations, self.atomgroup.semi_axes

    @property
    def axes(self) -> Floats:
        """The body axes in the lab (n, 3)."""
        return body_axes(self.atomgroup.orientations, self.atomgroup.semi_axes)


class ThreadedAnalysis(FrameAnalysis):
    """A FrameAnalysis whose function keeps all cores busy by threads: processes gain where much of a frame's work is outside them.

    MDAnalysis' "multiprocessing" forks, and a fork of a process whose threads have run never comes back: its processes start afresh here,
    as those of "dask" do anyway.
    """

    def _configure_backend(self, *args, **kwargs):
        backend = super()._configure_backend(*args, **kwargs)
        return FreshProcesses(backend.n_workers) if isinstance(backend, BackendMultiprocessing) else backend


class FreshProcesses(BackendBase):
    """Processes that begin with nothing of this one, and share the cores between them."""

    def apply(self, func: Callable, computations: list) -> list:
        threads = max(1, (os.cpu_count() or 1) // self.n_workers)
        with ProcessPoolExecutor(self.n_workers, get_context("spawn"), share_cores, (threads,)) as pool:
            return list(pool.map(func, computations))


def share_cores(threads):
    import numba

    numba.set_num_threads(min(threads, numba.config.NUMBA_NUM_THREADS))


def cell_of(ts):
    """The cell vectors of a frame as rows (3, 3), in the precision of its file."""
    return np.asarray(ts.data.get("cell", ts.triclinic_dimensions), dtype=float)
