import pickle
import shutil
import subprocess
import sys
import warnings

import h5py
import MDAnalysis as mda
import numpy as np
import pytest
from MDAnalysis.analysis.msd import EinsteinMSD
from MDAnalysis.analysis.rdf import InterRDF

import analysis
from analysis.reader import is_edmd_file


def test_the_bare_call_uses_our_reader_for_text_and_path(moving):
    path, _ = moving
    for source in (str(path), path):
        universe = mda.Universe(source)
        assert isinstance(universe.trajectory, analysis.EDMDReader)
        assert (len(universe.atoms), len(universe.trajectory)) == (12, 5)


@pytest.mark.parametrize("suffix", [".h5", ".hdf5", ".H5MD"])
def test_any_suffix(moving, tmp_path, suffix):
    shutil.copy(moving[0], tmp_path / f"other{suffix}")
    assert isinstance(mda.Universe(tmp_path / f"other{suffix}").trajectory, analysis.EDMDReader)


def test_dt_is_the_first_interval_and_each_time_is_exact(moving):
    path, frames = moving
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        universe = mda.Universe(path)
        assert universe.trajectory.dt == 0.25
        assert [ts.time for ts in universe.trajectory] == frames["times"].tolist()
        assert [ts.data["step"] for ts in universe.trajectory] == [0, 1000, 2000, 3000, 4000]
    assert mda.Universe(path, dt=2.0).trajectory.dt == 2.0


def test_everything_follows_the_frame(moving):
    path, frames = moving
    universe = mda.Universe(path)
    atoms = universe.atoms[[7, 2]]
    for k in (0, 3, 1, 4):
        ts = universe.trajectory[k]
        np.testing.assert_array_equal(atoms.orientations, frames["orientations"][k][[7, 2]])
        np.testing.assert_array_equal(atoms.semi_axes, frames["semi_axes"][k][[7, 2]])
        np.testing.assert_array_equal(atoms[0].orientation, frames["orientations"][k][7])
        np.testing.assert_array_equal(ts.data["position"], frames["positions"][k])
        np.testing.assert_array_equal(ts.data["cell"], frames["cells"][k])
        np.testing.assert_allclose(universe.atoms.positions, frames["positions"][k], rtol=2e-7)
        np.testing.assert_allclose(ts.triclinic_dimensions, frames["cells"][k], atol=2e-6)
    with h5py.File(path) as file:
        velocities = file["particles/trajectory/velocity/value"][4], file["particles/trajectory/angular_velocity/value"][4]
    np.testing.assert_allclose(universe.atoms.velocities, velocities[0], rtol=2e-7)
    np.testing.assert_array_equal(universe.atoms.angular_velocities, velocities[1])


def test_species_and_masses(moving):
    universe = mda.Universe(moving[0])
    assert universe.select_atoms("type 1").ix.tolist() == [1, 3, 5, 7, 9, 11]
    np.testing.assert_array_equal(universe.select_atoms("type 1").masses, 2.0)
    np.testing.assert_array_equal(universe.atoms.ids, np.arange(12))


def test_pickle_and_copy_keep_the_frame_and_go_their_own_way(moving):
    path, frames = moving
    universe = mda.Universe(path)
    universe.trajectory[2]
    for twin in (pickle.loads(pickle.dumps(universe)), universe.copy()):
        assert twin.trajectory.frame == 2
        np.testing.assert_array_equal(twin.atoms.orientations, frames["orientations"][2])
        twin.trajectory[4]
        np.testing.assert_array_equal(twin.atoms.orientations, frames["orientations"][4])
        np.testing.assert_array_equal(universe.atoms.orientations, frames["orientations"][2])
        assert twin.trajectory.dt == 0.25


def test_analyses_of_mdanalysis_run(moving):
    path, frames = moving
    universe = mda.Universe(path)
    rdf = InterRDF(universe.atoms, universe.atoms, nbins=10, range=(0.1, 3.0), exclusion_block=(1, 1)).run()
    assert np.isfinite(rdf.results.rdf).all()
    msd = EinsteinMSD(universe, fft=False).run()
    displacement = frames["positions"][4] - frames["positions"][0]
    longest = np.argmax(msd.results.delta_t_values)  # unequal intervals: sorted by lag, not by frame
    np.testing.assert_allclose(msd.results.timeseries[longest], np.mean(np.sum(displacement**2, axis=1)), rtol=1e-5)


def test_orientations_need_one_of_our_files():
    universe = mda.Universe.empty(3, trajectory=True)
    universe.add_TopologyAttr("orientations", np.zeros((3, 4)))
    with pytest.raises(mda.NoDataError, match="orientation"):
        _ = universe.atoms.orientations


def test_a_file_without_frames_is_refused_in_words(moving, tmp_path):
    path = tmp_path / "empty.h5md"
    shutil.copy(moving[0], path)
    with h5py.File(path, "a") as file:
        del file["particles/trajectory/position/value"]
        file["particles/trajectory/position/value"] = np.empty((0, 12, 3))
    with pytest.raises(ValueError, match="no frames in the file"):
        mda.Universe(path)


def test_the_sniff_never_raises(tmp_path):
    (tmp_path / "text.h5md").write_text("not hdf5")
    with h5py.File(tmp_path / "foreign.h5md", "w") as file:
        file["other"] = 1
    for thing in (None, 3, b"x.h5md", "absent.h5md", tmp_path, tmp_path / "text.h5md", tmp_path / "foreign.h5md", np.zeros(3)):
        assert not is_edmd_file(thing)


def test_stock_mdanalysis_reads_the_same_file(moving):
    path, frames = moving
    script = f"""
import MDAnalysis as mda, numpy as np
u = mda.Universe({str(path)!r})
assert type(u.trajectory).__name__ == "H5MDReader"
u.trajectory[3]
np.save({str(path.with_suffix(".npy"))!r}, u.trajectory.ts.data["orientation"])
"""
    subprocess.run([sys.executable, "-c", script], check=True, capture_output=True, text=True)
    np.testing.assert_array_equal(np.load(path.with_suffix(".npy")), frames["orientations"][3])
