"""How many neighbours stand at which distance, in which direction, and how are they turned? Pair distributions of the centres."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from analysis.axes import unit_vectors
from analysis.blocks import block_error, weighted_mean
from analysis.frames import FrameAnalysis, cell_of
from analysis.order import nematic_order
from ccd import checks
from ccd.annotations import Any, ArrayLike, Floats
from ccd.culling import near_pairs

if TYPE_CHECKING:
    from MDAnalysis import AtomGroup

CORNER = np.sqrt(2)             # from the middle to the rim of a cylinder whose radius and half height are 1


def radial_distribution(positions: ArrayLike, cell: ArrayLike, r_max: float, bins: int = 100) -> tuple[Floats, Floats]:
    """g(r) of the centres of bodies in a periodic cell.

    `positions` (n, 3), n >= 2; `cell` (3, 3), rows are the cell vectors, of any shape; `r_max` at most half the smallest
    distance between opposite faces, so that no pair counts twice; `bins` equal shells from 0. Normalised by the density of
    pairs n (n - 1) / V: an ideal gas has g = 1 on average in every shell at any n. Returns (r (bins,) the middle of each
    shell, g (bins,)).
    """
    positions, cell = checked(positions, cell, r_max)
    edges = equal_steps(r_max, bins)
    counts = np.histogram(np.linalg.norm(near_pairs(positions, cell, r_max)[2], axis=1), bins=edges)[0]
    shells = 4 / 3 * np.pi * np.diff(edges**3)
    return middles(edges), counts / expected_pairs(len(positions), cell, shells)


def orientational_pair_correlation(positions: ArrayLike, axes: ArrayLike, cell: ArrayLike, r_max: float,
                                   bins: int = 100) -> tuple[Floats, Floats]:
    """g2(r) = <P2(u_i . u_j)> over the pairs whose centres are r apart: how parallel neighbours are.

    P2(x) = (3 x^2 - 1) / 2: 1 parallel, -1/2 perpendicular, 0 at random; far apart it tends to the square of the nematic order (in a
    large system). `axes` (n, 3) unit vectors (`body_axes`), the rest as `radial_distribution`. Returns (r (bins,), g2 (bins,)), nan where
    no pair is.
    """
    edges = equal_steps(r_max, bins)
    pairs, sums = second_legendre_sums(positions, axes, cell, edges)
    with np.errstate(invalid="ignore"):
        return middles(edges), sums / pairs


def second_legendre_sums(positions, axes, cell, edges):
    """Pairs (bins,) in each shell, and the sums (bins,) of P2(u_i . u_j) over them."""
    positions, cell = checked(positions, cell, edges[-1])
    axes = unit_vectors("axes", axes, (len(positions), 3), f"unit vectors ({len(positions)}, 3), one a body")
    first, second, separation = near_pairs(positions, cell, edges[-1])
    distance = np.linalg.norm(separation, axis=1)
    legendre = 1.5 * np.sum(axes[first] * axes[second], axis=1)**2 - 0.5
    return np.histogram(distance, bins=edges)[0], np.histogram(distance, bins=edges, weights=legendre)[0]


def cylindrical_distribution(positions: ArrayLike, cell: ArrayLike, director: ArrayLike, r_max: float,
                             bins: int = 50) -> tuple[Floats, Floats]:
    """g(z, rho): pairs at a distance z along a director and rho across it, both up to `r_max`, in `bins` equal steps each.

    Normalised as `radial_distribution`, by the volume of each ring (z and -z). `director` (3,) a unit vector; `r_max` times sqrt(2), the
    corner of the cylinder, at most half the smallest distance between opposite faces of the cell. Returns (r (bins,), g (bins, bins)), z
    along the first axis; `along` and `across` are its means over the other.
    """
    positions, cell = checked(positions, cell, r_max, CORNER)
    director = unit_vectors("director", np.asarray(director)[None], (1, 3), "a unit vector of three numbers")[0]
    edges = equal_steps(r_max, bins)
    separation = near_pairs(positions, cell, CORNER * r_max)[2]
    z = separation @ director
    rho = np.linalg.norm(separation - z[:, None] * director, axis=1)
    counts = np.histogram2d(np.abs(z), rho, bins=(edges, edges))[0]
    rings = 2 * np.diff(edges)[:, None] * np.pi * np.diff(edges**2)
    return middles(edges), counts / expected_pairs(len(positions), cell, rings)


def along(g: Floats) -> Floats:
    """g(z), of pairs in the whole cross-section rho < r_max: the mean of g(z, rho) (..., bins, bins) by area. Layers are peaks of it."""
    bins = g.shape[-1]
    return g @ (np.diff(np.arange(bins + 1.0)**2) / bins**2)


def across(g: Floats) -> Floats:
    """g(rho), of pairs in the whole height |z| < r_max: the mean of g(z, rho) (..., bins, bins) by height. Columns are peaks of it."""
    return g.mean(axis=-2)


def checked(positions: ArrayLike, cell: ArrayLike, r_max: float, reach: float = 1.0) -> tuple[Floats, Floats]:
    """Positions and cell as arrays; ValueError where there are no pairs, or a pair could count twice within reach * r_max."""
    positions = checks.real_array("positions", positions, (None, 3), "an array (n, 3)")
    cell = checks.cell_vectors("cell", cell)
    if len(positions) < 2:
        raise ValueError(f"positions: {len(positions)} bodies; at least 2 are needed")
    largest = half_width(cell) / reach
    if not 0 < r_max <= largest * (1 + 1e-12):
        of = "half the smallest width of the cell" + ("" if reach == 1 else " over sqrt(2)")
        raise ValueError(f"r_max: {r_max}; it must be positive and at most {largest}, {of}")
    return positions, cell


def expected_pairs(n, cell, volumes):
    """Pairs that n bodies placed at random would have in volumes of the separation."""
    return n * (n - 1) / 2 * volumes / abs(np.linalg.det(cell))


def equal_steps(largest, bins):
    """Edges (bins + 1,) of equal steps from 0."""
    if checks.natural_number("bins", bins) == 0:
        raise ValueError(f"bins = {bins}: expected at least one")
    return np.linspace(0.0, largest, bins + 1)


def middles(edges):
    return (edges[1:] + edges[:-1]) / 2


def half_width(cell):
    """Half the smallest distance between opposite faces of the cell (3, 3): nearer than this, a pair meets in one image only."""
    return 0.5 / np.linalg.norm(np.linalg.inv(cell), axis=0).max()


class PairAnalysis(FrameAnalysis):
    """A distribution of pairs up to `r_max`, by default the largest that the cell of the current frame allows, in `bins` steps."""

    REACH = 1.0

    def __init__(self, atomgroup: AtomGroup, r_max: float | None = None, bins: int = 100, **kwargs: Any) -> None:
        super().__init__(atomgroup, **kwargs)
        self.r_max = half_width(cell_of(atomgroup.universe.trajectory.ts)) / self.REACH if r_max is None else r_max
        self.edges = equal_steps(self.r_max, bins)

    def _conclude(self):
        super()._conclude()
        self.results.r = middles(self.edges)


class RadialDistribution(PairAnalysis):
    """g(r) of the atoms, averaged over the frames of a trajectory: `RadialDistribution(u.atoms, r_max=4.0).run()`.

    `results.r` and `results.g` (bins,), as `radial_distribution`, each frame normalised by its own volume, and `results.error` (bins,),
    the `block_error` over the frames. MDAnalysis' `InterRDF` does the same between two groups, in float32.
    """

    SERIES = ("g",)

    def _frame(self):
        return (radial_distribution(self.positions, self.cell, self.r_max, len(self.edges) - 1)[1],)

    def _conclude(self):
        super()._conclude()
        self.results.g, self.results.error = self.results.g.mean(axis=0), block_error(self.results.g)


class OrientationalPairCorrelation(PairAnalysis):
    """g2(r) of the atoms, over all pairs of all frames: `OrientationalPairCorrelation(u.atoms, r_max=4.0).run()`.

    `results.r` and `results.g2` (bins,), as `orientational_pair_correlation` of the `body_axes`; `results.error` (bins,) over the frames;
    `results.pairs` (bins,), how many were averaged; nan where there is none.
    """

    SERIES = ("pairs", "sums")

    def _frame(self):
        return second_legendre_sums(self.positions, self.axes, self.cell, self.edges)

    def _conclude(self):
        super()._conclude()
        self.results.g2, self.results.error = weighted_mean(self.results.pop("sums"), self.results.pairs)
        self.results.pairs = self.results.pairs.sum(axis=0)


class CylindricalDistribution(PairAnalysis):
    """g(z, rho) of the atoms about the director, averaged over the frames: `CylindricalDistribution(u.atoms, r_max=4.0).run()`.

    About each frame's own director (`nematic_order` of the `body_axes`), or `director=(x, y, z)`. `results.r` (bins,), `results.g` (bins,
    bins) as `cylindrical_distribution`; `results.along` and `results.across` (bins,), with `results.along_error` and
    `results.across_error` over the frames.
    """

    SERIES = ("g",)
    REACH = CORNER

    def __init__(self, atomgroup: AtomGroup, r_max: float | None = None, bins: int = 50, director: ArrayLike | None = None,
                 **kwargs: Any) -> None:
        super().__init__(atomgroup, r_max, bins, **kwargs)
        self.director = director

    def _frame(self):
        director = nematic_order(self.axes)[1] if self.director is None else self.director
        return (cylindrical_distribution(self.positions, self.cell, director, self.r_max, len(self.edges) - 1)[1],)

    def _conclude(self):
        super()._conclude()
        g, results = self.results.g, self.results
        results.g, results.along, results.across = g.mean(axis=0), along(g).mean(axis=0), across(g).mean(axis=0)
        results.along_error, results.across_error = block_error(along(g)), block_error(across(g))
