"""From a System to a World and back: the checked builder. Kernels only ever see what is made here."""

from typing import NamedTuple

import numpy as np

from edmd import state
from edmd.epoch import energy_counted, kinetic_energy, mean_velocity, rebuild_all, reschedule_all
from edmd.events import Ended
from edmd.flight import advance_all, set_vectors
from edmd.inertia import rotational_degrees, shape_turning
from edmd.neighbors import DONE
from edmd.rules.kinds import KIND, ROUGH, rule_row
from edmd.spin import own_spins
from edmd.state import Calendar, Contacts, Grid, Lists, Pairs, World
from edmd.system import wrap
from edmd.tolerances import CELL_FRACTION, DRIFTED, EPOCH_COLLISIONS, EPOCH_LEAST, LIST_ROOM, MARGIN, REFINE_BELOW


def build_world(system, rule):
    """A World at time 0 with lists and predictions made. The bodies must not overlap (the caller has checked)."""
    n = system.n
    contacts = Contacts(rule_row(rule), np.full(n, -np.inf), 1 / system.moments, np.zeros(n))
    bodies = _body_rows(system, contacts.rule[KIND] == ROUGH)
    longest = bodies[:, state.LARGEST] + bodies[:, state.MARGIN_LENGTH]
    _check_cell(system, longest.max())
    clock = np.zeros(state.CLOCK_ROW)
    clock[state.SIZE] = 1.0
    clock[state.HORIZON] = 1e300
    clock[state.REACH] = longest.max()
    speed = np.sqrt((system.velocities**2).sum(axis=1).mean())
    clock[state.REFINE] = REFINE_BELOW * bodies[:, state.MARGIN_LENGTH].mean() / speed if speed > 0 else 0.0
    tally = np.zeros(state.TALLY_ROW, dtype=np.int64)
    tally[state.NEXT_EPOCH] = max(EPOCH_COLLISIONS * n, EPOCH_LEAST)
    world = World(bodies, np.zeros((n, 3), dtype=np.int32), _aligned(n, state.ANCHOR_ROW), _lists(n, LIST_ROOM),
                  _pairs(n * LIST_ROOM // 2), _grid(system, 2 * longest.max()), _calendar(n), clock, tally, contacts)
    world.tally[state.FREE_PAIRS] = len(world.pairs.free)
    clock[state.ENERGY] = kinetic_energy(world)
    mass, drift = mean_velocity(world)
    if 0.5 * mass * np.dot(drift, drift) > DRIFTED * clock[state.ENERGY]:           # or it is rounding
        clock[state.DRIFT:state.DRIFT + 3] = drift
    energy_counted(world)
    world, status = with_room(world, rebuild_all)
    if status != DONE:
        raise ValueError(cell_too_small(system.box))
    reschedule_all(world)
    return world


def with_room(world, action, *arguments):
    """Run a kernel that may need longer lists; it is asked again with more room as often as it says so. -> world, status."""
    status = action(world, *arguments)
    while status == Ended.LIST_FULL:
        world = _enlarged(world)
        status = action(world, *arguments)
    return world, status


class Synchronised(NamedTuple):
    """Bodies at one time: positions (n, 3) inside the cell, velocities (n, 3), orientations (n, 4) and turning (n, 3) of their shapes; of
    rough ones the angle (n,) about their symmetry axes by which they are ahead of their shapes, and its rate (n,)."""

    positions: np.ndarray
    velocities: np.ndarray
    orientations: np.ndarray
    turning: np.ndarray
    phase: np.ndarray
    spin: np.ndarray


def synchronised_rows(world, order):
    """The bodies of now in some order (n,), as copies, and the images (n, 3) of their positions. The world is not touched."""
    rows, now, spin = world.bodies[order], world.clock[state.NOW], np.zeros(len(order))
    advance_all(rows, now)
    if world.contacts.rule[KIND] == ROUGH:
        own_spins(rows, world.contacts.inverse_moments[order], spin)
    positions, outside = wrap(rows[:, state.POSITION:state.POSITION + 3], world.grid.box)
    bodies = Synchronised(positions, rows[:, state.VELOCITY:state.VELOCITY + 3], rows[:, state.ORIENTATION:state.ORIENTATION + 4],
                          rows[:, state.TURNING:state.TURNING + 3], world.contacts.phase[order] + spin * now, spin)
    return bodies, world.image[order] + outside


def flattened(world, prefix=""):
    """Pairs of a dotted name and an array, for every array of the world."""
    for name, value in zip(world._fields, world):
        if isinstance(value, tuple):
            yield from flattened(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value


def unflattened(arrays):
    """The World of `flattened` arrays."""
    parts = {"lists": Lists, "grid": Grid, "calendar": Calendar, "contacts": Contacts}
    fields = {name: kind(*(np.ascontiguousarray(arrays[f"{name}.{field}"]) for field in kind._fields)) for name, kind in parts.items()}
    for name in ("bodies", "anchors"):
        fields[name] = _aligned_copy(arrays[name])
    plane = _aligned_copy(arrays["pairs.plane"])
    fields["pairs"] = Pairs(plane, plane.view(np.int32), arrays["pairs.free"])
    return World(image=arrays["image"], clock=arrays["clock"], tally=arrays["tally"], **fields)


def cell_too_small(box):
    return (f"box = {np.asarray(box).tolist()}: the cell is too small, a body comes near its own periodic image; expected a cell at least "
            "as wide as the longest body and its list margin (use more bodies)")


def _check_cell(system, longest):
    inverse = np.linalg.inv(system.box)
    heights = 1 / np.sqrt((inverse**2).sum(axis=0))
    if heights.min() < 2 * longest:
        raise ValueError(f"{cell_too_small(system.box)}: its smallest width is {heights.min():.6g}, and {2 * longest:.6g} is needed")


def _body_rows(system, rough):
    n, semi_axes = system.n, system.semi_axes
    turning, across, _ = shape_turning(system, rough)
    rows = _aligned(n, state.BODY_ROW)
    rows[:, state.POSITION:state.POSITION + 3] = system.positions
    rows[:, state.VELOCITY:state.VELOCITY + 3] = system.velocities
    rows[:, state.TURNING:state.TURNING + 3] = turning
    rows[:, state.ORIENTATION:state.ORIENTATION + 4] = system.orientations
    rows[:, state.SEMI_AXES:state.SEMI_AXES + 3] = semi_axes
    smallest, largest = semi_axes.min(axis=1), semi_axes.max(axis=1)
    rows[:, state.BEND] = (turning**2).sum(axis=1) * (largest**2 - smallest**2) / smallest
    rows[:, state.INVERSE_MASS] = 1 / system.masses
    rows[:, state.INVERSE_INERTIA] = np.where(rough | (rotational_degrees(semi_axes) > 0), 1 / across, 0.0)
    rows[:, state.SPREAD] = largest - smallest
    rows[:, state.LARGEST] = largest
    rows[:, state.MARGIN_LENGTH] = MARGIN * np.cbrt(semi_axes.prod(axis=1))
    set_vectors(rows)
    return rows


def _lists(n, room):
    return Lists(np.zeros(n, dtype=np.int32), np.zeros((n, room), dtype=np.int32), np.zeros((n, room), dtype=np.int32),
                 np.full((n, room), np.inf))


def _pairs(rows):
    plane = _aligned(rows, state.PAIR_ROW)
    return Pairs(plane, plane.view(np.int32), np.arange(rows, dtype=np.int32)[::-1].copy())


def _calendar(n):
    leaves = 1 << max(n - 1, 1).bit_length()
    body = np.arange(2 * leaves, dtype=np.int32) - leaves
    node_bodies = np.maximum(body, 0).astype(np.int32)
    for node in range(leaves - 1, 0, -1):
        node_bodies[node] = node_bodies[2 * node]
    return Calendar(np.full(2 * leaves, np.inf), node_bodies, np.full(n, -1, dtype=np.int32))


def _grid(system, reach):
    inverse = np.linalg.inv(system.box)
    heights = 1 / np.sqrt((inverse**2).sum(axis=0))
    width = max(CELL_FRACTION * reach, (system.volume / (4 * system.n))**(1 / 3))
    shape = np.maximum(np.floor(heights / width), 1).astype(np.int64)
    normals = inverse / np.sqrt((inverse**2).sum(axis=0))
    skew = 1 / np.linalg.eigvalsh(normals.T @ normals).max()
    heights = np.append(heights, skew)
    return Grid(shape, np.full(shape.prod(), -1, dtype=np.int32), np.zeros(system.n, dtype=np.int32),
                np.full(system.n, -1, dtype=np.int32), system.box.copy(), inverse, heights)


def _enlarged(world):
    """The same world with twice the room in its lists and half as much again in its pair table."""
    n, room = world.lists.pair.shape
    lists, more = _lists(n, 2 * room), len(world.pairs.link)
    for old, new in zip(world.lists[1:], lists[1:]):
        new[:, :room] = old
    pairs = _pairs(2 * more)
    pairs.plane[:more] = world.pairs.plane
    free = world.tally[state.FREE_PAIRS]
    pairs.free[:free] = world.pairs.free[:free]
    pairs.free[free:free + more] = np.arange(2 * more - 1, more - 1, -1)
    world.tally[state.FREE_PAIRS] += more
    lists.count[:] = world.lists.count
    return world._replace(lists=lists, pairs=pairs)


def _aligned(rows, columns):
    """Zeros whose rows begin on cache lines (of 64 bytes)."""
    store = np.zeros(rows * columns + 8)
    start = -store.ctypes.data % 64 // 8
    return store[start:start + rows * columns].reshape(rows, columns)


def _aligned_copy(array):
    copy = _aligned(*array.shape)
    copy[:] = array
    return copy
