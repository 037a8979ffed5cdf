import MDAnalysis as mda
import numpy as np
import pytest
from runs import fcc, random_quaternions, write_run

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


# how neighbours are turned

def test_g2_of_layers_of_parallel_bodies_is_the_legendre_polynomial_of_the_turn_between_layers():
    """A simple cubic lattice whose layers are turned by an angle in turn: neighbours in the layer 1, in the next P2(cos angle)."""
    angle, steps = 0.7, np.arange(6)
    positions = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3).astype(float)
    odd = positions[:, 2] % 2
    axes = np.column_stack([np.cos(odd * angle), np.sin(odd * angle), 0 * odd])
    _, g2 = analysis.orientational_pair_correlation(positions, axes, 6 * np.eye(3), 1.65, 3)                   # shells at 1 and sqrt(2)
    second = 1.5 * np.cos(angle)**2 - 0.5
    assert np.isnan(g2[0])
    np.testing.assert_allclose(g2[1:], [(4 + 2 * second) / 6, (4 + 8 * second) / 12], atol=1e-12)


def test_g2_of_axes_at_random_is_zero_and_of_parallel_ones_one():
    rng = np.random.default_rng(10)
    n, frames, bins = 60, 100, 6
    pairs, sums = np.zeros(bins), np.zeros(bins)
    for _ in range(frames):
        axes = rng.normal(size=(n, 3))
        axes /= np.linalg.norm(axes, axis=1)[:, None]
        positions = rng.random((n, 3)) @ SKEW
        _, g2 = analysis.orientational_pair_correlation(positions, axes, SKEW, 2.0, bins)
        _, g = analysis.radial_distribution(positions, SKEW, 2.0, bins)
        counts = g * np.diff(np.linspace(0, 2, bins + 1)**3)                                    # in proportion to the pairs
        pairs, sums = pairs + counts, sums + np.where(counts > 0, g2, 0) * counts
    # P2 has variance 1/5 at random
    number = pairs * n * (n - 1) / 2 * 4 / 3 * np.pi / np.linalg.det(SKEW)
    assert np.all(np.abs(sums / pairs) < 4 * np.sqrt(0.2 / number))
    _, parallel = analysis.orientational_pair_correlation(positions, np.tile([0, 0.6, 0.8], (n, 1)), SKEW, 2.0, 2)
    np.testing.assert_allclose(parallel, 1, atol=1e-12)


# along and across the director

def test_layers_are_peaks_along_and_columns_across():
    """Layers of an ideal gas, two apart along a director that is askew in the cell, and columns of one along it."""
    rng = np.random.default_rng(1)
    n, bins = 2000, 10
    director = np.array([0.0, 0.6, 0.8])
    box = np.linalg.qr(np.column_stack([director, np.eye(3)[0], np.eye(3)[1]]))[0].T * [[8], [12], [12]]      # rows; the first along it
    layers = (rng.integers(4, size=(n, 1)) * 0.25 + [[0.03]]) @ box[:1] + rng.random((n, 2)) @ box[1:]
    r, g = analysis.cylindrical_distribution(layers, box, director, 2.75, bins)
    width = 0.275
    assert r[0] == pytest.approx(width / 2)
    expected = np.zeros(bins)
    expected[[0, 7]] = 1 / 4 * 8 / (2 * width) * np.array([1, 2])        # a quarter of all pairs at z = 0, half at 2 and -2
    pairs = n * n / 2 * np.pi * 2.75**2 / 144
    np.testing.assert_allclose(analysis.along(g), expected, atol=5 * expected.max() / np.sqrt(pairs / 4))
    pairs = n * n / 2 * 3 / 4 * np.pi * np.diff((width * np.arange(bins + 1))**2) / 144
    np.testing.assert_array_less(np.abs(analysis.across(g) - expected.sum() / bins), 5 * expected.sum() / bins / np.sqrt(pairs))


def test_an_ideal_gas_has_one_in_every_ring():
    rng = np.random.default_rng(5)
    n, frames, bins, r_max = 60, 200, 4, 1.4
    director = np.array([2.0, -6.0, 3.0]) / 7
    found = [analysis.cylindrical_distribution(rng.random((n, 3)) @ SKEW, SKEW, director, r_max, bins)[1] for _ in range(frames)]
    g = np.mean(found, axis=0)
    edges = np.linspace(0, r_max, bins + 1)
    pairs = frames * n * (n - 1) / 2 * 2 * np.diff(edges)[:, None] * np.pi * np.diff(edges**2) / np.linalg.det(SKEW)
    assert np.all(np.abs(g - 1) < 4 / np.sqrt(pairs))
    assert abs(np.average(g, weights=pairs) - 1) < 4 / np.sqrt(pairs.sum())
    for mean, numbers in ((analysis.along(g), pairs.sum(axis=1)), (analysis.across(g), pairs.sum(axis=0))):
        assert np.all(np.abs(mean - 1) < 4 / np.sqrt(numbers))


