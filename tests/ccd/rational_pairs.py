"""Pairs of ellipsoids under rational motions, for the product and for the oracles; and Example 1 of the paper."""

from math import sqrt

import numpy as np
from paths import Affine, Interpolated, Rigid
from scipy.spatial.transform import Rotation

import ccd

SHAPES = ("any", "needle", "plate", "sphere", "equal")


def directions(rng, n):
    v = rng.normal(size=(n, 3))
    return v / np.linalg.norm(v, axis=1)[:, None]


def semi_axes(rng, n, shape="any"):
    """(n, 3) in any order, of size about 1: up to 1:1:30 for needles and plates."""
    axes = np.exp(rng.uniform(np.log(0.3), np.log(2), (n, 3)))
    if shape == "needle":
        axes[:, :2] *= rng.uniform(0.03, 0.2, (n, 1))
    elif shape == "plate":
        axes[:, 0] *= rng.uniform(0.03, 0.2, n)
    elif shape == "sphere":
        axes[:] = axes[:, :1]
    elif shape == "equal":
        axes[:] = (0.5, 1.0, 1.5)
    return rng.permuted(axes, axis=1) if shape != "equal" else axes


def turning(rng, n, degree):
    """Quaternion polynomials (n, 4, degree / 2 + 1) that stay away from zero in [0, 1]."""
    k = degree // 2
    rotation = rng.normal(size=(n, 4, k + 1)) * 0.7 ** np.arange(k + 1)
    rotation[..., 0] += 1.5 * rng.choice([-1, 1], size=(n, 4))
    t = np.linspace(0, 1, 60)
    for j in range(n):
        while np.linalg.norm(rotation[j] @ t ** np.arange(k + 1)[:, None], axis=0).min() < 0.4:
            rotation[j] = rng.normal(size=(4, k + 1))
            rotation[j, :, 0] *= 2.5
    return rotation


def denominators(rng, n, degree):
    """(n, degree + 1) positive in [0, 1], with degree 0: ones."""
    return np.concatenate([np.ones((n, 1)), rng.uniform(-0.5, 0.6, (n, degree)) / max(degree, 1)], axis=1)


def crossing(rng, n, degree, size=4.0):
    """Polynomial paths (n, 3, degree + 1) that pass near 0 about the middle of [0, 1], from and to some `size` away."""
    path = np.zeros((n, 3, degree + 1))
    if degree == 0:
        path[:, :, 0] = rng.uniform(0.5, 3, (n, 1)) * directions(rng, n)
        return path
    middle, miss = rng.uniform(0.3, 0.7, n)[:, None], 0.8 * rng.normal(size=(n, 3))
    velocity = 2 * size * directions(rng, n)
    path[:, :, 0], path[:, :, 1] = miss - middle * velocity, velocity
    for k in range(2, degree + 1):                      # bends that vanish in the middle
        bend = size * rng.normal(size=(n, 3)) / (k - 1)
        for j, choose in enumerate(np.polynomial.polynomial.polypow([-0.5, 1.0], k)):
            path[:, :, j] += bend * choose
    return path


def rigid(rng, n, degree, translation, denominator=0, shape="any", size=4.0, axes=None):
    return Rigid(semi_axes(rng, n, shape) if axes is None else axes, turning(rng, n, degree), crossing(rng, n, translation, size),
                 denominators(rng, n, denominator))


def affine(rng, n, degree, translation, denominator=0, shape="any"):
    linear = rng.normal(size=(n, 3, 3, degree + 1)) * 0.5 ** np.arange(degree + 1)
    t = np.linspace(0, 1, 60)[None, :] ** np.arange(degree + 1)[:, None]
    for j in range(n):
        while True:
            maps = np.moveaxis(linear[j] @ t, 2, 0)
            if np.linalg.svd(maps, compute_uv=False)[:, 2].min() > 0.25 and np.linalg.cond(maps).max() < 15:
                break
            linear[j] = 0.4 * rng.normal(size=(3, 3, degree + 1)) * 0.6 ** np.arange(degree + 1)
            linear[j, :, :, 0] += Rotation.random(random_state=rng).as_matrix()
    return Affine(semi_axes(rng, n, shape), linear, crossing(rng, n, translation), denominators(rng, n, denominator))


