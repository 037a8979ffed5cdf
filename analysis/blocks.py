"""How sure is a mean of values that follow one another? The error by blocks."""

from __future__ import annotations

import numpy as np

from ccd import checks
from ccd.annotations import Any, ArrayLike


def block_error(values: ArrayLike) -> Any:
    """Standard error of the mean of `values` (m,) or (m, ...) along the first axis, where neighbours in the series may be correlated.

    Neighbours are averaged in pairs, and pairs again, which takes the correlation away (Flyvbjerg and Petersen, J. Chem. Phys. 91, 461
    (1989)); the smallest block is taken whose length B has B^3 > 2 m (e_B / e_1)^4, e_B the error from blocks of length B (Wolff, Comput.
    Phys. Commun. 156, 143 (2004); Lee et al., Phys. Rev. E 83, 066706 (2011)). Of some hundred values the error itself is known to some
    20 %. nan where the series is too short to tell, 0 where it stands still. ValueError for what is not finite.
    """
    blocks = checks.real_array("values", values, (None,) * max(np.ndim(values), 1), "a series of numbers (m,) or (m, ...)")
    m, length, first = len(blocks), 1, None
    chosen = np.full(blocks.shape[1:], np.nan)
    while len(blocks) >= 2:
        error = blocks.std(axis=0, ddof=1) / np.sqrt(len(blocks))
        first = error if first is None else first
        enough = (length**3 * first**4 > 2 * m * error**4) | (first == 0)
        chosen = np.where(np.isnan(chosen) & enough, error, chosen)
        even = len(blocks) // 2 * 2
        blocks, length = (blocks[0:even:2] + blocks[1:even:2]) / 2, 2 * length
    return chosen[()]


def weighted_mean(sums: ArrayLike, weights: ArrayLike) -> tuple[Any, Any]:
    """sum(sums) / sum(weights) along the first axis, and its `block_error` to first order; both (m,) or (m, ...).

    For means of unequal numbers of pairs, or over unequal times. nan where all weights are zero. Returns (mean, error).
    """
    sums, weights = np.asarray(sums, dtype=float), np.asarray(weights, dtype=float)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = sums.sum(axis=0) / weights.sum(axis=0)
        known = weights.sum(axis=0) > 0
        error = block_error(sums - np.where(known, mean, 0) * weights) / weights.mean(axis=0)
    return mean[()], np.where(known, error, np.nan)[()]