def test_means_over_a_cylinder_are_counts_in_slabs_and_tubes():
    rng = np.random.default_rng(6)
    positions, director, r_max = rng.random((40, 3)) @ SKEW, np.array([0.6, 0.0, 0.8]), 1.2
    _, g = analysis.cylindrical_distribution(positions, SKEW, director, r_max, 4)
    images = np.stack(np.meshgrid(*[np.arange(-2, 3)] * 3, indexing="ij"), axis=-1).reshape(-1, 3) @ SKEW
    separation = np.concatenate([positions[j] + images - positions[i] for i in range(40) for j in range(i)])
    z, rho = np.abs(separation @ director), np.linalg.norm(np.cross(separation, director), axis=1)
    inside = (z < r_max) & (rho < r_max)
    density = 40 * 39 / 2 / np.linalg.det(SKEW)
    edges = np.linspace(0, r_max, 5)
    slabs, tubes = (np.histogram(values[inside], bins=edges)[0] for values in (z, rho))
    np.testing.assert_allclose(analysis.along(g), slabs / (density * 2 * 0.3 * np.pi * r_max**2), rtol=1e-12)
    np.testing.assert_allclose(analysis.across(g), tubes / (density * 2 * r_max * np.pi * np.diff(edges**2)), rtol=1e-12)


def test_all_pair_distributions_along_a_trajectory(tmp_path):
    """The means of the function over the frames, with errors that cover an ideal gas."""
    rng = np.random.default_rng(8)
    frames, n = 64, 30
    positions = rng.random((frames, n, 3)) @ SKEW
    q = random_quaternions(rng, frames * n).reshape(frames, n, 4)
    atoms = mda.Universe(write_run(tmp_path / "run.h5md", positions, q, (1, 1, 2), SKEW, np.arange(frames))).atoms
    radial = analysis.RadialDistribution(atoms, r_max=2.0, bins=4).run().results
    expected = np.mean([analysis.radial_distribution(p, SKEW, 2.0, 4)[1] for p in positions], axis=0)
    np.testing.assert_allclose(radial.g, expected, rtol=1e-13)
    assert np.all(np.abs(radial.g - 1) < 4 * radial.error)
    turned = analysis.OrientationalPairCorrelation(atoms, r_max=2.0, bins=4).run().results
    assert np.all(np.abs(turned.g2) < 4 * turned.error)
    np.testing.assert_allclose(turned.error, np.sqrt(0.2 / turned.pairs), rtol=0.5)
    cylinder = analysis.CylindricalDistribution(atoms, r_max=1.2, bins=3, director=(0, 0, 1)).run().results
    expected = np.mean([analysis.cylindrical_distribution(p, SKEW, (0, 0, 1), 1.2, 3)[1] for p in positions], axis=0)
    np.testing.assert_allclose(cylinder.g, expected, rtol=1e-13)
    assert np.all(np.abs(cylinder.along - 1) < 4 * cylinder.along_error)
    assert np.all(np.abs(cylinder.across - 1) < 4 * cylinder.across_error)
    parallel = analysis.CylindricalDistribution(atoms, r_max=1.2, bins=3).run(stop=1).results
    axes = analysis.body_axes(q[0], np.tile([1, 1, 2.0], (n, 1)))
    found = analysis.cylindrical_distribution(positions[0], SKEW, analysis.nematic_order(axes)[1], 1.2, 3)[1]
    np.testing.assert_array_equal(parallel.g, found)


def test_cylinders_that_reach_too_far_and_directions_that_are_none_are_refused():
    positions, cell = fcc(2)
    assert analysis.cylindrical_distribution(positions, cell, (0, 0, 1), 1.0, 2)[1].shape == (2, 2)
    with pytest.raises(ValueError, match=r"r_max: 1.01; .* over sqrt\(2\)"):
        analysis.cylindrical_distribution(positions, cell, (0, 0, 1), 1.01)
    with pytest.raises(ValueError, match="director"):
        analysis.cylindrical_distribution(positions, cell, (0, 0, 2), 1.0)
    with pytest.raises(ValueError, match="bins"):
        analysis.radial_distribution(positions, cell, 1.0, bins=0)
    with pytest.raises(ValueError, match="axes"):
        analysis.orientational_pair_correlation(positions, np.eye(3), cell, 1.0)
