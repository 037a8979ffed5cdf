"""How far a run has come: a bar on a terminal, plain lines elsewhere, and a log for machines."""

import json
import os
import sys
import time
from datetime import UTC, datetime
from math import inf, isfinite, log
from pathlib import Path

from edmd.observers import Observer, Schedule

LINE_SECONDS = 10.0
BAR_SECONDS = 0.2
LOG_SECONDS = 1.0
FLUID = 30.0            # reduced pressure from which on the logarithm of the pressure measures the way to jamming
FLUID_SHARE = 0.1       # share of the way for what comes before


class Pace:
    """How much of its way a run or a compression has gone, how fast events go, and how long the rest takes at this pace."""

    def __init__(self, until_pressure=None):
        self._until_pressure = until_pressure
        self._began, self._from, self.way, self.speed, self.seconds_left = None, None, 0.0, 0.0, inf

    def see(self, view):
        self.way = max(self.way, min(self._gone(view), 1.0))
        now = time.monotonic()
        if self._began is None:                 # compilation is over
            self._began, self._collisions, self._first = now, view.collisions, self.way
        self.speed = (view.collisions - self._collisions) / max(now - self._began, 1e-9)
        gone = self.way - self._first
        self.seconds_left = (now - self._began) * (1 - self.way) / gone if gone > 0 else inf

    def _gone(self, view):
        """Near jamming every factor of pressure costs the same number of collisions: the logarithm of the pressure is the way gone."""
        course, pressure = view.course, view.means.reduced_pressure
        if self._until_pressure is None and course is None:             # the last upkeep of a compression
            return 1.0
        if self._until_pressure is None and (isfinite(course.until_time) or isfinite(course.until_collisions)):
            return max((view.time - course.from_time) / (course.until_time - course.from_time),
                       (view.collisions - course.from_collisions) / (course.until_collisions - course.from_collisions))
        if self._from is None and pressure > 1:
            self._from = pressure
        until = self._until_pressure or course.until_pressure
        if self._from is not None and until < self._from:               # an expansion
            return log(self._from / pressure) / log(self._from / until)
        until = max(until, 2 * FLUID)
        if pressure > FLUID:
            return FLUID_SHARE + (1 - FLUID_SHARE) * log(pressure / FLUID) / log(until / FLUID)
        return FLUID_SHARE * min(1.0, view.packing_fraction / 0.7)**3


class Progress(Observer):
    """Shows packing fraction, reduced pressure, collisions per second and the time left.

    until_pressure: the reduced pressure at which all is done, for several compressions after each other; default: one run or compression.
    """

    def __init__(self, until_pressure=None, label="packing"):
        super().__init__(Schedule())
        from tqdm import tqdm

        self._pace = Pace(until_pressure)
        self._terminal = sys.stderr.isatty()
        self._bar = tqdm(total=1.0, desc=label, file=sys.stderr, disable=not self._terminal, leave=True,
                         bar_format="{desc} {percentage:3.0f}% |{bar}| {postfix} [{elapsed}<{remaining}]")
        self._label, self._shown = label, time.monotonic()

    def upkeep(self, view):
        pace, now = self._pace, time.monotonic()
        pace.see(view)
        if now - self._shown < (BAR_SECONDS if self._terminal else LINE_SECONDS):
            return
        state = (f"packing fraction {view.packing_fraction:.4f}, pressure {view.means.reduced_pressure:.3g}, "
                 f"{pace.speed / 1000:.0f} k collisions/s")
        if self._terminal:
            self._bar.set_postfix_str(state, refresh=False)
            self._bar.update(pace.way - self._bar.n)
        else:
            left = f", about {pace.seconds_left:.0f} s left" if pace.seconds_left < inf else ""          # not known at the start
            print(f"{self._label} {100 * pace.way:3.0f}%  {state}{left}", file=sys.stderr, flush=True)
        self._shown = now

    def finish(self, view):
        if self._terminal and self._pace.way >= 0.99:
            self._bar.update(1.0 - self._bar.n)

    def close(self):
        self._bar.close()


class Log(Observer):
    """One JSON line at most every second, and one at the end of every run or compression, appended to a file (docs/file_format.md)."""

    def __init__(self, path, stage=0):
        super().__init__(Schedule())
        self.path, self.stage = Path(path), stage
        self._pace, self._written = Pace(), -inf
        self._file = self.path.open("ab")
        self._began = time.monotonic()

    def start(self, view):
        self._pace = Pace()

    def upkeep(self, view):
        self._pace.see(view)
        self._last = view
        if time.monotonic() - self._written > LOG_SECONDS:
            self._line(view)

    def finish(self, view):
        if self._pace.way:
            self._line(self._last)

    def memory(self):
        self._file.flush()
        return {**super().memory(), "bytes": self._file.tell()}

    def restore(self, memory):
        super().restore(memory)
        self._file.truncate(min(memory["bytes"], os.fstat(self._file.fileno()).st_size))
        self._file.seek(0, os.SEEK_END)

    def close(self):
        self._file.close()

    def _line(self, view):
        means, pace = view.means, self._pace
        numbers = {"stage": self.stage, "done": pace.way, "time": view.time, "collisions": view.collisions,
                   "packing_fraction": view.packing_fraction, "reduced_pressure": means.reduced_pressure, "pressure": means.pressure,
                   "temperature": means.temperature, "collision_rate": means.collision_rate, "collisions_per_second": pace.speed,
                   "seconds": time.monotonic() - self._began, "seconds_left": pace.seconds_left}
        line = {"at": datetime.now(UTC).isoformat(timespec="milliseconds")}
        line |= {name: value if isfinite(value) else None for name, value in numbers.items()}
        self._file.write(json.dumps(line).encode() + b"\n")
        self._file.flush()
        self._written = time.monotonic()
