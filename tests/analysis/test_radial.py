import MDAnalysis as mda
import numpy as np
import pytest
from runs import fcc, write_run

import analysis

SKEW = np.array([[5.0, 0, 0], [2.0, 4.5, 0], [-1.5, 1.8, 5.2]])


def test_fcc_shells_stand_at_their_distances_with_their_counts():
    positions, cell = fcc(4)
    n, bins, r_max = len(positions), 400, 2.8
    r, g = analysis.radial_distribution(positions, cell, r_max, bins)
    width = r_max / bins
    shells = 4 / 3 * np.pi * ((r + width / 2) ** 3 - (r - width / 2) ** 3)
    counts = g * shells * (n - 1) / np.linalg.det(cell)
    for squared, neighbours in [(1, 12), (2, 6), (3, 24), (4, 12), (5, 24), (6, 8), (7, 48)]:
        assert counts[np.abs(r - np.sqrt(squared)) < 2 * width].sum() == pytest.approx(neighbours, abs=1e-9)
    assert counts.sum() == pytest.approx(12 + 6 + 24 + 12 + 24 + 8 + 48, abs=1e-9)


def test_the_primitive_cell_repeated_gives_the_same():
    cubic, cubic_cell = fcc(4)
    primitive = np.sqrt(0.5) * np.array([[0, 1, 1], [1, 0, 1], [1, 1, 0.0]])
    steps = np.stack(np.meshgrid(*[np.arange(8)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    _, g = analysis.radial_distribution(steps @ primitive, 8 * primitive, 2.4, 50)
    _, expected = analysis.radial_distribution(cubic, cubic_cell, 2.4, 50)
    density = np.array([(len(steps) - 1) / 8**3, (len(cubic) - 1) / (len(cubic))])
    np.testing.assert_allclose(g * density[0], expected * density[1], rtol=1e-9)


def test_a_brute_sum_over_images_agrees_in_a_skew_cell():
    rng = np.random.default_rng(2)
    positions = rng.random((20, 3)) @ SKEW
    r_max, bins = 1.8, 9
    images = np.stack(np.meshgrid(*[np.arange(-3, 4)] * 3, indexing="ij"), axis=-1).reshape(-1, 3) @ SKEW
    distances = [np.linalg.norm(positions[j] + images - positions[i], axis=1) for i in range(20) for j in range(i)]
    counts, edges = np.histogram(np.concatenate(distances), bins=bins, range=(0, r_max))
    shells = 4 / 3 * np.pi * np.diff(edges**3)
    r, g = analysis.radial_distribution(positions + 7 * SKEW[0], SKEW, r_max, bins)
    np.testing.assert_allclose(g, counts * np.linalg.det(SKEW) / (190 * shells), rtol=1e-12)
    np.testing.assert_allclose(r, (np.arange(bins) + 0.5) * 0.2, rtol=1e-12)


def test_an_ideal_gas_has_one():
    rng = np.random.default_rng(4)
    n, frames, bins, r_max = 60, 200, 8, 2.0
    g = np.mean([analysis.radial_distribution(rng.random((n, 3)) @ SKEW, SKEW, r_max, bins)[1] for _ in range(frames)], axis=0)
    edges = np.linspace(0, r_max, bins + 1)
    expected_pairs = frames * n * (n - 1) / 2 * 4 / 3 * np.pi * np.diff(edges**3) / np.linalg.det(SKEW)
    assert np.all(np.abs(g - 1) < 4 / np.sqrt(expected_pairs))  # pair counts are Poisson to 1 %: four standard deviations
    assert abs(np.average(g, weights=expected_pairs) - 1) < 4 / np.sqrt(expected_pairs.sum())


def test_along_a_trajectory_each_frame_has_its_own_cell(tmp_path):
    positions, cell = fcc(3)
    scale = np.array([1.0, 1.1])[:, None, None]
    path = write_run(tmp_path / "run.h5md", positions * scale, [1, 0, 0, 0], (0.5, 0.5, 0.5), cell * scale, [0, 1])
    results = analysis.RadialDistribution(mda.Universe(path).atoms, r_max=2.03, bins=29).run().results
    expected = [analysis.radial_distribution(positions * s, cell * s, 2.03, 29)[1] for s in (1.0, 1.1)]
    np.testing.assert_allclose(results.g, np.mean(expected, axis=0), atol=1e-4)
    assert analysis.RadialDistribution(mda.Universe(path).atoms).r_max == pytest.approx(1.5 * np.sqrt(2), rel=1e-6)


def test_what_cannot_be_answered_is_refused():
    positions, cell = fcc(2)
    assert analysis.radial_distribution(positions, cell, np.sqrt(2), 5)[1].shape == (5,)
    for r_max in (1.4143, 0.0, -1.0, np.nan):
        with pytest.raises(ValueError, match=r"r_max: .* half the smallest width"):
            analysis.radial_distribution(positions, cell, r_max)
    flat = np.array([[1.0, 0, 0], [0.9, 0.2, 0], [0, 0, 1]])  # its smallest width is 0.2, far below its shortest vector
    assert analysis.radial_distribution(positions, flat, 0.0999, 5)[1].shape == (5,)
    with pytest.raises(ValueError, match="r_max"):
        analysis.radial_distribution(positions, flat, 0.1001)
    with pytest.raises(ValueError, match="positions: 1 bodies"):
        analysis.radial_distribution(positions[:1], cell, 1.0)
    with pytest.raises(ValueError, match="cell"):
        analysis.radial_distribution(positions, np.ones((3, 3)), 1.0)
