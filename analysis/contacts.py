"""Who touches whom, who is held, and how near are the others? The functions of `ccd.contacts` along a trajectory."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from analysis.frames import ThreadedAnalysis
from ccd import checks
from ccd.annotations import Any, ArrayLike, Floats
from ccd.contacts import contact_functions, contact_numbers, contact_pairs, mean_contact_number, rattlers

if TYPE_CHECKING:
    from MDAnalysis import AtomGroup


def gaps(positions: ArrayLike, orientations: ArrayLike, semi_axes: ArrayLike, cell: ArrayLike, largest: float = 0.1) -> Floats:
    """The gaps mu - 1 < `largest` (m,) between bodies, smallest first; a pair that is near through several images counts for each.

    mu, the root of the Perram-Wertheim contact function (J. Comput. Phys. 58, 409 (1985)), is the factor by which both bodies must be
    scaled to touch: the gap has no unit, and is negative where two overlap. Arguments as `contact_pairs`.
    """
    largest = checks.real_number("largest", largest, "a positive number, for instance 0.1", above=0)
    found = np.sqrt(contact_functions(positions, orientations, semi_axes, cell, largest)[2]) - 1
    return np.sort(found[found < largest])


class ContactNumbers(ThreadedAnalysis):
    """Contacts between the atoms along a trajectory: `ContactNumbers(u.atoms, gap=1e-3).run()`.

    A contact is a pair with mu - 1 < `gap`. `results.contact_numbers` (frames, n) counts all contacts; `results.rattlers` (frames,) is the
    number of rattlers, `results.held` (frames, n) whether each body is none; `results.mean` (frames,) is the mean contact number of the
    rest, by contacts among themselves, nan where all are rattlers.
    """

    SERIES = ("contact_numbers", "rattlers", "held", "mean")

    def __init__(self, atomgroup: AtomGroup, gap: float = 1e-3, **kwargs: Any) -> None:
        super().__init__(atomgroup, **kwargs)
        self.gap = gap

    def _frame(self):
        n = len(self.atomgroup)
        pairs = contact_pairs(*self.bodies, self.cell, self.gap)
        loose = rattlers(pairs, n)
        return contact_numbers(pairs, n), loose.sum(), ~loose, mean_contact_number(pairs, n)


class NearContacts(ThreadedAnalysis):
    """How many neighbours does a body have within a gap? `NearContacts(u.atoms, smallest=1e-6, largest=0.1).run()`.

    `results.gap` (bins + 1,), `bins` steps of equal ratio from `smallest` to `largest`; `results.contacts` (bins + 1,) the mean number of
    neighbours of a body with mu - 1 below each gap, overlaps included; `results.density` (bins,) its slope between two gaps, the
    neighbours per body and unit of gap. Means over the frames. Near jamming the first is a plateau at the contact number, and the second
    falls as a power of the gap (Donev, Torquato and Stillinger, Phys. Rev. E 71, 011105 (2005)).
    """

    SERIES = ("contacts",)

    def __init__(self, atomgroup: AtomGroup, smallest: float = 1e-6, largest: float = 0.1, bins: int = 60, **kwargs: Any) -> None:
        super().__init__(atomgroup, **kwargs)
        if not 0 < smallest < largest < np.inf:
            raise ValueError(f"smallest, largest = {smallest}, {largest}: expected 0 < smallest < largest")
        self.edges = np.geomspace(smallest, largest, bins + 1)

    def _frame(self):
        found = gaps(*self.bodies, self.cell, self.edges[-1])
        return (2 * np.searchsorted(found, self.edges) / len(self.atomgroup),)

    def _conclude(self):
        self.results.gap = self.edges
        self.results.contacts = np.mean(self.results.contacts, axis=0)
        self.results.density = np.diff(self.results.contacts) / np.diff(self.edges)
