"""Who touches whom, and who is held? Contacts by the Perram-Wertheim scale, contact numbers and rattlers."""

import numpy as np
from MDAnalysis.analysis.base import AnalysisBase

import ccd
from analysis.neighbors import checked_frame, near_pairs

CONTACTS_TO_BE_HELD = 4  # d + 1: with fewer, the contact normals of a body cannot balance


def contact_pairs(positions, orientations, semi_axes, cell, gap=1e-3):
    """Pairs of bodies in contact: those that would touch if both grew by a factor of at most 1 + gap.

    That factor is mu, the root of the Perram-Wertheim contact function (J. Comput. Phys. 58, 409 (1985)), and mu - 1 < gap
    is a contact; overlapping pairs count. `positions` (n, 3), `orientations` (n, 4) unit quaternions, scalar first,
    `semi_axes` (n, 3), `cell` (3, 3) with the cell vectors as rows, all in double precision; `gap` without unit, positive.
    In a small cell a pair can touch through several images, and a body its own image: such a pair stands there once for
    each contact. Returns (m, 2) int64.
    """
    positions, cell = checked_frame(positions, cell)
    orientations, semi_axes = np.asarray(orientations, dtype=float), np.asarray(semi_axes, dtype=float)
    n = len(positions)
    if orientations.shape != (n, 4):
        raise ValueError(f"orientations: shape {orientations.shape}; one quaternion a body is needed, {(n, 4)}")
    if semi_axes.shape != (n, 3) or not np.all(semi_axes > 0):
        raise ValueError(f"semi_axes: shape {semi_axes.shape}; one row of three positive lengths a body is needed, {(n, 3)}")
    if not 0 < gap < np.inf:
        raise ValueError(f"gap: {gap}; a positive number is needed, for instance 1e-3")
    radii = semi_axes.max(axis=1) * (1 + gap)
    first, second, separation = near_pairs(positions, cell, 2 * radii.max())
    close = np.linalg.norm(separation, axis=1) <= radii[first] + radii[second]
    first, second, separation = first[close], second[close], separation[close]
    bodies_a = ccd.Bodies(semi_axes[first], np.zeros_like(separation), orientations[first])
    bodies_b = ccd.Bodies(semi_axes[second], separation, orientations[second])
    touching = np.sqrt(ccd.batch.contact_function(bodies_a, bodies_b)) - 1 < gap
    return np.column_stack([first[touching], second[touching]]).astype(np.int64)


def contact_numbers(pairs, n):
    """Contacts of each of n bodies, from the (m, 2) `pairs` of `contact_pairs`; a contact with an own image counts twice.

    Returns (n,).
    """
    return np.bincount(np.asarray(pairs, dtype=np.int64).ravel(), minlength=n)


def rattlers(pairs, n):
    """Which of n bodies nothing holds? True for those, (n,).

    Bodies with fewer than d + 1 = 4 contacts are taken away until none is left, since taking one away may free another: the
    usual rule for spheres and ellipsoids (Donev, Connelly, Stillinger and Torquato, Phys. Rev. E 75, 051304 (2007)).
    """
    pairs = np.asarray(pairs, dtype=np.int64).reshape(-1, 2)
    loose = np.zeros(n, dtype=bool)
    while True:
        held = pairs[~loose[pairs].any(axis=1)]
        free = ~loose & (contact_numbers(held, n) < CONTACTS_TO_BE_HELD)
        if not free.any():
            return loose
        loose |= free


class ContactNumbers(AnalysisBase):
    """Contacts between the atoms along a trajectory: `ContactNumbers(u.atoms, gap=1e-3).run()`.

    `results.contact_numbers` (frames, n) counts all contacts; `results.rattlers` (frames,) is the number of rattlers;
    `results.mean` (frames,) is the mean contact number of the rest, by contacts among themselves, nan where all are
    rattlers. Functions of the same file do the work.
    """

    def __init__(self, atomgroup, gap=1e-3, **kwargs):
        super().__init__(atomgroup.universe.trajectory, **kwargs)
        self.atomgroup, self.gap = atomgroup, gap

    def _prepare(self):
        self.results.contact_numbers = np.empty((self.n_frames, len(self.atomgroup)), dtype=np.int64)
        self.results.rattlers = np.empty(self.n_frames, dtype=np.int64)
        self.results.mean = np.empty(self.n_frames)

    def _single_frame(self):
        atoms, n = self.atomgroup, len(self.atomgroup)
        shapes = atoms.orientations, atoms.semi_axes
        pairs = contact_pairs(self._ts.data["position"][atoms.ix], *shapes, self._ts.data["cell"], self.gap)
        loose = rattlers(pairs, n)
        held_contacts = np.count_nonzero(~loose[pairs].any(axis=1))
        self.results.contact_numbers[self._frame_index] = contact_numbers(pairs, n)
        self.results.rattlers[self._frame_index] = loose.sum()
        self.results.mean[self._frame_index] = 2 * held_contacts / (n - loose.sum()) if not loose.all() else np.nan
