"""How well do the bodies agree on a direction? The nematic order tensor, its order parameter and its director."""

import numpy as np
from MDAnalysis.analysis.base import AnalysisBase

from ccd.quaternions import rotation_matrices


def nematic_tensor(axes):
    """Q = <3 u u - 1> / 2 of the unit vectors `axes` (n, 3): symmetric, traceless, the same for u and -u. Returns (3, 3)."""
    axes = np.asarray(axes, dtype=float)
    if axes.ndim != 2 or axes.shape[1] != 3 or len(axes) == 0:
        raise ValueError(f"axes: shape {axes.shape}; one row of three a body is needed, (n, 3) with n >= 1")
    if not np.allclose(np.linalg.norm(axes, axis=1), 1.0, atol=1e-6):
        raise ValueError(f"axes: lengths {np.linalg.norm(axes, axis=1)}; unit vectors are needed")
    return 1.5 * axes.T @ axes / len(axes) - 0.5 * np.eye(3)


def nematic_order(axes):
    """Order parameter and director of the unit vectors `axes` (n, 3).

    The order parameter is the largest eigenvalue of Q, and the director its eigenvector (Eppenga and Frenkel, Mol. Phys. 52, 1303
    (1984)): 1 when all are parallel, about 1/sqrt(n) when they are random, and 1/4 when they lie at random in a plane: the
    other convention, the eigenvalue of largest magnitude, would give -1/2 there. The sign of the director means nothing; here its
    component of largest magnitude is positive. Returns (order, director (3,)).
    """
    values, vectors = np.linalg.eigh(nematic_tensor(axes))
    director = vectors[:, -1]
    return float(values[-1]), director * np.sign(director[np.argmax(np.abs(director))])


def body_axes(orientations, semi_axes):
    """Direction in the lab of the axis that tells the body's orientation, for each body.

    That is the symmetry axis of a spheroid (prolate or oblate), the longest axis when all three differ, and the third axis
    for a sphere. Two semi-axes are equal when they agree to 1e-9 relative. `orientations` (n, 4) are unit quaternions,
    scalar first; `semi_axes` (n, 3). Returns unit vectors (n, 3).
    """
    q = np.asarray(orientations, dtype=float)
    axes = np.asarray(semi_axes, dtype=float)
    if q.ndim != 2 or q.shape[1] != 4:
        raise ValueError(f"orientations: shape {q.shape}; one quaternion a body is needed, (n, 4)")
    if axes.shape != (len(q), 3):
        raise ValueError(f"semi_axes: shape {axes.shape}; one row of three a body is needed, {(len(q), 3)}")
    equal = [np.isclose(axes[:, i], axes[:, j], rtol=1e-9, atol=0) for i, j in ((0, 1), (1, 2), (0, 2))]
    chosen = np.select(equal, [2, 0, 1], default=np.argmax(axes, axis=1))
    return rotation_matrices(q)[np.arange(len(q)), :, chosen]


class NematicOrder(AnalysisBase):
    """Nematic order of the atoms along a trajectory: `NematicOrder(u.atoms).run()`.

    `results.order` (frames,) and `results.director` (frames, 3), as `nematic_order` of the `body_axes`; `times` (frames,).
    """

    def __init__(self, atomgroup, **kwargs):
        super().__init__(atomgroup.universe.trajectory, **kwargs)
        self.atomgroup = atomgroup

    def _prepare(self):
        self.results.order = np.empty(self.n_frames)
        self.results.director = np.empty((self.n_frames, 3))

    def _single_frame(self):
        axes = body_axes(self.atomgroup.orientations, self.atomgroup.semi_axes)
        self.results.order[self._frame_index], self.results.director[self._frame_index] = nematic_order(axes)
