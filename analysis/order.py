"""How well do the bodies agree on directions? Nematic, biaxial and cubatic order (definitions: docs/analysis.md)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from analysis.axes import three_axes, unit_vectors
from analysis.frames import FrameAnalysis
from ccd.annotations import Any, ArrayLike, Floats

if TYPE_CHECKING:
    from MDAnalysis import AtomGroup

PLANES = ((0, 1), (1, 2), (2, 0))
TURNS = 40                      # cap of the sweeps of plane turns; about five are used
TURNED = 1e-12                  # radians: the turn below which a frame has arrived
STARTS = 12                     # bodies whose axes are tried as a first guess of the cubatic frame


def nematic_tensor(axes: ArrayLike) -> Floats:
    """Q = <3 u u - 1> / 2 of the unit vectors `axes` (n, 3): symmetric, traceless, the same for u and -u. Returns (3, 3)."""
    axes = unit_vectors("axes", axes)
    return 1.5 * axes.T @ axes / len(axes) - 0.5 * np.eye(3)


def nematic_order(axes: ArrayLike) -> tuple[float, Floats]:
    """Order parameter and director of the unit vectors `axes` (n, 3).

    The order parameter is the largest eigenvalue of Q, and the director its eigenvector (Eppenga and Frenkel, Mol. Phys. 52, 1303
    (1984)): 1 when all are parallel, about 1/sqrt(n) when they are random, and 1/4 when they lie at random in a plane: the
    other convention, the eigenvalue of largest magnitude, would give -1/2 there. The sign of the director means nothing; here its
    component of largest magnitude is positive. Returns (order, director (3,)).
    """
    values, vectors = np.linalg.eigh(nematic_tensor(axes))
    return float(values[-1]), signed(vectors[:, -1])


def biaxial_order(orientations: ArrayLike) -> tuple[float, float, Floats, int]:
    """Do bodies with three different axes agree on all of them? `orientations` (n, 4), scalar first.

    With Q^aa = <3 a a - 1> / 2 for each body axis a: z is the body axis whose Q has the largest eigenvalue, the uniaxial order, and Z
    that eigenvector. The biaxial order is B = (X.Qxx.X + Y.Qyy.Y - X.Qyy.X - Y.Qxx.Y) / 3 (Camp and Allen, J. Chem. Phys. 106, 6681
    (1997)), here with the X and Y perpendicular to Z that make it largest: (l1 - l2) / 3 with the eigenvalues l of Qxx - Qyy in that
    plane. Of n random bodies they are about 1/sqrt(n) and 0.4/sqrt(n). Of spheroids it means nothing: two of their axes are any.
    """
    axes = three_axes(orientations)
    tensors = np.stack([nematic_tensor(axes[:, k]) for k in range(3)])
    values, vectors = np.linalg.eigh(tensors)
    z = int(np.argmax(values[:, -1]))
    first, second = np.delete(np.arange(3), z)
    director = signed(vectors[z][:, -1])
    plane = vectors[z][:, :2]
    across, turned = np.linalg.eigh(plane.T @ (tensors[first] - tensors[second]) @ plane)
    x = signed(plane @ turned[:, 1])
    return float(values[z, -1]), float(across[1] - across[0]) / 3, np.stack([x, np.cross(director, x), director]), z


def signed(vector):
    """The vector or its opposite: the one whose component of largest magnitude is positive."""
    return vector * np.sign(vector[np.argmax(np.abs(vector))])


def cubatic_order(axes: ArrayLike) -> tuple[float, Floats]:
    """Do bodies lie along three perpendicular directions, whichever of them? Order and the directions, rows (3, 3).

    `axes` (n, 3): one unit vector a body, or (n, 3, 3): its three axes, one a row (`three_axes`). With F(N) the mean over all axes u of
    the sum of (u.N)^4 over three perpendicular N, the order is C = (max F - 3/5) / (2/5): 1 when every axis is along one of them, and of
    random axes 0 as their number grows (about 1/sqrt(n): a maximum over frames is never negative). The sum over the N is the cubic
    harmonic of rank 4; a perfect nematic has C = 1 too: cubatic is C > 0 where the nematic order is 0. The maximum is found by turns in one
    plane after the other, each in closed form, from the frames of several bodies; a higher maximum could be missed where order is faint.
    """
    shape, what = ((None, 3), "unit vectors (n, 3)") if np.ndim(axes) == 2 else ((None, 3, 3), "unit vectors (n, 3) or (n, 3, 3)")
    single = unit_vectors("axes", axes, shape, what).reshape(-1, 3)
    fourth, frame = max((climb(single, frame) for frame in first_guesses(single)), key=lambda found: found[0])
    return (fourth - 0.6) / 0.4, frame


def first_guesses(axes):
    """The lab's frame, and frames that have one of the axes and the part of another that is perpendicular to it."""
    frames = [np.eye(3)]
    for one in axes[np.linspace(0, len(axes) - 1, min(STARTS, len(axes))).astype(int)]:
        other = axes[np.argmin(np.abs(axes @ one))]
        second = np.cross(one, other) if np.linalg.norm(np.cross(one, other)) > 0.1 else np.cross(one, np.eye(3)[np.argmin(np.abs(one))])
        second = second / np.linalg.norm(second)
        frames.append(np.stack([one, second, np.cross(one, second)]))
    return frames


def climb(axes, frame):
    """The maximum of F above a frame, rows (3, 3): the frame is turned to the maximum in one coordinate plane after another."""
    frame = frame.copy()
    for _ in range(TURNS):
        largest = 0.0
        for p, q in PLANES:
            in_plane = axes @ frame[p] + 1j * (axes @ frame[q])
            angle = np.angle(np.mean(in_plane**4)) / 4          # F in the plane is constant + |mean| cos(4 (turn - angle)) / 4
            turn = np.cos(angle), np.sin(angle)
            frame[[p, q]] = [turn[0] * frame[p] + turn[1] * frame[q], turn[0] * frame[q] - turn[1] * frame[p]]
            largest = max(largest, abs(angle))
        if largest < TURNED:
            break
    return float(np.mean(np.sum((axes @ frame.T)**4, axis=1))), frame


class NematicOrder(FrameAnalysis):
    """Nematic order of the atoms along a trajectory: `NematicOrder(u.atoms).run()`.

    `results.order` (frames,) and `results.director` (frames, 3), as `nematic_order` of the `body_axes`.
    """

    SERIES = ("order", "director")

    def _frame(self):
        return nematic_order(self.axes)


class BiaxialOrder(FrameAnalysis):
    """Biaxial order of the atoms along a trajectory: `BiaxialOrder(u.atoms).run()`.

    `results.uniaxial` and `results.biaxial` (frames,), `results.directors` (frames, 3, 3) and `results.axis` (frames,), as `biaxial_order`.
    """

    SERIES = ("uniaxial", "biaxial", "directors", "axis")

    def _frame(self):
        return biaxial_order(self.atomgroup.orientations)


class CubaticOrder(FrameAnalysis):
    """Cubatic order of the atoms along a trajectory: `CubaticOrder(u.atoms).run()`.

    `results.order` (frames,) and `results.directions` (frames, 3, 3), as `cubatic_order` of the `body_axes`, or of all three axes
    with `all_axes=True`.
    """

    SERIES = ("order", "directions")

    def __init__(self, atomgroup: AtomGroup, all_axes: bool = False, **kwargs: Any) -> None:
        super().__init__(atomgroup, **kwargs)
        self.all_axes = all_axes

    def _frame(self):
        return cubatic_order(three_axes(self.atomgroup.orientations) if self.all_axes else self.axes)
