"""Which density waves are in the arrangement of the centres? The static structure factor."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from analysis.blocks import weighted_mean
from analysis.frames import FrameAnalysis
from analysis.radial import equal_steps
from ccd import checks
from ccd.annotations import Any, ArrayLike, Floats

if TYPE_CHECKING:
    from MDAnalysis import AtomGroup

AT_ONCE = 4_000_000             # products of two waves held in memory at a time


def structure_factor(positions: ArrayLike, cell: ArrayLike, k_max: float) -> tuple[Floats, Floats]:
    """S(k) = |sum_j exp(-i k.r_j)|^2 / n of bodies in a periodic cell, for every wave vector k of the cell with 0 < |k| <= k_max.

    `positions` (n, 3); `cell` (3, 3), rows are the cell vectors a_i, of any shape. The wave vectors are those with k.a_i = 2 pi times a
    whole number; of k and -k, which have the same S, one is given. Of an ideal gas S = 1 on average (exactly, at any n: k = 0 is left
    out); a crystal has S = n at its Bragg peaks. Returns (k (m, 3), S (m,)). The cost is n times the number of waves: k_max^3 times the
    volume.
    """
    positions = checks.real_array("positions", positions, (None, 3), "an array (n, 3)")
    cell = checks.cell_vectors("cell", cell)
    k_max = checks.real_number("k_max", k_max, "a positive number", above=0)
    fractions = np.linalg.solve(cell.T, positions.T).T
    highest = np.floor(np.linalg.norm(cell, axis=1) * k_max / (2 * np.pi) + 1e-9).astype(int)       # |k.a| <= |k| |a|
    orders = [np.arange(-h, h + 1) for h in highest]
    waves = [np.exp(-2j * np.pi * np.outer(fractions[:, i], orders[i])) for i in range(3)]
    half = orders[0] >= 0
    waves[0] = waves[0][:, half]
    shape = [wave.shape[1] for wave in waves]
    amplitudes = np.zeros((shape[0] * shape[1], shape[2]), dtype=complex)
    for one, two, three in zip(*(np.array_split(wave, 1 + len(amplitudes) * len(positions) // AT_ONCE) for wave in waves)):
        amplitudes += (one[:, :, None] * two[:, None, :]).reshape(len(one), -1).T @ three
    amplitudes = amplitudes.reshape(shape)
    h = np.stack(np.meshgrid(orders[0][half], orders[1], orders[2], indexing="ij"), axis=-1)
    k = 2 * np.pi * h @ np.linalg.inv(cell).T
    length = np.linalg.norm(k, axis=-1)
    one_of_two = (h[..., 0] > 0) | (h[..., 1] > 0) & (h[..., 0] == 0) | (h[..., 2] > 0) & (h[..., 0] == 0) & (h[..., 1] == 0)
    wanted = one_of_two & (length <= k_max)
    return k[wanted], np.abs(amplitudes[wanted])**2 / len(positions)


class StructureFactor(FrameAnalysis):
    """S(|k|) of the atoms, over all wave vectors of a length and all frames: `StructureFactor(u.atoms, k_max=15.0).run()`.

    `results.k` (m,) is the mean length of the wave vectors in each of `bins` equal steps from 0 to k_max, `results.s` (m,) the mean of
    `structure_factor` over them, `results.error` (m,) its error over the frames and `results.waves` (m,) their number; steps without a
    wave vector are left out. Single peaks, as of a crystal, are seen best without the mean: use the function.
    """

    SERIES = ("waves", "lengths", "sums")

    def __init__(self, atomgroup: AtomGroup, k_max: float, bins: int = 100, **kwargs: Any) -> None:
        super().__init__(atomgroup, **kwargs)
        self.k_max, self.edges = k_max, equal_steps(k_max, bins)

    def _frame(self):
        k, s = structure_factor(self.positions, self.cell, self.k_max)
        length = np.linalg.norm(k, axis=1)
        return [np.histogram(length, bins=self.edges, weights=weight)[0] for weight in (None, length, s)]

    def _conclude(self):
        super()._conclude()
        waves, lengths, sums = (self.results.pop(name) for name in self.SERIES)
        known = waves.sum(axis=0) > 0
        self.results.waves = waves.sum(axis=0)[known]
        self.results.k = lengths.sum(axis=0)[known] / self.results.waves
        self.results.s, self.results.error = weighted_mean(sums[:, known], waves[:, known])
