"""What is in this file? The numbers that a person asks first."""

from __future__ import annotations

import MDAnalysis as mda
import numpy as np

from analysis.contacts import ContactNumbers
from analysis.order import NematicOrder
from ccd.annotations import Any, AnyPath


def summarize(path: AnyPath, gap: float = 1e-3) -> dict[str, Any]:
    """A dict about the run in an edmd file, read through an MDAnalysis Universe and about its last frame unless said.

    `frames`, `bodies`, `time`, `collisions` so far, `packing_fraction` by volumes in the cell, `reduced_pressure` P V / (n
    kT) over the interval that ends there (nan: unknown), `contact_number` mean over the bodies that are held (nan when none
    is), `rattlers`, with contacts at mu - 1 < `gap`, `nematic_order`, `director` (3 numbers).
    """
    universe = mda.Universe(path)
    try:
        last = [len(universe.trajectory) - 1]
        contacts = ContactNumbers(universe.atoms, gap=gap).run(frames=last).results
        nematic = NematicOrder(universe.atoms).run(frames=last).results
        ts = universe.trajectory[-1]
        volumes = 4 / 3 * np.pi * universe.atoms.semi_axes.prod(axis=1)
        return {
            "frames": len(universe.trajectory),
            "bodies": len(universe.atoms),
            "time": float(ts.time),
            "collisions": int(ts.data["step"]),
            "packing_fraction": float(volumes.sum() / abs(np.linalg.det(ts.data["cell"]))),
            "reduced_pressure": float(ts.data.get("reduced_pressure", np.nan)),
            "contact_number": float(contacts.mean[0]),
            "rattlers": int(contacts.rattlers[0]),
            "nematic_order": float(nematic.order[0]),
            "director": nematic.director[0].tolist(),
        }
    finally:
        universe.trajectory.close()
