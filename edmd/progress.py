"""How far a compression has come: a bar on a terminal, plain lines elsewhere."""

import sys
import time
from math import log

from edmd.observers import Every, Observer

LINE_SECONDS = 10.0
BAR_SECONDS = 0.2
FLUID = 30.0            # reduced pressure from which on the logarithm of the pressure measures the way to jamming
FLUID_SHARE = 0.1       # share of the bar for what comes before


class Progress(Observer):
    """Shows packing fraction, reduced pressure, collisions per second and the time left until a reduced pressure is reached.

    Near jamming every factor of pressure costs the same number of collisions: the logarithm of the pressure is the way gone.
    """

    def __init__(self, until_pressure, label="packing"):
        super().__init__(Every(time=1e300))
        from tqdm import tqdm

        self._until = max(until_pressure, 2 * FLUID)
        self._terminal = sys.stderr.isatty()
        self._bar = tqdm(total=1.0, desc=label, file=sys.stderr, disable=not self._terminal, leave=True,
                         bar_format="{desc} {percentage:3.0f}% |{bar}| {postfix} [{elapsed}<{remaining}]")
        self._collisions, self._way = None, 0.0

    def upkeep(self, view):
        pressure = view.means.reduced_pressure
        if pressure > FLUID:
            way = FLUID_SHARE + (1 - FLUID_SHARE) * log(pressure / FLUID) / log(self._until / FLUID)
        else:
            way = FLUID_SHARE * min(1.0, view.packing_fraction / 0.7)**3
        self._way = max(self._way, min(way, 1.0))
        now = time.monotonic()
        if self._collisions is None:            # compilation is over
            self._collisions, self._began, self._shown = view.collisions, now, now
        if now - self._shown < (BAR_SECONDS if self._terminal else LINE_SECONDS):
            return
        speed = (view.collisions - self._collisions) / max(now - self._began, 1e-9)
        state = f"packing fraction {view.packing_fraction:.4f}, pressure {pressure:.3g}, {speed / 1000:.0f} k collisions/s"
        if self._terminal:
            self._bar.set_postfix_str(state, refresh=False)
            self._bar.update(self._way - self._bar.n)
        else:
            left = (now - self._began) * (1 - self._way) / max(self._way, 1e-3)
            print(f"{100 * self._way:3.0f}%  {state}, about {left:.0f} s left", file=sys.stderr, flush=True)
        self._shown = now

    def finish(self, view):
        if self._terminal and self._way >= 0.99:
            self._bar.update(1.0 - self._bar.n)

    def close(self):
        self._bar.close()
