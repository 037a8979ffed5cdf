"""Who touches whom, and who is held? The functions of `ccd.contacts` along a trajectory."""

import numpy as np
from MDAnalysis.analysis.base import AnalysisBase

from ccd.contacts import contact_numbers, contact_pairs, mean_contact_number, rattlers


class ContactNumbers(AnalysisBase):
    """Contacts between the atoms along a trajectory: `ContactNumbers(u.atoms, gap=1e-3).run()`.

    `results.contact_numbers` (frames, n) counts all contacts; `results.rattlers` (frames,) is the number of rattlers;
    `results.mean` (frames,) is the mean contact number of the rest, by contacts among themselves, nan where all are
    rattlers.
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
        self.results.contact_numbers[self._frame_index] = contact_numbers(pairs, n)
        self.results.rattlers[self._frame_index] = rattlers(pairs, n).sum()
        self.results.mean[self._frame_index] = mean_contact_number(pairs, n)
