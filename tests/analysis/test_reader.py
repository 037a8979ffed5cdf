import os
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
from runs import fcc, wrapped, write_run

import analysis
from analysis.reader import is_edmd_file


@pytest.fixture
def flight(tmp_path):
    """Twenty frames of twelve free bodies in a skew cell, wrapped: (path, unwrapped positions (20, 12, 3), cell)."""
    rng = np.random.default_rng(5)
    cell = np.array([[3.0, 0, 0], [1.2, 2.9, 0], [-0.7, 0.9, 3.1]])
    times = 0.25 * np.arange(20)
    velocities = 4 * rng.normal(size=(12, 3))
    unwrapped = rng.random((12, 3)) @ cell + times[:, None, None] * velocities
    positions, images = wrapped(unwrapped, cell)
    path = write_run(tmp_path / "flight.h5md", positions, [1, 0, 0, 0], (1, 1, 2), cell, times, images=images, velocities=velocities)
    return path, unwrapped, cell


def test_the_bare_call_uses_our_reader_for_text_and_path(moving):
    path, _ = moving
    for source in (str(path), path):
        universe = mda.Universe(source)
        assert isinstance(universe.trajectory, analysis.EDMDReader)
        assert (len(universe.atoms), len(universe.trajectory)) == (12, 5)


@pytest.mark.parametrize("suffix", [".h5", ".hdf5", ".H5MD", ".dat", ".pdb", ""])
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
    odd = [1, 3, 5, 7, 9, 11]
    for words in ("type 1", "species 1", "prop species > 0", "species 1:4"):
        assert universe.select_atoms(words).ix.tolist() == odd
    np.testing.assert_array_equal(universe.select_atoms("species 1").masses, 2.0)
    assert universe.atoms.species.tolist() == [0, 1] * 6
    assert universe.atoms[3].species == 1
    np.testing.assert_array_equal(universe.atoms.ids, np.arange(12))


def test_a_universe_made_by_hand_takes_species(moving):
    other = mda.Universe.empty(3, trajectory=True)
    other.add_TopologyAttr("species")
    assert other.atoms.species.tolist() == [0, 0, 0]


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


# across the faces of the cell

def test_unwrapped_positions_are_the_flight_itself(flight):
    path, unwrapped, cell = flight
    universe = mda.Universe(path)
    assert np.abs(unwrapped[-1] - unwrapped[0]).max() > 3 * np.linalg.norm(cell, axis=1).max()
    for k, _ in enumerate(universe.trajectory):
        np.testing.assert_allclose(universe.atoms.unwrapped_positions, unwrapped[k], atol=1e-12)
    universe.trajectory[7]
    np.testing.assert_allclose(universe.atoms[[5, 0]].unwrapped_positions, unwrapped[7][[5, 0]], atol=1e-12)
    with pytest.raises(AttributeError, match="unwrapped_positions"):
        universe.atoms.unwrapped_positions = unwrapped[0]


def test_images_belong_to_the_cell_of_their_frame(moving, tmp_path):
    _, frames = moving
    shape = [1, 0, 0, 0], (1, 1, 1)
    path = write_run(tmp_path / "run.h5md", frames["positions"], *shape, frames["cells"], frames["times"], images=[1, -2, 3])
    universe = mda.Universe(path)
    for k, _ in enumerate(universe.trajectory):
        expected = frames["positions"][k] + np.array([1, -2, 3]) @ frames["cells"][k]
        np.testing.assert_allclose(universe.atoms.unwrapped_positions, expected, atol=1e-12)


def test_einstein_msd_of_mdanalysis_finds_the_ballistic_flight(flight):
    path, unwrapped, _ = flight
    universe = mda.Universe(path)
    universe.trajectory.add_transformations(analysis.unwrap)
    msd = EinsteinMSD(universe, fft=False).run()
    speeds = np.mean(np.sum((unwrapped[1] - unwrapped[0])**2, axis=1)) / 0.25**2
    np.testing.assert_allclose(msd.results.delta_t_values, 0.25 * np.arange(20))
    np.testing.assert_allclose(msd.results.timeseries, speeds * msd.results.delta_t_values**2, rtol=1e-5)


