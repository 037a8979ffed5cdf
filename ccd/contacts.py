"""Contacts among many bodies in a periodic cell: contact functions of the close pairs, contact numbers, rattlers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ccd import batch, checks
from ccd.annotations import ArrayLike
from ccd.culling import close_pairs

CONTACTS_TO_BE_HELD = 4         # d + 1: with fewer, the contact normals of a body cannot balance


def contact_functions(positions, orientations, semi_axes, cell, gap=0.0):
    """The pairs of images whose bounding spheres touch when scaled by 1 + gap, and their contact functions f, eq. (1).

    positions (n, 3), orientations (n, 4), semi_axes (n, 3), cell (3, 3) with the cell vectors as rows. -> first (m,), second (m,), f (m,);
    a pair that is close through several images stands there once for each, and so does a body that is close to its own image.
    """
    positions = checks.real_array("positions", positions, (None, 3), "an array (n, 3)")
    n = len(positions)
    orientations = checks.unit_quaternions("orientations", orientations, (n, 4), f"quaternions ({n}, 4)")
    semi_axes = checks.semi_axes("semi_axes", semi_axes, (n, 3), f"({n}, 3) positive lengths")
    cell = checks.cell_vectors("cell", cell)
    gap = checks.real_number("gap", gap, "a number not below 0", at_least=0)
    first, second, separation = close_pairs(positions, semi_axes.max(axis=1) * (1 + gap), cell)
    f = batch.contact_function(batch.Bodies(semi_axes[first], np.zeros_like(separation), orientations[first]),
                               batch.Bodies(semi_axes[second], separation, orientations[second]))
    return first, second, f


def contact_pairs(positions: ArrayLike, orientations: ArrayLike, semi_axes: ArrayLike, cell: ArrayLike,
                  gap: float = 1e-3) -> NDArray[np.int64]:
    """Pairs of bodies in contact (m, 2): those that would touch if both grew by a factor of at most 1 + gap.

    That factor is mu, the root of the Perram-Wertheim contact function (J. Comput. Phys. 58, 409 (1985)), and mu - 1 < gap is a contact;
    overlapping pairs count. Arguments as for `contact_functions`; gap is positive and has no unit.
    """
    gap = checks.real_number("gap", gap, "a number between 0 and 1, for instance 1e-3", above=0, below=1)
    first, second, f = contact_functions(positions, orientations, semi_axes, cell, gap)
    touching = np.sqrt(f) - 1 < gap
    return np.column_stack([first[touching], second[touching]])


def contact_numbers(pairs: ArrayLike, n: int) -> NDArray[np.int64]:
    """Contacts (n,) of each of n bodies, from the (m, 2) `pairs` of `contact_pairs`; a contact with an own image counts twice."""
    return np.bincount(np.asarray(pairs, dtype=np.int64).ravel(), minlength=n)


def rattlers(pairs: ArrayLike, n: int) -> NDArray[np.bool_]:
    """Which of n bodies (n,) nothing holds.

    Bodies with fewer than d + 1 = 4 contacts are taken away until none is left, since taking one away may free another: the usual rule
    for spheres and ellipsoids (Donev, Connelly, Stillinger and Torquato, Phys. Rev. E 75, 051304 (2007)).
    """
    pairs = np.asarray(pairs, dtype=np.int64).reshape(-1, 2)
    loose = np.zeros(n, dtype=bool)
    while True:
        held = pairs[~loose[pairs].any(axis=1)]
        free = ~loose & (contact_numbers(held, n) < CONTACTS_TO_BE_HELD)
        if not free.any():
            return loose
        loose |= free


def mean_contact_number(pairs, n):
    """Mean number of contacts of the bodies that are held, counting those among themselves; nan when all are rattlers."""
    loose = rattlers(pairs, n)
    held = np.count_nonzero(~loose[np.asarray(pairs, dtype=np.int64).reshape(-1, 2)].any(axis=1))
    return 2 * held / (n - loose.sum()) if not loose.all() else np.nan
