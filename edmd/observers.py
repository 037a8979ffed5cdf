"""What to see of a run, and when. Observers are handed a view, a synchronised copy: nothing they do changes the run."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from math import ceil, inf, ulp
from typing import TYPE_CHECKING

from ccd import checks
from ccd.annotations import Any

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from edmd.averages import Interval, Means
    from edmd.system import System


class View:
    """A simulation at a moment: n, seed, rule, time, collisions, contact_time_collisions, packing_fraction, energy, temperature; `system`
    (a synchronised copy) with its `images`.

    interval: the sums of the upkeep interval just done (`averages.Interval`, empty at the start and the end); means: its averages;
    begun: the sums of the next interval so far; course: where the run goes (`simulation.Course`).
    """

    def __init__(self, simulation: Any, interval: Interval) -> None:
        self.n, self.time, self.collisions, self.seed = simulation.n, simulation.time, simulation.collisions, simulation.seed
        self.packing_fraction, self.interval, self.begun = simulation.packing_fraction, interval, simulation.begun
        self.course, self.rule, self.contact_time_collisions = simulation.course, simulation.rule, simulation.contact_time_collisions
        self._simulation = simulation

    @cached_property
    def _copy(self):
        return self._simulation.synchronised()

    @property
    def system(self) -> System:
        return self._copy[0]

    @property
    def images(self) -> NDArray[np.int32]:
        return self._copy[1]

    @property
    def energy(self) -> float:
        return self._simulation.energy

    @property
    def temperature(self) -> float:
        return self._simulation.temperature

    @property
    def means(self) -> Means:
        return self.means_over(self.interval)

    def means_over(self, interval: Interval) -> Means:
        return self._simulation.means_over(interval)


def reached(now, goal):
    """Whether a time or count has come, give or take the rounding of a sum of two times."""
    return goal < inf and now >= goal - 4 * ulp(goal)


class Schedule:
    """When an observer is to see: `start`, then `due` at every moment that `next_time` or `next_collisions` gave."""

    def start(self, view: View) -> None:
        """Called when a run begins."""

    def next_time(self) -> float:
        return inf

    def next_collisions(self) -> float:
        return inf

    def due(self, view: View) -> bool:
        """Whether the moment has come; then the next one is set."""
        return False

    def memory(self) -> dict[str, Any]:
        """Where it is, as JSON can hold it; `restore` brings another one of the same kind there."""
        return vars(self).copy()

    def restore(self, memory: dict[str, Any]) -> None:
        vars(self).update(memory)


class Every(Schedule):
    """When: at every multiple of a time, of a number of collisions, or of collisions per particle (2 collisions / n, rounded up to whole
    ones), counted from the start of the run. Give one of them."""

    def __init__(self, time: float | None = None, collisions: int | None = None, collisions_per_particle: float | None = None) -> None:
        given = {"time": time, "collisions": collisions, "collisions_per_particle": collisions_per_particle}
        chosen = {name: value for name, value in given.items() if value is not None}
        if len(chosen) != 1:
            raise ValueError(f"{type(self).__name__}({', '.join(chosen) or 'nothing'}): expected exactly one of {', '.join(given)}")
        (self.unit, value), = chosen.items()
        self.interval = checks.real_number(self.unit, value, "a positive number", above=0)

    def start(self, view: View) -> None:
        self._start, self._times = self._now(view), 0
        if self._start + self.interval == self._start:
            raise ValueError(f"{type(self).__name__}({self.unit}={self.interval}): too short to be told from no time at all")
        self._set_next(view)

    def next_time(self) -> float:
        return self._next if self.unit == "time" else inf

    def next_collisions(self) -> float:
        return self._next if self.unit != "time" else inf

    def due(self, view: View) -> bool:
        if not reached(self._now(view), self._next):
            return False
        while reached(self._now(view), self._next):
            self._set_next(view)
        return True

    def _set_next(self, view):
        self._times += 1
        if self.unit == "time":
            self._next = self._start + self._way()
        else:
            self._next = self._start + ceil(self._way() * (view.n / 2 if self.unit == "collisions_per_particle" else 1))

    def _way(self):
        """From the start to the next moment."""
        return self._times * self.interval

    def _now(self, view):
        return view.time if self.unit == "time" else view.collisions


class Logarithmic(Every):
    """When: after a first time (or number of collisions, or of collisions per particle), and then `per_decade` times for every factor of
    ten, at first * 10**(k / per_decade), counted from the start of the run. Whole collisions that come twice count once."""

    def __init__(self, time: float | None = None, collisions: int | None = None, collisions_per_particle: float | None = None,
                 per_decade: float = 10) -> None:
        super().__init__(time, collisions, collisions_per_particle)
        self.per_decade = checks.real_number("per_decade", per_decade, "a positive number", above=0)

    def _way(self):
        return self.interval * 10**((self._times - 1) / self.per_decade)


class Milestones(Schedule):
    """When: as the packing fraction has risen by a step, or the reduced pressure by a factor. Looked at after every upkeep interval."""

    def __init__(self, packing_fraction: float = 0.01, pressure_factor: float = 2.0) -> None:
        self.step = checks.real_number("packing_fraction", packing_fraction, "a positive number", above=0)
        self.factor = checks.real_number("pressure_factor", pressure_factor, "a number above 1", above=1)
        self._fraction = -inf
        self._pressure: float | None = None

    def start(self, view: View) -> None:
        self._fraction, self._pressure = view.packing_fraction, None

    def due(self, view: View) -> bool:
        if view.begun.time > 0:             # between two upkeeps, where only others have a reason to look
            return False
        pressure = view.means.reduced_pressure
        if self._pressure is None and pressure == pressure:
            self._pressure = pressure
        risen = self._pressure is not None and pressure > self.factor * self._pressure
        if not risen and view.packing_fraction < self._fraction + self.step:
            return False
        self._fraction, self._pressure = view.packing_fraction, pressure
        return True


class Observer:
    """Something that sees a run: subclass with `see(view)`, or give a function of the view. `when`: a schedule, Every(...),
    Logarithmic(...) or Milestones(...).

    An observer that can go on after a restart says in `memory` what it must know then, and takes it back in `restore`.
    """

    restored = False

    def __init__(self, when: Schedule, see: Callable[[View], object] | None = None) -> None:
        if not isinstance(when, Schedule):
            raise ValueError(f"when = {when!r}: expected edmd.Every(...), edmd.Logarithmic(...) or edmd.Milestones(...)")
        self.when = when
        if see is not None:
            if not callable(see):
                raise ValueError(f"see = {see!r}: expected a function of the view")
            self.see = see      # type: ignore[method-assign, assignment]

    def start(self, view: View) -> None:
        """Called before the first event."""

    def see(self, view: View) -> None:
        """Called when `when` says."""

    def upkeep(self, view: View) -> None:
        """Called after every upkeep interval of a few collisions a body: for progress and logs."""

    def finish(self, view: View) -> None:
        """Called after the last event."""

    def memory(self) -> dict[str, Any]:
        """What it must know to go on, as JSON can hold it."""
        return {"when": self.when.memory()}

    def restore(self, memory: dict[str, Any]) -> None:
        """Be as the one whose memory this is; `Simulation.resume` then does not start it again."""
        self.when.restore(memory["when"])
        self.restored = True