@pytest.mark.parametrize("skew", [0, 1])
def test_inter_rdf_of_mdanalysis_finds_the_shells_of_a_changing_crystal(tmp_path, skew):
    positions, cell = fcc(4)
    cell = cell.copy()
    cell[2] += skew * cell[0]                                   # the same crystal in a cell with an angle of 45 degrees
    scale = np.array([1.0, 1.01, 1.02])[:, None, None]
    path = write_run(tmp_path / "run.h5md", positions * scale, [1, 0, 0, 0], (0.5, 0.5, 0.5), cell * scale, [0, 1, 2])
    atoms = mda.Universe(path).atoms
    found = InterRDF(atoms, atoms, nbins=5, range=(0.9, 2.4), exclusion_block=(1, 1)).run()         # shells at 1, 1.41, 1.73, 2, 2.24
    np.testing.assert_allclose(found.results.count / (3 * len(positions)), [12, 6, 24, 12, 24])


def test_inter_rdf_of_mdanalysis_takes_selections(moving):
    universe = mda.Universe(moving[0])
    rdf = InterRDF(universe.select_atoms("species 0"), universe.select_atoms("species 1"), nbins=10, range=(0.1, 3.0)).run()
    assert np.isfinite(rdf.results.rdf).all()
    assert rdf.results.count.sum() > 0


# files in all states

def test_a_frame_is_read_when_it_is_asked_for(tmp_path):
    """By the system's own count of the bytes that this process has read."""
    n, frames = 20_000, 20
    rng = np.random.default_rng(0)
    path = write_run(tmp_path / "run.h5md", rng.random((n, 3)), [1, 0, 0, 0], (1, 1, 1), np.eye(3), np.arange(frames))
    size = path.stat().st_size / frames

    def frames_read(action):
        before = bytes_read()
        action()
        return (bytes_read() - before) / size

    opened = []
    assert frames_read(lambda: opened.append(mda.Universe(path))) < 1.3         # the frame on which every Universe stands
    trajectory = opened[0].trajectory
    assert frames_read(lambda: trajectory[13]) < 1.1
    assert frames_read(lambda: [opened[0].atoms.orientations, opened[0].atoms.unwrapped_positions]) < 0.1
    assert 3.9 < frames_read(lambda: [None for _ in trajectory[4:8]]) < 5.2     # and back to the first


def bytes_read():
    with open("/proc/self/io") as file:
        return int(next(line for line in file if line.startswith("rchar")).split()[1])


def test_a_run_that_is_still_written_opens(moving):
    """Another process holds the file, as a run does."""
    hold = f"import h5py; file = h5py.File({str(moving[0])!r}, 'a'); print('held', flush=True); input()"
    writer = subprocess.Popen([sys.executable, "-c", hold], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    try:
        assert writer.stdout.readline() == "held\n"
        with pytest.raises(BlockingIOError):
            h5py.File(moving[0], "r")
        universe = mda.Universe(moving[0])
        twin = pickle.loads(pickle.dumps(universe))
        for held in (universe, twin):
            assert isinstance(held.trajectory, analysis.EDMDReader)
            np.testing.assert_array_equal(held.trajectory[4].data["position"], moving[1]["positions"][4])
    finally:
        writer.communicate("\n")


def test_a_frame_that_is_there_in_part_does_not_count(moving):
    """As in a file whose run was killed: the series have unequal lengths."""
    with h5py.File(moving[0], "a") as file:
        values = file["particles/trajectory/orientation/value"][:4]
        del file["particles/trajectory/orientation/value"]
        file["particles/trajectory/orientation/value"] = values
    universe = mda.Universe(moving[0])
    assert len(universe.trajectory) == 4
    np.testing.assert_array_equal(universe.trajectory[-1].data["position"], moving[1]["positions"][3])


def test_a_newer_format_is_refused_in_words(moving):
    with h5py.File(moving[0], "a") as file:
        file["edmd"].attrs["format"] = 2
    with pytest.raises(ValueError, match="format 2 is newer"):
        mda.Universe(moving[0])


def test_orientations_need_one_of_our_files():
    universe = mda.Universe.empty(3, trajectory=True)
    universe.add_TopologyAttr("orientations", np.zeros((3, 4)))
    with pytest.raises(mda.NoDataError, match="orientation"):
        _ = universe.atoms.orientations
    universe.add_TopologyAttr("unwrapped_positions", np.zeros((3, 3)))
    with pytest.raises(mda.NoDataError, match="unwrapped_position"):
        _ = universe.atoms.unwrapped_positions
    with pytest.raises(mda.NoDataError, match="these frames have no images"):
        universe.trajectory.add_transformations(analysis.unwrap)


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
    os.mkfifo(tmp_path / "pipe.h5md")
    files = tmp_path / "pipe.h5md", "absent.h5md", "zero\0byte", tmp_path, tmp_path / "text.h5md", tmp_path / "foreign.h5md"
    for thing in (None, 3, b"x.h5md", np.zeros(3), *files):
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
