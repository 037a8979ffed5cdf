"""What the engine must agree with, in plain numpy: contacts over all periodic images by Perram and Wertheim, energies, statistics.

Nothing here imports the product; a system is anything with positions, orientations, semi_axes, box, masses and velocities.
"""

from types import SimpleNamespace

import numpy as np
import reference


def rotation_matrices(orientations):
    """(n, 3, 3), columns are the body axes in the lab, of quaternions (w, x, y, z)."""
    return np.array([reference.quat_to_R(q) for q in orientations])


def shape_matrices(orientations, semi_axes):
    return np.array([reference.shape_matrix(a, r) for a, r in zip(semi_axes, rotation_matrices(orientations))])


def close_images(positions, radii, box):
    """Every pair of images (i, j, vector from i to j's image) whose spheres overlap, by brute force; a body and its own image included."""
    heights = 1 / np.linalg.norm(np.linalg.inv(box), axis=0)
    reach = np.ceil(2 * np.max(radii) / heights).astype(int) + 1
    positions = positions - np.floor(positions @ np.linalg.inv(box)) @ box
    i, j = np.triu_indices(len(positions))
    first, second, vectors = [], [], []
    for shift in np.ndindex(*(2 * reach + 1)):
        cells = np.array(shift) - reach
        vector = positions[j] + cells @ box - positions[i]
        near = (vector**2).sum(axis=1) < (radii[i] + radii[j])**2
        near &= (i != j) | (tuple(cells) > (0, 0, 0))
        first.append(i[near])
        second.append(j[near])
        vectors.append(vector[near])
    return np.concatenate(first), np.concatenate(second), np.concatenate(vectors)


def contact_functions(system, gap=0.0):
    """Pairs of images that are near, and their Perram-Wertheim F: the pair touches when both are scaled by sqrt(F)."""
    shapes = shape_matrices(system.orientations, system.semi_axes)
    i, j, vectors = close_images(np.asarray(system.positions), np.max(system.semi_axes, axis=1) * (1 + gap), np.asarray(system.box))
    return i, j, (reference.pw_batch(shapes[i], shapes[j], vectors) if len(i) else np.empty(0))


def smallest_scale(system):
    """Factor by which all bodies must be scaled for the closest pair to touch."""
    _, _, f = contact_functions(system, 0.1)
    return float(np.sqrt(f.min())) if len(f) else np.inf


def contact_counts(system, tolerance):
    """Contacts of every body: images for which |sqrt(F) - 1| is below the tolerance."""
    i, j, f = contact_functions(system, 0.1)
    touching = abs(np.sqrt(f) - 1) < tolerance
    n = len(system.positions)
    return np.bincount(i[touching], minlength=n) + np.bincount(j[touching], minlength=n)


def packing_fraction(system):
    return 4 * np.pi / 3 * np.prod(system.semi_axes, axis=1).sum() / abs(np.linalg.det(system.box))


def solid_moments(semi_axes, masses):
    """Principal moments (n, 3) of uniform solids."""
    squares = np.asarray(semi_axes)**2
    return np.asarray(masses)[:, None] / 5 * (squares.sum(axis=1, keepdims=True) - squares)


def body_spin(system):
    """Angular velocities (n, 3) in the frames of the bodies."""
    return np.einsum("nji,nj->ni", rotation_matrices(system.orientations), system.angular_velocities)


def energies(system, moments=None):
    """Kinetic energy of translation, and of rotation as a (3,) sum over bodies for each principal axis."""
    moments = solid_moments(system.semi_axes, system.masses) if moments is None else moments
    return 0.5 * (system.masses[:, None] * system.velocities**2).sum(), 0.5 * (moments * body_spin(system)**2).sum(axis=0)


def momentum(system):
    return (system.masses[:, None] * system.velocities).sum(axis=0)


def block_mean(series):
    """Mean of block averages and its standard error."""
    series = np.asarray(series, dtype=float)
    return series.mean(axis=0), series.std(axis=0, ddof=1) / np.sqrt(len(series))


def same_bits(a, b):
    """Whether two systems are the same to the last bit in all that moves."""
    names = ("positions", "velocities", "orientations", "angular_velocities", "semi_axes", "box", "masses")
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in names)


def as_system(**arrays):
    return SimpleNamespace(**arrays)
