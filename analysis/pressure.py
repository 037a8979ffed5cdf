"""What are pressure and temperature in equilibrium, and how sure is that? Means of a run's dense series, with errors by blocks."""

from __future__ import annotations

import numpy as np

from analysis.blocks import weighted_mean
from analysis.curves import interval_starts, is_at_rest, read_log
from ccd.annotations import AnyPath

MEANS = ("pressure", "reduced_pressure", "temperature", "collision_rate")


def mean_pressure(path: AnyPath, start: float = -np.inf, stop: float = np.inf) -> dict[str, tuple[float, float]]:
    """Means of a run at constant packing fraction over the times from `start` to `stop`, from the log of its edmd file.

    Returns a dict: "pressure" P, "reduced_pressure" P V / (n kT), "temperature" kT and "collision_rate" (per body and time), each a pair
    (mean, standard error by blocks: `block_error`). A row of the log is the mean over the interval that ends at its time, and counts by the
    length of that; rows whose interval does not lie within [start, stop] do not count: leave out the time in which the run equilibrates.
    ValueError where no row is left, or the packing fraction changes: then there is no equilibrium to be averaged.
    """
    log = read_log(path)
    before = interval_starts(path, log)
    counts = (before >= start) & (log["time"] <= stop) & (log["time"] > before)
    if not counts.any():
        raise ValueError(f"start, stop = {start}, {stop}: no interval of the log of {path} lies between them")
    density = log["packing_fraction"][counts]
    if not is_at_rest(density):
        raise ValueError(f"start, stop = {start}, {stop}: between them the packing fraction of {path} goes from {density.min()} to "
                         f"{density.max()}; means need one that stands still")
    duration = (log["time"] - before)[counts]
    means = {name: weighted_mean(log[name][counts] * duration, duration) for name in MEANS}
    return {name: (float(mean), float(error)) for name, (mean, error) in means.items()}
