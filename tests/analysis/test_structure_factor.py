import MDAnalysis as mda
import numpy as np
import pytest
from runs import fcc, write_run

import analysis
from analysis import scattering

SKEW = np.array([[5.0, 0, 0], [2.0, 4.5, 0], [-1.5, 1.8, 5.2]])


def test_fcc_has_its_bragg_peaks_and_nothing_else():
    """Peaks of height n where Miller indices are all even or all odd, in a cubic cell of edge sqrt(2)."""
    positions, cell = fcc(3)
    k, s = analysis.structure_factor(positions + [0.1, 0.7, -0.3], cell, 11.0)
    miller = k * np.sqrt(2) / (2 * np.pi)
    whole = np.all(np.abs(miller - miller.round()) < 1e-9, axis=1)
    parities = miller.round().astype(int) % 2
    peaks = whole & (np.ptp(parities, axis=1) == 0)
    np.testing.assert_allclose(s[peaks], len(positions), rtol=1e-12)
    np.testing.assert_allclose(s[~peaks], 0, atol=1e-10)
    families = np.unique((miller[peaks]**2).sum(axis=1).round().astype(int), return_counts=True)
    assert dict(zip(*families)) == {3: 4, 4: 3}                          # (111) and (200), of each pair k, -k one; (220) has |k| = 12.6


def test_waves_are_those_of_the_cell_each_once():
    """Against every whole number in a generous range."""
    rng = np.random.default_rng(0)
    k, _ = analysis.structure_factor(rng.random((7, 3)) @ SKEW, SKEW, 4.0)
    whole = np.stack(np.meshgrid(*[np.arange(-8, 9)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    every = 2 * np.pi * whole @ np.linalg.inv(SKEW).T
    expected = every[(np.linalg.norm(every, axis=1) <= 4.0) & whole.any(axis=1)]
    assert len(k) == len(expected) / 2
    both = np.concatenate([k, -k])
    np.testing.assert_allclose(both[np.lexsort(both.round(9).T)], expected[np.lexsort(expected.round(9).T)], atol=1e-12)


@pytest.mark.parametrize("at_once", [scattering.AT_ONCE, 10_000])
def test_a_brute_sum_agrees(monkeypatch, at_once):
    monkeypatch.setattr(scattering, "AT_ONCE", at_once)
    rng = np.random.default_rng(1)
    positions = rng.random((40, 3)) @ SKEW
    k, s = analysis.structure_factor(positions, SKEW, 5.0)
    phases = k @ positions.T
    np.testing.assert_allclose(s, (np.cos(phases).sum(axis=1)**2 + np.sin(phases).sum(axis=1)**2) / 40, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(analysis.structure_factor(positions + 3 * SKEW[2] - SKEW[0], SKEW, 5.0)[1], s, rtol=1e-9, atol=1e-12)


def test_an_ideal_gas_has_one_along_a_trajectory(tmp_path):
    """Each wave's S is exponential with mean and deviation 1 (to 1/n), and the waves of one frame are independent."""
    rng = np.random.default_rng(2)
    frames, n = 60, 100
    path = write_run(tmp_path / "run.h5md", rng.random((frames, n, 3)) @ SKEW, [1, 0, 0, 0], (1, 1, 1), SKEW, np.arange(frames))
    results = analysis.StructureFactor(mda.Universe(path).atoms, k_max=5.0, bins=8).run().results
    sigma = 1 / np.sqrt(results.waves)
    assert np.all(np.abs(results.s - 1) < 4 * sigma)
    assert abs(np.average(results.s, weights=results.waves) - 1) < 4 / np.sqrt(results.waves.sum())
    assert np.mean(results.error / sigma) == pytest.approx(1, abs=0.3)           # each is known to some 25 %
    assert results.waves.sum() == frames * len(analysis.structure_factor(np.zeros((1, 3)), SKEW, 5.0)[0])
    assert np.all(np.diff(results.k) > 0)


def test_what_has_no_waves_is_refused():
    positions, cell = fcc(1)
    for name, value in (("k_max", 0.0), ("cell", np.ones((3, 3))), ("positions", np.ones(3))):
        with pytest.raises(ValueError, match=name):
            analysis.structure_factor(**{"positions": positions, "cell": cell, "k_max": 5.0} | {name: value})
