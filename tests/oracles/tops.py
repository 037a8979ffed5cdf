"""Oracle: how free rigid bodies turn, by Taylor series of Euler's equations and of the quaternion, in short steps and extended precision.

Slow and plain, K bodies at once; numpy only. `PRECISION` is what the extended precision of this machine leaves of a turn by one radian.
"""

import numpy as np

EXTENDED = np.longdouble
PRECISION = 30 * float(np.finfo(EXTENDED).eps)
ORDER, STEP = 26, 0.3                           # terms, radians


def product(p, q):
    """Of quaternions (4, K)."""
    return np.stack([p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
                     p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
                     p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
                     p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0]])


def rotated(q, vectors):
    """Vectors (K, 3) from the frames of the bodies into the lab, by orientations (K, 4)."""
    q, vectors = np.array(q, dtype=EXTENDED).T, np.array(vectors, dtype=EXTENDED).T
    q = q / np.sqrt((q * q).sum(axis=0))
    inverse = q * np.array([[1], [-1], [-1], [-1]])
    return product(product(q, np.concatenate([0 * vectors[:1], vectors])), inverse)[1:].T


def in_body(q, vectors):
    """Vectors (K, 3) from the lab into the frames of the bodies."""
    return rotated(np.array(q, dtype=EXTENDED) * np.array([1, -1, -1, -1]), vectors)


def turned(q, momentum, inverse_moments, time):
    """Orientations (K, 4) and momenta in the bodies' frames (K, 3) of free bodies after times (K,); momentum (K, 3) in the lab."""
    x = in_body(q, momentum).T
    q, j, time = (np.array(a, dtype=EXTENDED).T for a in (q, inverse_moments, time))
    q = q / np.sqrt((q * q).sum(axis=0))
    fastest = np.sqrt(j.max(axis=0) * (j * x * x).sum(axis=0))          # |w|^2 <= 2 E / the smallest moment
    steps = int(np.ceil((fastest * np.abs(time) / STEP).max())) + 1
    h = time / steps
    difference = np.stack([j[2] - j[1], j[0] - j[2], j[1] - j[0]])
    for _ in range(steps):
        xs, qs = np.zeros((ORDER, *x.shape), dtype=EXTENDED), np.zeros((ORDER, *q.shape), dtype=EXTENDED)
        xs[0], qs[0] = x, q
        for m in range(ORDER - 1):
            back = xs[m::-1]
            xs[m + 1] = h * difference * (xs[:m + 1][:, [1, 2, 0]] * back[:, [2, 0, 1]]).sum(axis=0) / (m + 1)
            turning = np.concatenate([0 * back[:, :1], j * back], axis=1)
            qs[m + 1] = h / 2 * product(qs[:m + 1].swapaxes(0, 1), turning.swapaxes(0, 1)).sum(axis=1) / (m + 1)
        x, q = xs.sum(axis=0), qs.sum(axis=0)
    return q.T, x.T


def distance(p, q):
    """The largest difference of components of unit quaternions (K, 4) that stand for the same rotations up to it: (K,)."""
    p, q = np.asarray(p, dtype=EXTENDED), np.asarray(q, dtype=EXTENDED)
    return np.minimum(np.abs(p - q).max(axis=1), np.abs(p + q).max(axis=1)).astype(float)
