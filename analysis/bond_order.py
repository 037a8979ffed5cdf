"""Which lattice do the neighbours of a body remind of? Steinhardt's bond orders, computed by freud (optional: pip install edmd[freud])."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from analysis.frames import ThreadedAnalysis
from analysis.radial import half_width
from ccd import checks
from ccd.annotations import Any, ArrayLike, Floats

if TYPE_CHECKING:
    from MDAnalysis import AtomGroup

FLOAT32 = 1e-6                  # relative: distances from freud are no better

def steinhardt_order(positions: ArrayLike, cell: ArrayLike, l: int = 6, neighbors: int = 12, average: bool = False) -> tuple[Floats, float]:
    """q_l of every body (n,) and Q_l of the whole, from the directions to each body's `neighbors` nearest centres.

    q_l = sqrt(4 pi / (2 l + 1) sum_m |<Y_lm>|^2), the mean over a body's bonds, and over all bonds for Q_l (Steinhardt, Nelson and
    Ronchetti, Phys. Rev. B 28, 784 (1983)); with `average` over the bonds of the neighbours too (Lechner and Dellago, J. Chem. Phys. 129,
    114707 (2008)). fcc: q_4 = 0.191, q_6 = 0.575; hcp: 0.097, 0.485; bcc with 14 neighbors: 0.036, 0.511; a liquid: Q_l about
    1/sqrt(bonds). `positions` (n, 3); `cell` (3, 3), rows are the cell vectors, of any shape; the neighbours must be nearer than half its
    smallest width. Precision: float32. ImportError in words when freud is missing. Returns (q (n,), Q).
    """
    freud = import_freud()
    positions = checks.real_array("positions", positions, (None, 3), "an array (n, 3)")
    cell = checks.cell_vectors("cell", cell)
    if not 1 <= neighbors < len(positions):
        raise ValueError(f"neighbors = {neighbors}: expected 1 to {len(positions) - 1}, fewer than bodies")
    triangular = np.linalg.cholesky(cell @ cell.T)              # the same lengths and angles, as freud wants them: lower triangular rows
    points = np.linalg.solve(cell.T, positions.T).T % 1.0 @ triangular
    box = freud.box.Box.from_matrix(triangular.T)
    points = box.wrap(points)
    bonds = freud.locality.AABBQuery(box, points).query(points, {"num_neighbors": neighbors, "exclude_ii": True}).toNeighborList()
    if bonds.distances.max() >= half_width(cell) * (1 + FLOAT32) or len(bonds) < neighbors * len(points):
        raise ValueError(f"neighbors = {neighbors}: not all are within {half_width(cell)}, half the smallest width of the cell")
    order = freud.order.Steinhardt(l=l, average=average).compute((box, points), neighbors=bonds)
    return np.asarray(order.particle_order, dtype=float), float(order.order)


def import_freud():
    try:
        import freud
    except ImportError:
        raise ImportError("bond orders need freud, which is not installed: pip install freud-analysis, or edmd[freud]") from None
    return freud


class SteinhardtOrder(ThreadedAnalysis):
    """Bond orders of the atoms along a trajectory: `SteinhardtOrder(u.atoms, l=6, neighbors=12).run()`.

    `results.local` (frames, n) and `results.total` (frames,), as `steinhardt_order`.
    """

    SERIES = ("local", "total")

    def __init__(self, atomgroup: AtomGroup, l: int = 6, neighbors: int = 12, average: bool = False, **kwargs: Any) -> None:
        super().__init__(atomgroup, **kwargs)
        import_freud()
        self.options: dict[str, Any] = {"l": l, "neighbors": neighbors, "average": average}

    def _frame(self):
        return steinhardt_order(self.positions, self.cell, **self.options)
