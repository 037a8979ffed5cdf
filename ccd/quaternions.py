"""Arrays of unit quaternions (n, 4), scalar first (w, x, y, z), turning body into lab. What kernels use of them is in rotation.py."""

import numpy as np


def rotation_matrices(orientations):
    """The rotation matrices (n, 3, 3); their columns are the body axes in the lab."""
    w, x, y, z = np.asarray(orientations, dtype=float).T
    return np.stack([
        np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], axis=-1),
        np.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], axis=-1),
        np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], axis=-1),
    ], axis=-2)


def to_lab(orientations, vectors):
    """Vectors (n, 3) given in the bodies' frames, in the lab."""
    return np.einsum("nij,nj->ni", rotation_matrices(orientations), vectors)


def to_body(orientations, vectors):
    """Vectors (n, 3) given in the lab, in the bodies' frames."""
    return np.einsum("nji,nj->ni", rotation_matrices(orientations), vectors)


def products(p, q):
    """p q (n, 4): the rotation q in the body's frame followed by p."""
    pw, pv, qw, qv = p[:, :1], p[:, 1:], q[:, :1], q[:, 1:]
    return np.hstack([pw * qw - (pv * qv).sum(axis=1, keepdims=True), pw * qv + qw * pv + np.cross(pv, qv)])


def rotations(vectors):
    """Quaternions (n, 4) of the rotations about the vectors (n, 3) by angles of their lengths."""
    angle = np.sqrt((vectors**2).sum(axis=1, keepdims=True))
    return np.hstack([np.cos(angle / 2), np.sinc(angle / (2 * np.pi)) / 2 * vectors])
