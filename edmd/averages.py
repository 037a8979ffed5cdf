"""Averages over an interval of a run, from what its collisions added up."""

from typing import NamedTuple

import numpy as np


class Interval(NamedTuple):
    """Sums over an interval: its time, collisions, virial (impulse times distance along the normal), time integral of the energy."""

    time: float = 0.0
    collisions: int = 0
    virial: float = 0.0
    energy_time: float = 0.0

    def plus(self, other):
        return Interval(*(a + b for a, b in zip(self, other)))

    def minus(self, other):
        return Interval(*(a - b for a, b in zip(self, other)))

    def means(self, n, degrees, volume):
        """For n bodies with so many degrees of freedom in a volume; nan where nothing has happened."""
        if self.time <= 0:
            return Means(np.nan, np.nan, np.nan, np.nan)
        temperature = 2 * self.energy_time / (self.time * degrees)
        excess = self.virial / (3 * self.time)
        return Means(temperature, (n * temperature + excess) / volume, 1 + excess / (n * temperature) if temperature > 0 else np.nan,
                     2 * self.collisions / (n * self.time))


class Means(NamedTuple):
    """temperature kT = 2 E / degrees of freedom, pressure P, reduced_pressure P V / (n kT), collision_rate per particle and time (each
    collision counts for both)."""

    temperature: float
    pressure: float
    reduced_pressure: float
    collision_rate: float
