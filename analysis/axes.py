"""Where does a body point? Unit vectors from orientations."""

from __future__ import annotations

import numpy as np

from ccd import checks
from ccd.annotations import ArrayLike, Floats
from ccd.checks import Shape
from ccd.quaternions import rotation_matrices


def body_axes(orientations: ArrayLike, semi_axes: ArrayLike) -> Floats:
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


def three_axes(orientations: ArrayLike) -> Floats:
    """The three principal axes of each body in the lab (n, 3, 3), one a row, in the order of its semi-axes; `orientations` (n, 4)."""
    orientations = checks.unit_quaternions("orientations", orientations, (None, 4), "quaternions (n, 4)")
    return np.swapaxes(rotation_matrices(orientations), 1, 2)


def unit_vectors(name: str, value: ArrayLike, shape: Shape = (None, 3), what: str = "unit vectors (n, 3)") -> Floats:
    """A float64 array of unit vectors, n >= 1; ValueError in words for anything else."""
    array = checks.real_array(name, value, shape, what)
    lengths = np.linalg.norm(array, axis=-1)
    if len(array) == 0 or not np.allclose(lengths, 1.0, atol=1e-6):
        raise ValueError(f"{name}: lengths {lengths}; expected {what}, at least one")
    return array
