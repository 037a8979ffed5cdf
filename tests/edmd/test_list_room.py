"""Room for one more neighbour: a full list takes a place from the next that has one, and every list still says the same."""

import numpy as np
import pytest

import edmd
from edmd import state
from edmd.building import _packed
from edmd.neighbors import _has_room
from edmd.tolerances import FULL_IN_A_ROW, SPARE
from edmd.verify import _check_links

N = 2 * FULL_IN_A_ROW


@pytest.fixture
def full(monkeypatch):
    """A world in which no list has room."""
    world = edmd.Simulation(edmd.random_system(N, (1, 1.25, 1.5625), 0.45, seed=1)).run(collisions_per_particle=10)._world
    monkeypatch.setattr(edmd.building, "SPARE_ROOM", 0)
    return _packed(world)


def told(world):
    """Of every body its neighbours, with all that its list tells of them but where it stands, and the pair that it waits for."""
    lists, said = world.lists, []
    for begin, count, _, slot, *met in lists.spans[:-1, :6].tolist():
        rows = lists.links[begin:begin + count].copy()
        waits = rows[slot, :state.TWIN].tolist() if slot >= 0 else None
        twins = [int(np.flatnonzero(lists.spans[:-1, state.BEGIN] <= twin)[-1]) for twin in rows[:, state.TWIN]]
        said.append((sorted(row[:state.TWIN].tolist() for row in rows), sorted(twins), waits, met))
    return said


@pytest.mark.parametrize("compiled", [True, False])
@pytest.mark.parametrize(("body", "giver"), [(20, 21), (20, 27), (20, 20 + FULL_IN_A_ROW), (0, 1), (N - 2, N - 1), (N - 1, N), (N - 5, N)])
def test_the_next_list_with_room_gives_a_place(full, body, giver, compiled):
    lists, before = full.lists, told(full)
    if giver < N:                                                   # a place beyond its last entry
        lists.spans[giver + 1:, state.BEGIN] += 1
        lists.numbers[lists.spans[giver, state.BEGIN] + lists.spans[giver, state.COUNT] + 1:] = (
            lists.numbers[lists.spans[giver, state.BEGIN] + lists.spans[giver, state.COUNT]:-1].copy())
        moved = lists.links[:lists.spans[-1, state.BEGIN], state.TWIN]
        moved[moved >= lists.spans[giver, state.BEGIN] + lists.spans[giver, state.COUNT]] += 1
    assert told(full) == before
    has_room = _has_room if compiled else _has_room.py_func
    assert has_room(lists, body)
    spare = np.diff(lists.spans[:, state.BEGIN]) - lists.spans[:-1, state.COUNT]
    assert spare[body] == spare.sum() == 1
    assert told(full) == before
    _check_links(full)
    ends = lists.spans[:, state.BEGIN].copy()
    assert has_room(lists, body)                                   # it has: nothing moves
    np.testing.assert_array_equal(lists.spans[:, state.BEGIN], ends)


def test_too_many_full_lists_in_a_row_are_left_alone(full):
    before = full.lists.numbers.copy()
    assert not _has_room(full.lists, 20)
    np.testing.assert_array_equal(full.lists.numbers, before)


def test_the_last_list_takes_what_is_behind_it_until_that_is_gone(full):
    lists, taken = full.lists, 0
    while _has_room(lists, N - 1):
        lists.spans[N - 1, state.COUNT] += 1                    # as if it were full again
        taken += 1
    assert taken == SPARE
