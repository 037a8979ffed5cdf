"""Checkpoints: a file beside the trajectory from which a run goes on, bit for bit."""

import time
from pathlib import Path

from edmd.observers import Observer, Schedule
from edmd.simulation import Simulation


class Moments(Schedule):
    """When: after so many seconds of wall time, and at once when `stop` was called. The first moment is the first there is."""

    def __init__(self, seconds):
        self._seconds, self._last, self.stopped = seconds, -float("inf"), False

    def stop(self, *_):
        self.stopped = True

    def due(self, view):
        if not self.stopped and time.monotonic() - self._last < self._seconds:
            return False
        self._last = time.monotonic()
        return True


class Checkpoint(Observer):
    """Saves a simulation in the course of a stage, with the memories of its observers. It must be the last of them: the others have then
    seen the moment. `stop` ends the run at the next moment with a KeyboardInterrupt, after a last checkpoint."""

    def __init__(self, path, seconds, simulation, observers):
        super().__init__(Moments(seconds))
        self.path, self.stage = Path(path), 0
        self._simulation, self._observers = simulation, observers

    def see(self, view):
        self._simulation.save(self.path, {"stage": self.stage, "memories": [observer.memory() for observer in self._observers]})
        if self.when.stopped:
            raise KeyboardInterrupt(f"edmd resume goes on from {self.path}")

    def stop(self, *_):
        """End the run at the next moment; can be the handler of a signal."""
        self.when.stop()


def read_checkpoint(path):
    """-> the Simulation in the course of its stage, the number of that stage, and the memories of the observers."""
    simulation = Simulation.load(path)
    try:
        return simulation, simulation.notes["stage"], simulation.notes["memories"]
    except (KeyError, TypeError):
        raise ValueError(f"path = {str(path)!r}: a saved state, but no checkpoint of a run") from None
