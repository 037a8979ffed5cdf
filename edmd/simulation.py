"""Simulation: blocks of events between observers, compression, velocities anew, and what has gone wrong in words."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from functools import cached_property
from math import inf, isinf, sqrt
from typing import TYPE_CHECKING, NamedTuple
from zipfile import BadZipFile, ZipFile

import numpy as np
from numpy.typing import NDArray

from ccd import checks
from ccd.annotations import Any, AnyPath, ArrayLike
from ccd.precession import symmetry_axes
from ccd.quaternions import products, rotations, to_lab
from edmd import building, epoch, state
from edmd.averages import Interval, Means
from edmd.compression import GIVE_UP, IDLE, OPENED, check_growth, checked_packing_fraction, checked_pressure, checked_rates
from edmd.engine import advance_events
from edmd.events import Ended
from edmd.inertia import angular_momenta, angular_velocities, degrees_of_freedom, own_spin
from edmd.observers import View, reached
from edmd.ordering import spatial_order
from edmd.outputs import check_output, written_whole
from edmd.rules.kinds import chosen_rule, rule_of
from edmd.rules.rough import Rough
from edmd.stall import at_rest, time_stands_still
from edmd.state import EPOCH, GROWTH, HORIZON, NOW, SIZE
from edmd.system import System
from edmd.tolerances import FOREVER, OVERLAP
from edmd.velocities import thermalized

if TYPE_CHECKING:
    from edmd.observers import Observer

STALL_PATH = "edmd.stalled.npz"
FORMAT = 11                 # of what `save` writes


class Course(NamedTuple):
    """Where a run or a compression came from and where it goes: what `Simulation.resume` needs to go on with it."""

    from_time: float
    from_collisions: int
    until_time: float = inf
    until_collisions: float = inf
    until_pressure: float = inf
    until_packing_fraction: float | None = None
    grows: bool = False
    rates: tuple = ()           # pairs (reduced pressure, rate) still to come


class Simulation:
    """Event-driven dynamics of a System: hard ellipsoids in free flight between collisions, smooth and elastic ones unless a rule is given.

    restitution: normal restitution of smooth bodies, 0 to 1. rule: instead of it edmd.Elastic(), Inelastic(...), Viscoelastic(...),
    PowerLaw(...) or Rough(...), or the name of one, with that restitution (docs/granular.md). ValueError when bodies overlap or the cell is
    too small. seed is kept with the run for its records; the dynamics draws no numbers.
    One system, one result: every run repeats bit for bit, whatever looks at it and however it is cut into blocks.
    A run that cannot go on raises edmd.Stalled, and leaves its state in stall_path. course: where the run or compression goes that is under
    way, or in whose course the state was saved; else None. notes: those of `save`.
    """

    def __init__(self, system: System, seed: int = 0, restitution: float = 1.0, rule: Any = None) -> None:
        if not isinstance(system, System):
            raise ValueError(f"system = {system!r}: expected an edmd.System")
        first, second, f = system.contact_functions()
        if len(f) and sqrt(f.min()) < 1 - OVERLAP:
            one, other, factor = first[f.argmin()], second[f.argmin()], f"(they touch when scaled by {sqrt(f.min()):.6g})"
            if one == other:
                raise ValueError(f"system: body {one} and its own periodic image overlap {factor}; expected a larger box")
            raise ValueError(f"system: bodies {one} and {other} overlap {factor}; expected a start without overlap")
        self.seed, self.rule = checks.natural_number("seed", seed), chosen_rule(restitution, rule)
        self._system = system.makeup()
        self._order = spatial_order(system.positions, system.box)          # of the bodies in the world
        self._world = building.build_world(system.subset(self._order), self.rule)
        self._spin = np.zeros(system.n) if self._rough else own_spin(system)
        self._grown_inertia = 1.0
        self._done = self._before = self._last = Interval()
        self.course: Course | None = None
        self.notes, self.stall_path = None, STALL_PATH
        self.last_means = self.means_over(Interval())

    # what is now

    @property
    def n(self) -> int:
        return self._system.n

    @property
    def time(self) -> float:
        return float(self._world.clock[EPOCH] + self._world.clock[NOW])

    @property
    def collisions(self) -> int:
        """Collisions since the start; each counts once for its pair."""
        return int(self._world.tally[state.COLLISIONS])

    @property
    def size(self) -> float:
        """Factor on the semi-axes since the start."""
        clock = self._world.clock
        return float(clock[SIZE] + clock[GROWTH] * clock[NOW])

    @property
    def contact_time_collisions(self) -> int:
        """Collisions since the start that the TC model made elastic (the rule's contact_time)."""
        return int(self._world.tally[state.SPARED])

    @property
    def _rough(self):
        return isinstance(self.rule, Rough)

    @cached_property
    def _degrees(self):
        return degrees_of_freedom(self._system, self._rough)

    @property
    def packing_fraction(self) -> float:
        return self._system.packing_fraction * self.size**3

    @property
    def energy(self) -> float:
        """Kinetic energy that collisions exchange (without the spin of smooth bodies of revolution about their axes)."""
        return float(epoch.kinetic_energy(self._world))

    @property
    def temperature(self) -> float:
        """kT = 2 E / (3 n - 3 + active rotational degrees of freedom)."""
        return 2 * self.energy / self._degrees

    @property
    def nematic_order(self) -> float:
        """Largest eigenvalue of the mean of (3 u u - 1) / 2 over the symmetry axes u (the longest axis where all three differ)."""
        system = self.system
        kinds = symmetry_axes(system.semi_axes)
        axis = np.where(kinds == 3, system.semi_axes.argmax(axis=1), np.minimum(kinds, 2))
        u = to_lab(system.orientations, np.eye(3)[axis])
        return float(np.linalg.eigvalsh(1.5 * (u.T @ u) / len(u) - 0.5 * np.eye(3))[-1])

    @property
    def system(self) -> System:
        """A synchronised copy of the bodies; reading it never changes the run."""
        return self.synchronised()[0]

    def synchronised(self) -> tuple[System, NDArray[np.int32]]:
        """The System of now, positions in the cell, and the images (n, 3) they belong to: unwrapped = positions + images @ box."""
        rows, images = building.synchronised_rows(self._world, np.argsort(self._order))
        like = self._system
        spun = rotations(np.eye(3)[np.minimum(symmetry_axes(like.semi_axes), 2)] * (self._spin * self.time)[:, None])
        system = System(rows.positions, products(rows.orientations, spun), like.semi_axes * self.size, like.box, rows.velocities,
                        None, like.masses, like.inertia, like.species)
        system.moments = like.moments * self._grown_inertia
        system.angular_velocities = angular_velocities(system.orientations, rows.momenta, system.moments)
        if not isinstance(like.inertia, str):
            system.inertia = system.moments
        return system, images

    # what was seen over the most recent run or compression

    @property
    def means(self) -> Means:
        """Averages over the most recent run() or compress(): see `averages.Means`."""
        return self.means_over(self._done.plus(self.begun).minus(self._before))

    @property
    def pressure(self) -> float:
        return self.means.pressure

    @property
    def compressibility_factor(self) -> float:
        """Z = P V / (n kT)."""
        return self.means.reduced_pressure

    @property
    def collision_rate(self) -> float:
        """Collisions per particle per time; each counts for both."""
        return self.means.collision_rate

    @property
    def begun(self) -> Interval:
        """The sums since the last upkeep (`averages.Interval`)."""
        clock, tally = self._world.clock, self._world.tally
        energy_time = clock[state.ENERGY_TIME] + clock[state.ENERGY] * (clock[NOW] - clock[state.ENERGY_SINCE])
        return Interval(float(clock[NOW]), int(tally[state.COLLISIONS] - tally[state.EPOCH_BEGAN]), float(clock[state.VIRIAL]),
                        float(energy_time))

    def means_over(self, interval: Interval) -> Means:
        """Averages over an `averages.Interval` of this simulation."""
        return interval.means(self.n, self._degrees, self._system.volume)

    # what can be done

    def run(self, time: float | None = None, collisions: int | None = None, collisions_per_particle: float | None = None,
            observers: Iterable[Observer] = ()) -> Simulation:
        """Go on for a time, or for a number of collisions, in all or per particle (2 collisions / n). Exactly one is given."""
        given = {"time": time, "collisions": collisions, "collisions_per_particle": collisions_per_particle}
        chosen = [name for name, value in given.items() if value is not None]
        if len(chosen) != 1:
            raise ValueError(f"run({', '.join(chosen)}): expected exactly one of {', '.join(given)}")
        length = checks.real_number(chosen[0], given[chosen[0]], "a positive number", above=0)
        until_time = self.time + length if time is not None else inf
        until_collisions = inf
        if time is None:
            if self.energy == 0:
                raise ValueError(f"{chosen[0]} = {length}: the bodies are at rest and never collide; expected a time, or a start with "
                                 "velocities (edmd.thermalized)")
            wanted = round(length if collisions is not None else length * self.n / 2)
            if wanted < 1:
                raise ValueError(f"{chosen[0]} = {length}: less than one collision")
            until_collisions = self.collisions + wanted
        self._begin(observers)
        return self._follow(Course(self.time, self.collisions, until_time, until_collisions), observers)

    def compress(self, rate: ArrayLike | Mapping[float, float], until_pressure: float | None = None,
                 until_packing_fraction: float | None = None, observers: Iterable[Observer] = ()) -> Simulation:
        """Let all semi-axes grow as 1 + rate t (Lubachevsky and Stillinger) at kT = 1, to a reduced pressure P V / (n kT), at most 1e12, or
        to a packing fraction, which is met exactly. Exactly one is given. A negative rate expands: down to a pressure, or to a fraction.

        rate: one, or a schedule {0: 1e-2, 100: 1e-3, ...} (or pairs): the second takes over when the pressure has first come to 100,
        counted anew from the sizes of that moment, and so on; it never goes back.
        Velocities are rescaled to kT = 1 every few collisions a body, where the moments of inertia follow the size, the pressure is
        measured, and a pressure to come to is noticed. The masses stay. Smooth growth pumps energy: the pressure is that at the mean
        temperature of the interval. ValueError in words for what cannot be; RuntimeError `Stalled` for what could not go on.
        """
        (_, rate), *slower = rates = checked_rates("rate", rate)
        if (until_pressure is None) == (until_packing_fraction is None):
            raise ValueError(f"until_pressure = {until_pressure}, until_packing_fraction = {until_packing_fraction}: expected exactly one "
                             "of until_pressure and until_packing_fraction")
        if self.energy == 0:
            raise ValueError(f"rate = {rate}: the bodies are at rest and compression needs a temperature; see Simulation.thermalize")
        for _, one in rates:
            check_growth("rate", one, self.size * self._system.semi_axes.max() * sqrt(self._system.masses.max()))
        if until_pressure is not None:
            until_pressure = checked_pressure(until_pressure)
        if until_packing_fraction is not None:
            until_packing_fraction = checked_packing_fraction(until_packing_fraction, self.packing_fraction, rate)
        self._refuse_in_the_course_of_a_compression()
        if rate < 0:
            self._open_contacts()
        self._to_unit_temperature()
        self._begin(observers)
        self._act(epoch.set_growth, rate * self.size)
        give_up = GIVE_UP if rate > 0 else 0.0          # bodies that shrink cannot jam, even from contact
        until_time = self._time_at(until_packing_fraction, rate)
        return self._follow(Course(self.time, self.collisions, until_time, until_pressure=until_pressure or give_up,
                                   until_packing_fraction=until_packing_fraction, grows=True, rates=tuple(slower)), observers)

    def rescale(self, temperature: float) -> Simulation:
        """Multiply all velocities and angular velocities by one factor, so that the temperature is this kT now. -> self.

        The total momentum is multiplied too. The spin that smooth bodies never change (that of spheres, and of bodies of revolution about
        their axes) stays. ValueError for bodies at rest.
        """
        temperature = checks.real_number("temperature", temperature, "a positive number (kT)", above=0)
        self._refuse_in_the_course_of_a_compression()
        if self.energy == 0:
            raise ValueError(f"temperature = {temperature}: the bodies are at rest; expected some velocities (Simulation.thermalize)")
        self._new_epoch(lambda: epoch.start_epoch(self._world))
        epoch.rescale(self._world, sqrt(temperature / self.temperature), 1.0)
        return self

    def thermalize(self, temperature: float = 1.0, seed: int | None = None) -> Simulation:
        """Draw velocities and angular velocities anew from the Maxwell distribution: no total momentum, and exactly this kT. -> self.

        seed: of the draw; by default that of the simulation. The spin that smooth bodies never change stays.
        """
        drawn = thermalized(self.system, self.seed if seed is None else checks.natural_number("seed", seed), temperature,
                            "counted" if self._rough else "drawn")
        self._refuse_in_the_course_of_a_compression()
        self._new_epoch(lambda: epoch.start_epoch(self._world))
        building.set_pace(self._world, drawn.velocities)
        epoch.set_velocities(self._world, drawn.velocities[self._order], angular_momenta(drawn)[self._order])
        return self

    def resume(self, observers: Iterable[Observer] = ()) -> Simulation:
        """Go on with the run() or compress() during which `save` wrote this state, to where that was to end: bit for bit as if it had never
        been interrupted. Observers are started, but for those that `Observer.restore` brought back to where they were."""
        if self.course is None:
            raise ValueError("nothing to resume: the state was not saved in the course of a run or a compression")
        view = View(self, Interval())
        for observer in observers:
            if not observer.restored:
                observer.when.start(view)
                observer.start(view)
        return self._follow(self.course, observers)

    def verify(self) -> None:
        """Check every invariant of the run: AssertionError says what is wrong."""
        from edmd.verify import verify_world

        verify_world(self._world, self.system)

    def save(self, path: AnyPath, notes: Any = None) -> None:
        """Write the exact state to a file, with notes that JSON can hold; `Simulation.load` goes on from it bit for bit."""
        file_path = check_output(path, overwrite=True)
        arrays = {f"world.{name}": array for name, array in building.flattened(self._world)}
        like = self._system
        arrays |= {f"system.{name}": getattr(like, name) for name in ("semi_axes", "box", "masses", "species", "moments")}
        facts = {"inertia": like.inertia if isinstance(like.inertia, str) else "moments", "seed": self.seed,
                 "grown_inertia": self._grown_inertia, "done": self._done, "before": self._before, "last_means": self.last_means,
                 "last": self._last, "course": self.course, "notes": notes, "rule": self.rule.document(), "format": FORMAT}
        with written_whole(file_path) as partial, open(partial, "wb") as file:
            np.savez(file, facts=json.dumps(facts), spin=self._spin, order=self._order, **arrays)

    @classmethod
    def load(cls, path: AnyPath) -> Simulation:
        """The simulation that `save` wrote."""
        try:
            with ZipFile(path), np.load(path, allow_pickle=False) as saved:         # numpy advises to load what is no zip file as a pickle
                arrays = {name: saved[name] for name in saved.files}
            facts = json.loads(str(arrays.pop("facts")))
            if facts["format"] != FORMAT:
                raise ValueError(f"its format is {facts['format']}, this version of edmd reads {FORMAT}")
            system = {name.removeprefix("system."): array for name, array in arrays.items() if name.startswith("system.")}
            moments, n = system.pop("moments"), len(system["semi_axes"])
            simulation = cls.__new__(cls)
            simulation._system = System(np.zeros((n, 3)), np.eye(4)[np.zeros(n, dtype=int)], **system,
                                        inertia=facts["inertia"] if facts["inertia"] != "moments" else moments).makeup()
            simulation._world = building.unflattened({name.removeprefix("world."): array for name, array in arrays.items()
                                                      if name.startswith("world.")})
            simulation._spin, simulation._order, simulation.seed = arrays["spin"], arrays["order"], facts["seed"]
            simulation._grown_inertia = facts["grown_inertia"]
            simulation._done, simulation._before = Interval(*facts["done"]), Interval(*facts["before"])
            simulation.last_means, simulation._last = Means(*facts["last_means"]), Interval(*facts["last"])
            simulation.notes, simulation.rule, simulation.stall_path = facts["notes"], rule_of(facts["rule"]), STALL_PATH
            simulation.course = None if facts["course"] is None else Course(*facts["course"])
        except (OSError, EOFError, BadZipFile, ValueError, KeyError, TypeError) as problem:
            raise ValueError(f"path = {str(path)!r}: not a state written by Simulation.save ({problem})") from None
        return simulation

    # blocks of events

    def _refuse_in_the_course_of_a_compression(self):
        if self.course is not None and self.course.grows:
            raise ValueError("the state was saved in the course of a compression; expected resume(), which goes on with it")

    def _begin(self, observers):
        self._refuse_in_the_course_of_a_compression()
        self._done, self._before, self._last = Interval(), self.begun, Interval()
        view = View(self, Interval())
        for observer in observers:
            observer.when.start(view)
            observer.start(view)

    def _follow(self, course, observers):
        """A course to its end, with all that begins and ends it but the start of the observers."""
        self.course = course
        try:
            course = self._go(course, observers)
            jammed = course.until_packing_fraction is not None and not reached(self.time, course.until_time)
            if course.until_packing_fraction is not None and not jammed:
                self._meet_packing_fraction(course.until_packing_fraction)
        finally:
            self.course = None
            if course.grows:
                self._act(epoch.set_growth, 0.0)
                interval = self._new_epoch(self._to_unit_temperature)
        if course.grows and interval.collisions:
            for observer in observers:
                observer.upkeep(View(self, interval))
        for observer in observers:
            observer.finish(View(self, Interval()))
        if jammed:
            raise ValueError(f"until_packing_fraction = {course.until_packing_fraction}: the bodies jam at {self.packing_fraction:.6f}; "
                             "expected less, or a slower rate")
        return self

    def _go(self, course, observers):
        """Events until the course ends, in blocks that end where an observer is due. -> the course, with the rates still to come."""
        upkeep = self._to_unit_temperature if course.grows else lambda: epoch.start_epoch(self._world)
        while not self._arrived(course):
            time = min([course.until_time, *(observer.when.next_time() for observer in observers)])
            collisions = min([course.until_collisions, *(observer.when.next_collisions() for observer in observers)])
            if self._block(time, collisions) == Ended.EPOCH or self._world.clock[NOW] >= self._longest_epoch():
                self._last = self._new_epoch(upkeep)
                self.last_means = self.means_over(self._last)
                self.course = course = self._slowed(course)
                for observer in observers:
                    observer.upkeep(View(self, self._last))
            for observer in observers:
                if observer.when.due(View(self, self._last)):
                    observer.see(View(self, self._last))
        return course

    def _arrived(self, course):
        """Whether the course has come to its time, its number of collisions or its reduced pressure."""
        pressure = self.means_over(self._last).reduced_pressure
        return (reached(self.time, course.until_time) or self.collisions >= course.until_collisions
                or (pressure <= course.until_pressure if self._world.clock[GROWTH] < 0 else pressure >= course.until_pressure))

    def _slowed(self, course):
        """The course, growing on at the rate that the schedule has for the pressure just measured, if it has come to a new one."""
        rate = None
        while course.rates and self.last_means.reduced_pressure >= course.rates[0][0]:
            (_, rate), *left = course.rates
            course = course._replace(rates=tuple(left))
        if rate is not None:
            course = course._replace(until_time=self._time_at(course.until_packing_fraction, rate))
            self._act(epoch.set_growth, rate * self.size)
        return course

    def _time_at(self, packing_fraction, rate):
        """When growth at this rate from now on comes to a packing fraction; inf without one."""
        return inf if packing_fraction is None else self.time + (np.cbrt(packing_fraction / self.packing_fraction) - 1) / rate

    def _longest_epoch(self):
        return IDLE * self._world.clock[HORIZON] if self._world.clock[GROWTH] < 0 else inf

    def _open_contacts(self):
        _, _, f = self.system.contact_functions()
        if len(f) and sqrt(f.min()) - 1 < OPENED:
            self._world.clock[SIZE] *= 1 - OPENED

    def _new_epoch(self, upkeep):
        """The upkeep that begins a new epoch; -> the sums of the one that ends."""
        interval = self.begun
        self._done = self._done.plus(interval)
        upkeep()
        return interval

    def _block(self, until_time, until_collisions):
        relative = min(until_time - self._world.clock[EPOCH], self._longest_epoch(), FOREVER)
        limit = np.iinfo(np.int64).max if isinf(until_collisions) else int(until_collisions)
        return self._act(advance_events, relative, limit)

    def _act(self, kernel, *arguments):
        self._world, status = building.with_room(self._world, kernel, *arguments)
        if status == Ended.CELL_TOO_SMALL:
            raise ValueError(building.cell_too_small(self._system.box))
        if status == Ended.STALLED:
            raise time_stands_still(self, self._order[self._world.calendar.body[0]])
        if status == Ended.AT_REST:
            raise at_rest(self)
        return status

    def _to_unit_temperature(self):
        epoch.start_epoch(self._world)
        inertia = self.size**2 / self._grown_inertia
        epoch.rescale(self._world, 1 / sqrt(self.temperature), inertia)
        self._grown_inertia *= inertia

    def _meet_packing_fraction(self, goal):
        clock = self._world.clock
        clock[SIZE] = np.cbrt(goal / self._system.packing_fraction) - clock[GROWTH] * clock[NOW]
