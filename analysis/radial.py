"""How many neighbours stand at which distance? The radial distribution function of the centres."""

import numpy as np
from MDAnalysis.analysis.base import AnalysisBase

from ccd.checks import cell_vectors, real_array
from ccd.culling import near_pairs


def radial_distribution(positions, cell, r_max, bins=100):
    """g(r) of the centres of bodies in a periodic cell.

    `positions` (n, 3), n >= 2; `cell` (3, 3), rows are the cell vectors, of any shape; `r_max` at most half the smallest
    distance between opposite faces, so that no pair counts twice; `bins` equal shells from 0. Normalised by the density of
    pairs n (n - 1) / V: an ideal gas has g = 1 on average in every shell at any n. Returns (r (bins,) the middle of each
    shell, g (bins,)).
    """
    positions = real_array("positions", positions, (None, 3), "an array (n, 3)")
    cell = cell_vectors("cell", cell)
    n = len(positions)
    if n < 2:
        raise ValueError(f"positions: {n} bodies; at least 2 are needed")
    largest = half_width(cell)
    if not 0 < r_max <= largest * (1 + 1e-12):
        raise ValueError(f"r_max: {r_max}; it must be positive and at most {largest}, half the smallest width of the cell")
    separation = near_pairs(positions, cell, r_max)[2]
    edges = np.linspace(0.0, r_max, bins + 1)
    counts = np.histogram(np.linalg.norm(separation, axis=1), bins=edges)[0]
    shells = 4 / 3 * np.pi * np.diff(edges**3)
    pairs = n * (n - 1) / 2
    return (edges[1:] + edges[:-1]) / 2, counts * abs(np.linalg.det(cell)) / (pairs * shells)


def half_width(cell):
    """Half the smallest distance between opposite faces of the cell (3, 3): nearer than this, a pair meets in one image only."""
    return 0.5 / np.linalg.norm(np.linalg.inv(cell), axis=0).max()


class RadialDistribution(AnalysisBase):
    """g(r) of the atoms, averaged over the frames of a trajectory: `RadialDistribution(u.atoms, r_max=4.0).run()`.

    `r_max` is by default half the smallest width of the cell in the current frame. `results.r` and `results.g` (bins,), as
    `radial_distribution`, each frame normalised by its own volume. MDAnalysis' `InterRDF` does the same between two groups.
    """

    def __init__(self, atomgroup, r_max=None, bins=100, **kwargs):
        super().__init__(atomgroup.universe.trajectory, **kwargs)
        self.atomgroup, self.bins = atomgroup, bins
        self.r_max = half_width(atomgroup.universe.trajectory.ts.triclinic_dimensions) if r_max is None else r_max

    def _prepare(self):
        self.results.g = np.zeros(self.bins)

    def _single_frame(self):
        self.results.r, g = radial_distribution(self.atomgroup.positions, self._ts.triclinic_dimensions, self.r_max, self.bins)
        self.results.g += g

    def _conclude(self):
        self.results.g /= self.n_frames
