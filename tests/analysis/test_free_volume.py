import MDAnalysis as mda
import numpy as np
import pytest
from runs import fcc, write_run
from scipy.spatial.transform import Rotation

import analysis
from analysis import free_volume

ROUND = np.array([0.5, 0.5, 0.5])
UPRIGHT = np.array([1.0, 0, 0, 0])


def crystal(scale, stretch=(1, 1, 1), rotation=None):
    """An fcc crystal of touching spheres, pulled apart by a scale, stretched and turned: the arguments of free_volumes."""
    positions, cell = fcc(2)
    rotation = Rotation.identity() if rotation is None else rotation
    orientations, semi_axes = np.tile(rotation.as_quat()[[3, 0, 1, 2]], (32, 1)), np.tile(ROUND * stretch, (32, 1))
    return rotation.apply(scale * positions * stretch), orientations, semi_axes, rotation.apply(scale * cell * stretch)


@pytest.mark.parametrize("stretch", [(1, 1, 1), (1, 1, 2), (1.25, 1, 0.8)])
def test_the_cage_of_fcc_is_a_rhombic_dodecahedron(monkeypatch, stretch):
    """Twelve planes at a distance of the gap h: 4 sqrt(2) h^3, as the gap vanishes; stretched with the crystal."""
    monkeypatch.setattr(free_volume, "AT_ONCE", 50_000)         # in several parts
    h = 1e-5
    volumes = analysis.free_volumes(*crystal(1 + h, stretch, Rotation.random(random_state=3)), directions=300)
    np.testing.assert_allclose(volumes, 4 * np.sqrt(2) * h**3 * np.prod(stretch), rtol=0.01)


def test_cages_that_are_open_or_shut():
    positions, orientations, semi_axes, cell = crystal(1.001)
    semi_axes[5] *= 1.01                                        # it overlaps its neighbours
    volumes = analysis.free_volumes(positions, orientations, semi_axes, cell, directions=50)
    distances = np.linalg.norm((positions - positions[5] + cell[0, 0] / 2) % cell[0, 0] - cell[0, 0] / 2, axis=1)
    assert volumes[5] == 0
    assert np.all(volumes[distances > 1.1] > 0)
    alone = positions[:1], orientations[:1], semi_axes[:1], 1.01 * np.sqrt(0.5) * np.array([[1, 1, 0], [1, 0, 1], [0, 1, 1.0]])
    assert np.isnan(analysis.free_volumes(*alone, directions=10)).all()         # its twelve neighbours are its own images: they move along
    for name in ("reach", "directions"):
        with pytest.raises(ValueError, match=name):
            analysis.free_volumes(positions, orientations, semi_axes, cell, **{name: 0})


def test_free_volumes_along_a_trajectory(tmp_path):
    positions, cell = fcc(2)
    axes = np.array([1.0, 1 / 1.001])[:, None, None] * np.tile(ROUND, (32, 1))
    path = write_run(tmp_path / "run.h5md", positions * 1.0001, UPRIGHT, axes, cell * 1.0001, [0, 1])
    volumes = analysis.FreeVolumes(mda.Universe(path).atoms, directions=200).run().results.volumes
    gaps = np.array([1e-4, 1.0001 - 1 / 1.001])
    np.testing.assert_allclose(volumes, np.tile(4 * np.sqrt(2) * gaps[:, None]**3, (1, 32)), rtol=0.02)


# the law of the pressure

def test_the_law_itself_is_found():
    jammed, f = 0.7123456789, 4.5
    phi = jammed - np.geomspace(1e-2, 1e-9, 40)
    z = f / (1 - phi / jammed)
    found = analysis.jamming_point(phi, z)
    assert found == (pytest.approx(jammed, abs=1e-12), pytest.approx(f, rel=1e-6))
    rng = np.random.default_rng(0)
    noisy = analysis.jamming_point(phi, z * (1 + 0.02 * rng.normal(size=40)))
    assert noisy == (pytest.approx(jammed, abs=1e-9), pytest.approx(f, rel=0.05))


def test_points_far_from_jamming_do_not_count():
    phi = np.r_[0.3, 0.4, 0.64 - np.geomspace(1e-3, 1e-6, 10)]
    z = np.r_[4.0, 7.0, 3 / (1 - phi[2:] / 0.64)]
    assert analysis.jamming_point(phi, z)[0] == pytest.approx(0.64, abs=1e-12)
    with pytest.raises(ValueError, match="2 points above"):
        analysis.jamming_point(phi[:4], z[:4])
    with pytest.raises(ValueError, match="does not rise"):
        analysis.jamming_point(phi[2:], z[:1:-1])


def test_spheres_that_jam_into_fcc():
    """The densest packing pi / sqrt(18), and 3 (1 - 1/n) degrees of freedom a body: the common motion does not count."""
    import edmd

    simulation = edmd.Simulation(edmd.lattice("fcc", (0.5, 0.5, 0.5), 0.72, cells=(3, 3, 3), seed=1))
    points = []
    for reduced_pressure in np.geomspace(150, 1e4, 5):
        simulation.compress(1e-3, until_pressure=reduced_pressure)
        simulation.run(collisions_per_particle=200)
        points.append((simulation.packing_fraction, simulation.compressibility_factor))
    jammed, f = analysis.jamming_point(*np.transpose(points))
    assert jammed == pytest.approx(np.pi / np.sqrt(18), abs=1e-6)
    assert f == pytest.approx(3 * (1 - 1 / 108), rel=0.01)
