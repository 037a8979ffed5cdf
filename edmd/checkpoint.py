"""Checkpoints: a file beside the trajectory from which a run goes on, bit for bit."""

import time
from pathlib import Path

from edmd.observers import Observer, Schedule
from edmd.simulation import Simulation


class Moments(Schedule):
    """When: so many seconds of wall time after the last one, which `done` tells, and at once when `stop` was called."""

    def __init__(self, seconds):
        self._seconds, self.stopped = seconds, False
        self.done()

    def stop(self, *_):
        self.stopped = True

    def due(self, view):
        return self.stopped or time.monotonic() - self._last >= self._seconds

    def done(self):
        self._last = time.monotonic()


class Checkpoint(Observer):
    """Saves a simulation before a stage and in its course, with the memories of its observers, of which the trajectory is the first. It
    must be the last of all: the others have then seen the moment. `stop` ends the run at the next moment with a KeyboardInterrupt, after a
    last checkpoint."""

    def __init__(self, path, seconds, simulation, observers, stage=0):
        super().__init__(Moments(seconds))
        self.path, self.stage = Path(path), stage
        self._simulation, self._observers = simulation, observers

    def before(self, stage):
        """A checkpoint from which this stage begins."""
        self.stage = stage
        self._save()

    def see(self, view):
        self._save()

    def _save(self):
        self._simulation.save(self.path, {"stage": self.stage, "memories": [observer.memory() for observer in self._observers]})
        self.when.done()
        if self.when.stopped:
            raise KeyboardInterrupt(f"edmd resume {self._observers[0].path} goes on from its checkpoint, {self.path}")

    def stop(self, *_):
        """End the run at the next moment; can be the handler of a signal."""
        self.when.stop()


def read_checkpoint(path):
    """-> the Simulation before its stage or in the course of it, the number of that stage, and the memories of the observers."""
    simulation = Simulation.load(path)
    try:
        return simulation, simulation.notes["stage"], simulation.notes["memories"]
    except (KeyError, TypeError):
        raise ValueError(f"path = {str(path)!r}: a saved state, but no checkpoint of a run") from None
