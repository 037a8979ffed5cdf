"""Every combination of options: all invariants after every event, nothing changed by looking, restart to the bit.

An option is a line in OPTIONS and, where it changes how a run is made, one in `start`, `simulation_of` or `Motion`. The suite takes
combinations in which every pair of choices occurs; all of them are behind the marker `validate`.
"""

from functools import cache
from itertools import combinations, product
from typing import NamedTuple

import independent
import numpy as np
import pytest
from cross_section import few_of

import edmd

PACKING = 0.38                  # of the bodies at full size, less where the cell must be larger
SMALL = 0.4                     # size at which bodies are laid on a grid, before they grow to their own
TIGHT = 1.001                   # width of the smallest cell, in units of the smallest that is accepted
WARM = 50                       # collisions before a run of the matrix; its first upkeep then comes in the middle


class Bodies(NamedTuple):
    """Semi-axes and masses of the species, dealt out in turn."""

    semi_axes: list
    masses: list = (1.0,)


class Motion(NamedTuple):
    """What a run does: `size` at its start, growth at a rate until the packing fraction has changed by a factor, or equilibrium."""

    size: float = 1.0
    rate: float = 0.0
    factor: float = 1.0

    def run(self, simulation, observers=()):
        if self.rate == 0:
            return simulation.run(collisions=LENGTH, observers=observers)
        return simulation.compress(self.rate, until_packing_fraction=simulation.packing_fraction * self.factor, observers=observers)


LENGTH, TAIL = 24, 10           # collisions in equilibrium, and after every motion
OPTIONS = {
    "bodies": {"sphere": Bodies([(1, 1, 1)]), "prolate": Bodies([(1, 1, 1.8)]), "oblate": Bodies([(1, 0.5, 1)]),
               "three axes": Bodies([(1.25, 1, 0.8)]),
               "mixture": Bodies([(1, 1, 1), (0.4, 0.4, 1.2), (1.2, 0.9, 0.5)], (1.0, 0.1, 20.0))},
    "cell": {"cubic": (np.eye(3), (3, 2, 2)), "skewed": (np.array([[1, 0, 0], [0.8, 1, 0], [-0.7, 0.9, 1]]), (3, 3, 3)), "tight": None},
    "motion": {"equilibrium": Motion(), "growth": Motion(0.98, 0.05, 0.98**-3), "shrinking": Motion(1.0, -0.05, 0.98**3)},
    "inertia": {"solid": "solid", "of the sphere": "sphere"},
    "restart": {"no restart": False, "restart": True},
    "observers": {"blocks": False, "observers": True},
}
ALL = [dict(zip(OPTIONS, choice)) for choice in product(*OPTIONS.values())]


IN_SUITE = [ALL[k] for k in few_of([tuple(chosen.items()) for chosen in ALL], together=2)]


def named(chosen):
    return ", ".join(chosen.values())


@cache
def narrowest(bodies):
    """The width of the smallest cubic cell in which each of these bodies is accepted."""
    low, high = 0.0, 100.0
    while high - low > 1e-6 * high:
        width = 0.5 * (low + high)
        low, high = (low, width) if all(accepted(axes, width) for axes in OPTIONS["bodies"][bodies].semi_axes) else (width, high)
    return high


def accepted(semi_axes, box):
    try:
        edmd.Simulation(edmd.System([[0, 0, 0]], [[1, 0, 0, 0]], semi_axes, box))
        return True
    except ValueError:
        return False


def cell_of(bodies, cell):
    """Cell vectors and the grid on which the bodies are laid: at least as wide as it must be for their lists."""
    kind, width = OPTIONS["bodies"][bodies], narrowest(bodies) * TIGHT
    one = 4 * np.pi / 3 * np.mean([np.prod(axes) for axes in kind.semi_axes])
    if cell == "tight":
        edge = np.sqrt(max(12 * one / PACKING / width, width**2))
        return np.diag([edge, edge, width]), (3, 2, 2)
    form, grid = OPTIONS["cell"][cell]
    height = (1 / np.linalg.norm(np.linalg.inv(form), axis=0)).min()
    return form * max(np.cbrt(np.prod(grid) * one / PACKING), width / height), grid