def poses(rng, n, spread):
    """n poses: centre, quaternion."""
    return spread * directions(rng, n) * rng.uniform(0.3, 1, (n, 1)), Rotation.random(n, random_state=rng)


def interpolated(rng, n, shape="any"):
    """-> A at rest at the origin, B as seen from A, and the four ellipsoids of every pair for ccd.interpolate_affine."""
    axes_a, axes_b = semi_axes(rng, n, shape), semi_axes(rng, n, shape)
    ends = []
    for _ in range(2):
        (at_a, turn_a), (at_b, turn_b) = poses(rng, n, 3), poses(rng, n, 5)
        ends.append((at_a, turn_a, at_b, turn_b))
    ends[1] = (*ends[1][:2], 2 * ends[1][0] - ends[1][2] + 0.5 * rng.normal(size=(n, 3)), ends[1][3])
    inverses, centers, corners = np.empty((n, 2, 3, 3)), np.empty((n, 2, 3)), []
    for k, (at_a, turn_a, at_b, turn_b) in enumerate(ends):
        into = turn_a.inv().as_matrix()
        s = into @ turn_b.as_matrix() / axes_b[:, None, :]
        inverses[:, k] = s @ s.transpose(0, 2, 1)
        centers[:, k] = np.einsum("kij,kj->ki", into, at_b - at_a)
        corners.append([[ccd.Ellipsoid(axes[j], at[j], np.roll(turn[j].as_quat(), 1)) for j in range(n)]
                        for axes, at, turn in ((axes_a, at_a, turn_a), (axes_b, at_b, turn_b))])
    return resting(axes_a), Interpolated(axes_b, inverses, centers), [(corners[0][0][j], corners[1][0][j], corners[0][1][j],
                                                                     corners[1][1][j]) for j in range(n)]


def resting(axes):
    n = len(axes)
    return Rigid(axes, np.tile([[[1.0], [0], [0], [0]]], (n, 1, 1)), np.zeros((n, 3, 1)), np.ones((n, 1)))


def single(path, k):
    """As the product takes one: (Ellipsoid, motion)."""
    kind, first = (ccd.RationalMotion, path.rotation) if isinstance(path, Rigid) else (ccd.AffineMotion, path.linear)
    return ccd.Ellipsoid(path.semi_axes[k]), kind(first[k], path.translation[k], path.denominator[k])


def pair(a, b, k):
    """The arguments of ccd.contact_intervals."""
    return (*single(a, k), *single(b, k))


def shifted(path, by):
    """The path carried by (K, 3)."""
    size = max(path.translation.shape[2], path.denominator.shape[1])
    translation = np.pad(path.translation, ((0, 0), (0, 0), (0, size - path.translation.shape[2])))
    translation[:, :, :path.denominator.shape[1]] += by[:, :, None] * path.denominator[:, None, :]
    return type(path)(path.semi_axes, getattr(path, "rotation", getattr(path, "linear", None)), translation, path.denominator)


ROOT2, COS, SIN = sqrt(2), sqrt(2 + sqrt(2)) / 2, sqrt(2 - sqrt(2)) / 2
EXAMPLE_1 = (ccd.Ellipsoid((2, 4, 2)),
             ccd.RationalMotion([[1, 0], [0, 0], [-1, 2], [-1, 2]], [[-2, -6, 24, -8], [-6, 6, 24, -24], [-2, -12, 48, -32]]),
             ccd.Ellipsoid((1, 3, 4)),
             ccd.RationalMotion([[-SIN, 2 * SIN], [SIN, COS - SIN], [COS, -2 * COS], [-COS, COS + SIN]],
                                [[-27 + 24 * ROOT2, 114 - 72 * ROOT2, -156 + 72 * ROOT2, 72 - 24 * ROOT2], [-6, 12, 0, 0],
                                 [-26 + 24 * ROOT2, 114 - 72 * ROOT2, -168 + 72 * ROOT2, 88 - 24 * ROOT2]]))
