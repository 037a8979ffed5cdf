"""The engine's collisions, pair by pair, against a plain twin that samples time (tests/oracles/twin.py).

Chaos parts any two runs, so the twin starts again from the engine's state every few collisions: they agree when both see the same pairs at
the same times, and the same velocities at the end.
"""

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from twin import Twin, disagreement

import edmd

STRETCH = 10                                # collisions from one start of the twin to the next
COLLISIONS = 20                             # of each shape
MANY, SEEDS = 2000, range(1, 6)             # behind the marker `validate`: so many from each of several starts
# counts, semi-axes, masses of the species, packing fraction; the cells are about as small as the lists allow
SHAPES = {
    "spheres": ((16,), [(1, 1, 1)], (1,), 0.45),
    "1:1:2": ((16,), [(1, 1, 2)], (1,), 0.45),
    "1:1:0.5": ((16,), [(1, 1, 0.5)], (1,), 0.45),
    "needles 10:1:1": ((40,), [(10, 1, 1)], (1,), 0.15),
    "plates 1:1:0.1": ((20,), [(1, 1, 0.1)], (1,), 0.15),
    "5:5:1": ((20,), [(5, 5, 1)], (1,), 0.35),
    "1:1.25:1.5625": ((16,), [(1, 1.25, 1.5625)], (1,), 0.5),
    "3:2:1": ((16,), [(3, 2, 1)], (1,), 0.45),
    "mixture": ((8, 6, 6), [(1, 1, 1), (0.6, 0.6, 1.8), (1.5, 1.5, 0.5)], (1, 0.1, 20), 0.4),
    "size ratio 10": ((4, 40), [(2, 2, 3), (0.2, 0.3, 0.2)], (1, 0.02), 0.3),
}


def started(shape, seed):
    counts, semi_axes, masses, packing_fraction = SHAPES[shape]
    masses = np.repeat(np.array(masses, dtype=float), counts)
    simulation = edmd.Simulation(edmd.random_system(counts, semi_axes, packing_fraction, seed=seed, masses=masses))
    return simulation.run(collisions_per_particle=20)


def stretch(simulation, collisions=STRETCH):
    """The next collisions as (time from now, i, j), with the state before and after: who has a new velocity has collided."""
    began, states, record = simulation.time, [simulation.system], []
    for _ in range(collisions):
        states.append(simulation.run(collisions=1).system)
        changed = np.flatnonzero((states[-1].velocities != states[-2].velocities).any(axis=1))
        assert len(changed) == 2, f"a collision changes two bodies, not {changed}"
        record.append((simulation.time - began, *changed.tolist()))
    assert all(a <= b for (a, *_), (b, *_) in pairwise(record))
    return states[0], record, states[-1]


@pytest.mark.parametrize(("seed", "collisions"), [
    (0, COLLISIONS), *(pytest.param(seed, MANY, marks=pytest.mark.validate) for seed in SEEDS)])
@pytest.mark.parametrize("shape", SHAPES)
def test_the_twin_finds_the_same_collisions(shape, seed, collisions):
    simulation = started(shape, seed)
    until = simulation.collisions + collisions
    while simulation.collisions < until:
        before = simulation.collisions
        problem = disagreement(*stretch(simulation))
        assert problem is None, f"after {before} collisions: {problem}"


@pytest.fixture(scope="module")
def recorded():
    return stretch(started("1:1:2", seed=0))


class Blind(Twin):
    """A twin that lets a pair of bodies pass through each other."""

    unseen = ()

    def _first_contacts(self, i, j, shift, until):
        return [contact for contact in super()._first_contacts(i, j, shift, until) if {*contact[1:3]} != {*self.unseen}]


@pytest.mark.parametrize("number", range(0, STRETCH, 3))
def test_a_missed_collision_is_noticed(recorded, number):
    """The record of bodies of which two passed through each other, and everything that came of it."""
    start, record, _ = recorded
    blind = Blind(start)
    blind.unseen = record[number][1:]
    wrong = blind.collisions(STRETCH, 2 * record[-1][0])
    assert "missed" in disagreement(start, wrong, SimpleNamespace(velocities=blind.velocity))


@pytest.mark.parametrize("number", range(STRETCH))
def test_an_invented_collision_is_noticed(recorded, number):
    start, record, end = recorded
    time = record[number][0]
    others = {(a, b) for a in range(start.n) for b in range(a + 1, start.n)} - {(i, j) for _, i, j in record}
    invented = (time * (1 - 1e-6), *min(others))
    assert "invented" in disagreement(start, [*record[:number], invented, *record[number:]], end)


def test_a_collision_at_the_wrong_time_or_with_the_wrong_impulse_is_noticed(recorded):
    start, record, end = recorded
    for wrong in (1e-7, -1e-7):
        moved = [*record[:3], (record[3][0] + wrong * record[-1][0], *record[3][1:]), *record[4:]]
        assert disagreement(start, moved, end) is not None
    velocities = end.velocities.copy()
    velocities[record[-1][1]] *= 1 + 1e-5
    assert "velocities" in disagreement(start, record, SimpleNamespace(velocities=velocities))