@cache
def start(bodies, cell, inertia):
    """A fluid of these bodies in that cell: laid on a grid while small, turned at random, grown to their size."""
    kind, (box, grid) = OPTIONS["bodies"][bodies], cell_of(bodies, cell)
    rng = np.random.default_rng(8)
    places = (np.array(list(np.ndindex(*grid))) + 0.5) / grid
    n = len(places)
    species = np.arange(n) % len(kind.semi_axes)
    semi_axes, masses = np.array(kind.semi_axes, dtype=float)[species], np.resize(kind.masses, n)
    positions, orientations = rng.permutation(places) @ box, rng.normal(size=(n, 4))
    small = edmd.System(positions, orientations, SMALL * semi_axes, box, masses=masses, inertia=OPTIONS["inertia"][inertia])
    growing = edmd.Simulation(edmd.thermalized(small, 3))
    grown = growing.compress(0.3, until_packing_fraction=small.packing_fraction / SMALL**3 * (1 - 1e-9)).system
    return edmd.thermalized(edmd.System(grown.positions, grown.orientations, semi_axes, box, masses=masses,
                                        inertia=OPTIONS["inertia"][inertia]), 4)


def simulation_of(chosen):
    system, motion = start(chosen["bodies"], chosen["cell"], chosen["inertia"]), OPTIONS["motion"][chosen["motion"]]
    smaller = edmd.System(system.positions, system.orientations, motion.size * system.semi_axes, system.box, masses=system.masses,
                          inertia=system.inertia)
    return edmd.Simulation(edmd.thermalized(smaller, 5)).run(collisions=WARM), motion


def checked_with_observers(simulation, motion, folder, restart):
    """-> simulations that must all have come to the same end: the observed one, and the one saved in its course and loaded."""
    def verify(view):
        simulation.verify()

    def save(view):
        if view.course is not None and not (folder / "state").exists():
            simulation.save(folder / "state")
    seen = [edmd.Observer(edmd.Every(collisions=1), verify), edmd.Observer(edmd.Every(time=simulation.time / WARM * 2.7), verify)]
    motion.run(simulation, [*seen, edmd.Observer(edmd.Every(collisions=7), save)])
    simulation.run(collisions=TAIL, observers=seen)
    if not restart:
        return [simulation]
    return [simulation, edmd.Simulation.load(folder / "state").resume().run(collisions=TAIL)]


def checked_in_blocks(simulation, motion, folder, restart):
    """Blocks of one collision, and before the tail of a short time, with a restart in between; growth knows no blocks."""
    until = simulation.collisions + LENGTH
    if motion.rate != 0:
        motion.run(simulation).verify()
        until = simulation.collisions
    span = simulation.time / simulation.collisions / 1.3
    until += TAIL
    while simulation.collisions < until:
        if restart and simulation.collisions == until - TAIL // 2:
            simulation.save(folder / "state")
            simulation = edmd.Simulation.load(folder / "state")
        early = simulation.collisions < until - TAIL
        simulation.run(time=span) if early and simulation.collisions % 3 == 0 else simulation.run(collisions=1)
        simulation.verify()
    return [simulation]


@pytest.mark.parametrize("chosen", [pytest.param(chosen, id=named(chosen), marks=() if chosen in IN_SUITE else pytest.mark.validate)
                                    for chosen in ALL])
def test_every_event(chosen, tmp_path):
    simulation, motion = simulation_of(chosen)
    straight = motion.run(simulation).run(collisions=TAIL)
    simulation, _ = simulation_of(chosen)
    check = checked_with_observers if OPTIONS["observers"][chosen["observers"]] else checked_in_blocks
    for other in check(simulation, motion, tmp_path, OPTIONS["restart"][chosen["restart"]]):
        assert (other.collisions, other.time, other.energy) == (straight.collisions, straight.time, straight.energy)
        assert independent.same_bits(other.system, straight.system)
    assert independent.smallest_scale(straight.system) > 1 - 1e-11


def test_the_suite_takes_every_pair_of_choices():
    taken = {pair for chosen in IN_SUITE for pair in combinations(chosen.items(), 2)}
    assert taken == {pair for chosen in ALL for pair in combinations(chosen.items(), 2)}
    assert len(IN_SUITE) < len(ALL) / 5


@pytest.mark.parametrize("bodies", OPTIONS["bodies"])
def test_a_cell_narrower_than_the_tight_one_is_refused(bodies):
    """The tight cell of the matrix is as small as a cell can be."""
    box, _ = cell_of(bodies, "tight")
    species = OPTIONS["bodies"][bodies].semi_axes
    assert all(accepted(axes, box) for axes in species)
    narrower = box * np.array([1, 1, 1 - 2 * (TIGHT - 1)])
    assert not all(accepted(axes, narrower) for axes in species)
