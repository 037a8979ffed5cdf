import h5py
import numpy as np
import pytest
from runs import fcc, write_run

import analysis


def test_a_touching_crystal_of_parallel_spheroids(tmp_path):
    positions, cell = fcc(2)
    stretch = np.array([1, 1, 2.0])
    scale = np.array([0.9, 1.0])[:, None, None]
    axes = scale * np.tile(0.5 * stretch, (len(positions), 1))
    path = write_run(tmp_path / "run.h5md", positions * stretch, [1, 0, 0, 0], axes, cell * stretch, [0, 2.5])
    summary = analysis.summarize(path)
    assert summary == {
        "frames": 2,
        "bodies": 32,
        "time": 2.5,
        "collisions": 1000,
        "packing_fraction": pytest.approx(np.pi / np.sqrt(18), abs=1e-14),
        "reduced_pressure": 5.0,
        "contact_number": 12.0,
        "rattlers": 0,
        "nematic_order": pytest.approx(1.0, abs=1e-14),
        "director": pytest.approx([0, 0, 1], abs=1e-14),
    }
    with h5py.File(path, "a"):  # the file is not left open
        pass
