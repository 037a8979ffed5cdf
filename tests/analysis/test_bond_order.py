import builtins

import MDAnalysis as mda
import numpy as np
import pytest
from runs import fcc, write_run
from scipy.special import sph_harm_y

import analysis


def by_hand(bonds, l):
    """q_l of one body from its bonds (m, 3), by scipy's spherical harmonics."""
    polar = np.arccos(bonds[:, 2] / np.linalg.norm(bonds, axis=1))
    mean = [sph_harm_y(l, m, polar, np.arctan2(bonds[:, 1], bonds[:, 0])).mean() for m in range(-l, l + 1)]
    return np.sqrt(4 * np.pi / (2 * l + 1) * np.sum(np.abs(mean)**2))


def test_without_freud_the_message_says_what_to_install(monkeypatch, moving):
    real = builtins.__import__

    def missing(name, *arguments, **options):
        if name.split(".")[0] == "freud":
            raise ImportError("no freud")
        return real(name, *arguments, **options)

    monkeypatch.setattr(builtins, "__import__", missing)
    for asked in (lambda: analysis.steinhardt_order(*fcc(2)), lambda: analysis.SteinhardtOrder(mda.Universe(moving[0]).atoms)):
        with pytest.raises(ImportError, match="pip install freud-analysis"):
            asked()


@pytest.mark.parametrize(("l", "expected"), [(4, 0.19094), (6, 0.57452)])
@pytest.mark.parametrize("skew", [0, 1])
def test_fcc(l, expected, skew):
    pytest.importorskip("freud")
    positions, cell = fcc(3)
    cell = cell.copy()
    cell[2] += skew * cell[0]                                   # the same crystal in a skew cell
    q, total = analysis.steinhardt_order(positions + [3.0, -1.0, 0.2], cell, l)
    np.testing.assert_allclose(q, expected, atol=1e-5)
    assert total == pytest.approx(expected, abs=1e-5)
    assert expected == pytest.approx(by_hand(np.array([[0, 1, 1], [0, 1, -1], [1, 0, 1], [1, 0, -1], [1, 1, 0], [1, -1, 0]]), l), abs=1e-5)


def test_bcc_has_fourteen():
    pytest.importorskip("freud")
    steps = np.stack(np.meshgrid(*[np.arange(4)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    q, _ = analysis.steinhardt_order(np.concatenate([steps, steps + 0.5]), 4 * np.eye(3), 6, neighbors=14)
    np.testing.assert_allclose(q, 0.51069, atol=1e-5)


def test_a_fluid_by_hand_along_a_trajectory(tmp_path):
    pytest.importorskip("freud")
    rng = np.random.default_rng(2)
    cell = np.array([[9.0, 0, 0], [2.0, 8.5, 0], [-1.5, 1.8, 8.2]])
    positions = rng.random((2, 300, 3)) @ cell
    path = write_run(tmp_path / "run.h5md", positions, [1, 0, 0, 0], (0.5, 0.5, 0.5), cell, [0, 1])
    results = analysis.SteinhardtOrder(mda.Universe(path).atoms, l=6, neighbors=12).run().results
    images = np.stack(np.meshgrid(*[np.arange(-1, 2)] * 3, indexing="ij"), axis=-1).reshape(-1, 3) @ cell
    for k, body in ((0, 5), (1, 40), (1, 299)):
        bonds = (positions[k][:, None] + images - positions[k][body]).reshape(-1, 3)
        bonds = bonds[np.argsort(np.linalg.norm(bonds, axis=1))[1:13]]
        assert results.local[k, body] == pytest.approx(by_hand(bonds, 6), abs=1e-4)
    assert results.total.max() < 4 / np.sqrt(12 * 300)


def test_neighbours_that_are_too_far_for_the_cell_are_refused():
    pytest.importorskip("freud")
    for cells, neighbors in ((1, 4), (1, 3), (2, 31), (2, 0)):
        with pytest.raises(ValueError, match="neighbors"):
            analysis.steinhardt_order(*fcc(cells), 6, neighbors)
