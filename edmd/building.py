"""From a System to a World and back: the checked builder. Kernels only ever see what is made here."""

from typing import NamedTuple

import numpy as np

from ccd.precession import NO_AXIS, symmetry_axes
from edmd import prediction, state
from edmd.calendar import WAYS
from edmd.epoch import energy_counted, forget_lists, kinetic_energy, make_lists, mean_velocity, reschedule_all
from edmd.events import Ended, EventKind
from edmd.flight import advance_all, set_shapes, turn_still
from edmd.inertia import angular_momenta, motions, rotational_degrees
from edmd.neighbors import DONE, copy_entries
from edmd.rules.kinds import CONTACT_SHARE, KIND, LEAST_CONTACT_TIME, ROUGH, rule_row
from edmd.state import Calendar, Cells, Contacts, Grid, Lists, World
from edmd.system import wrap
from edmd.tolerances import (
    CELL_BODIES,
    CELL_ROOM,
    DRIFTED,
    EPOCH_COLLISIONS,
    EPOCH_LEAST,
    EPOCH_LOOKS,
    LIST_ROOM,
    MARGIN,
    MARGIN_OF_SPHERES,
    NARROWEST,
    REFINE_BELOW,
    SPARE,
    SPARE_ROOM,
)


def build_world(system, rule):
    """A World at time 0 with lists and predictions made. The bodies must not overlap (the caller has checked)."""
    n = system.n
    row = rule_row(rule)
    contacts = Contacts(row, np.full(n if row[LEAST_CONTACT_TIME] > 0 or row[CONTACT_SHARE] > 0 else 0, -np.inf))
    kinds, kind = _kind_rows(system, row[KIND] == ROUGH)
    kinds[:, state.LEVEL] = _levels(kinds)
    bodies, turns = _body_rows(system, kinds, kind)
    longest = kinds[:, state.LARGEST] + kinds[:, state.MARGIN_LENGTH]
    _check_cell(system, longest.max())
    clock = np.zeros(state.CLOCK_ROW)
    clock[state.SIZE] = 1.0
    clock[state.ROUNDING] = np.finfo(float).eps * np.abs(system.box).sum()
    tally = np.zeros(state.TALLY_ROW, dtype=np.int64)
    tally[state.NEXT_EPOCH] = max(EPOCH_COLLISIONS * n, EPOCH_LEAST)
    tally[state.ENOUGH] = EPOCH_LOOKS * tally[state.NEXT_EPOCH]
    world = World(bodies, kinds, np.zeros((n, 3), dtype=np.int32), turns, _aligned(n, state.ANCHOR_ROW), _lists(np.full(n, LIST_ROOM)),
                  _grid(system), _cells(system, kinds, kind), _calendar(n), clock, tally, contacts,
                  np.ones(prediction.COLUMNS), np.zeros(state.WATCHED_ROOM, dtype=np.int32))
    set_pace(world, system.velocities)
    clock[state.ENERGY] = kinetic_energy(world)
    mass, drift = mean_velocity(world)
    if 0.5 * mass * np.dot(drift, drift) > DRIFTED * clock[state.ENERGY]:           # or it is rounding
        clock[state.DRIFT:state.DRIFT + 3] = drift
    energy_counted(world)
    forget_lists(world)
    world, status = with_room(world, make_lists, room=2 * LIST_ROOM)
    if status != DONE:
        raise ValueError(cell_too_small(system.box))
    world = _packed(world)
    reschedule_all(world)
    return world


def set_pace(world, velocities):
    """How far ahead bounds look, and when planes are renewed, before any collision has told the mean free time. velocities: (n, 3)."""
    clock, speed = world.clock, np.sqrt((velocities**2).sum(axis=1).mean())
    margins = world.kinds[world.bodies[:, state.KIND].astype(int), state.MARGIN_LENGTH]
    clock[state.HORIZON] = margins.mean() / speed if speed > 0 else 1e300
    clock[state.REFINE] = REFINE_BELOW * clock[state.HORIZON] if speed > 0 else 0.0


def with_room(world, action, *arguments, room=0):
    """Run a kernel that may need longer lists; it is asked again with more room as often as it says so. -> world, status.

    room: for so many entries at least, in every list.
    """
    status = action(world, *arguments)
    while status == Ended.NO_ROOM:
        world = _packed(_with_roomy_cells(world), room)
        status = action(world, *arguments)
    return world, status


class Synchronised(NamedTuple):
    """Bodies at one time: positions (n, 3) inside the cell, velocities (n, 3), orientations (n, 4), angular momenta (n, 3); but for a spin
    about an axis of revolution, which the world leaves out."""

    positions: np.ndarray
    velocities: np.ndarray
    orientations: np.ndarray
    momenta: np.ndarray


def synchronised_rows(world, order):
    """The bodies of now in some order (n,), as copies, and the images (n, 3) of their positions. The world is not touched."""
    rows, now = world.bodies[order], world.clock[state.NOW]
    advance_all(rows, world.turns[order], world.kinds, now)
    turn_still(rows, world.kinds, world.clock[state.EPOCH] + now)
    positions, outside = wrap(rows[:, state.POSITION:state.POSITION + 3], world.grid.box)
    return Synchronised(positions, rows[:, state.VELOCITY:state.VELOCITY + 3], rows[:, state.ORIENTATION:state.ORIENTATION + 4],
                        rows[:, state.MOMENTUM:state.MOMENTUM + 3]), world.image[order] + outside


def flattened(world, prefix=""):
    """Pairs of a dotted name and an array, for every array of the world."""
    for name, value in zip(world._fields, world):
        if isinstance(value, tuple):
            yield from flattened(value, f"{prefix}{name}.")
        elif name not in ("escapes", "directions", "links", "images"):         # the same memory as spans or numbers
            yield prefix + name, value


def unflattened(arrays):
    """The World of `flattened` arrays."""
    parts = {"grid": Grid, "cells": Cells, "calendar": Calendar, "contacts": Contacts}
    fields = {name: kind(*(np.ascontiguousarray(arrays[f"{name}.{field}"]) for field in kind._fields)) for name, kind in parts.items()}
    for name in ("bodies", "turns", "anchors"):
        fields[name] = _aligned_copy(arrays[name])
    spans = _aligned_copy(np.ascontiguousarray(arrays["lists.spans"]).view(np.float64)).view(np.int32)
    lists = _views(spans, _aligned_copy(arrays["lists.numbers"]))
    return World(lists=lists, **{name: arrays[name] for name in ("kinds", "image", "clock", "tally", "columns", "watched")}, **fields)


def cell_too_small(box):
    return (f"box = {np.asarray(box).tolist()}: the cell is too small, a body comes near its own periodic image; expected a cell at least "
            "as wide as the longest body and its list margin (use more bodies)")


def _check_cell(system, longest):
    inverse = np.linalg.inv(system.box)
    heights = 1 / np.sqrt((inverse**2).sum(axis=0))
    if heights.min() < 2 * longest:
        raise ValueError(f"{cell_too_small(system.box)}: its smallest width is {heights.min():.6g}, and {2 * longest:.6g} is needed")


def _kind_rows(system, rough):
    """The table of kinds, and the kind (n,) of each body."""
    distinct, kind = np.unique(np.column_stack([system.semi_axes, system.masses, system.moments]), axis=0, return_inverse=True)
    semi_axes, moments = distinct[:, :3], distinct[:, 4:]
    motion = motions(semi_axes, moments, rough)
    smallest, largest, axis = semi_axes.min(axis=1), semi_axes.max(axis=1), symmetry_axes(semi_axes)
    rows = np.zeros((len(distinct), state.KIND_ROW))
    rows[:, state.SEMI_AXES:state.SEMI_AXES + 3] = semi_axes
    rows[:, state.INVERSE_MASS] = 1 / distinct[:, 3]
    rows[:, state.INVERSE_MOMENTS:state.INVERSE_MOMENTS + 3] = 1 / moments
    rows[:, state.AXIS] = axis
    rows[:, state.MOTION] = motion
    rows[:, state.DEGREES] = rotational_degrees(semi_axes, moments, rough)
    rows[:, state.ACROSS] = np.where(motion == state.STEADY, 1 / moments[np.arange(len(distinct)), (np.minimum(axis, 2) + 1) % 3], 0.0)
    rows[:, state.FREE_MOMENTS:state.FREE_MOMENTS + 3] = np.where(motion[:, None] == state.FREE, 1 / moments, 0.0)
    counted = (axis[:, None] == np.arange(3)) + 0.5 * (axis[:, None] == NO_AXIS)
    rows[:, state.STRAYING:state.STRAYING + 3] = counted / semi_axes**2
    rows[:, state.UNEQUAL] = (abs(np.roll(moments, 1, axis=1) - np.roll(moments, 2, axis=1)) / moments).max(axis=1)
    rows[:, state.SPREAD] = largest - smallest
    rows[:, state.LARGEST] = largest
    rows[:, state.BENDING] = (largest**2 - smallest**2) / smallest
    pole = np.array([0, 1, 2, state.GENERAL, 0])[axis]
    rows[:, state.POLE] = np.where(motion == state.FREE, state.GENERAL, pole)
    rows[:, state.ALONG_SQUARE] = semi_axes[np.arange(len(distinct)), pole]**2
    rows[:, state.ACROSS_SQUARE] = semi_axes[np.arange(len(distinct)), pole - 1]**2
    small, middle, large = np.sort(semi_axes, axis=1).T
    long = middle * middle * large <= large * large * small              # of the hulls about the longest and the shortest axis
    rows[:, state.HULL] = np.where(long, semi_axes.argmax(axis=1), semi_axes.argmin(axis=1))
    rows[:, state.HULL_ACROSS], rows[:, state.HULL_ALONG] = np.where(long, middle, large)**2, np.where(long, large, small)**2
    rows[:, state.MARGIN_LENGTH] = margin_lengths(semi_axes)
    return rows, kind.ravel()


def margin_lengths(semi_axes):
    """The margins (n,) of the neighbourhoods of bodies with these semi-axes (n, 3)."""
    shape = semi_axes.min(axis=1) / semi_axes.max(axis=1)
    return (MARGIN + (MARGIN_OF_SPHERES - MARGIN) * shape * shape) * _cube_root(semi_axes.prod(axis=1))


def _cube_root(x):
    """Of arrays; exactly twice as large for eight times as much, which np.cbrt is not on every processor."""
    fraction, exponent = np.frexp(x)
    return np.ldexp(np.cbrt(np.ldexp(fraction, exponent % 3)), exponent // 3)


def _body_rows(system, kinds, kind):
    rows = _aligned(system.n, state.BODY_ROW)
    rows[:, state.POSITION:state.POSITION + 3] = system.positions
    rows[:, state.VELOCITY:state.VELOCITY + 3] = system.velocities
    rows[:, state.KIND] = kind
    rows[:, state.MOMENTUM:state.MOMENTUM + 3] = angular_momenta(system)
    rows[:, state.ORIENTATION:state.ORIENTATION + 4] = system.orientations
    turns = _aligned(system.n, state.TURN_ROW_OF_TOPS if (kinds[:, state.MOTION] == state.FREE).any() else state.TURN_ROW)
    turns[:, state.MET_TIME] = -np.inf
    set_shapes(rows, turns, kinds)
    return rows, turns


def _lists(room):
    """Empty lists with room (n,) for so many entries."""
    spans = _aligned(len(room) + 1, state.SPAN_ROW // 2).view(np.int32)
    spans[1:, state.BEGIN] = np.cumsum(room)
    spans[:, state.SLOT] = EventKind.ESCAPE
    return _views(spans, _aligned(int(room.sum()) + SPARE, state.ENTRY_ROW))


def _views(spans, numbers):
    return Lists(spans, spans.view(np.float64), numbers, numbers.view(np.float32), numbers.view(np.int32), numbers.view(np.int8))


def _calendar(n):
    sizes = [_whole_matches(n)]
    while sizes[-1] > 1:
        sizes.append(1 if sizes[-1] == WAYS else _whole_matches(sizes[-1] // WAYS))
    room = [_whole_matches(size) for size in sizes]
    rounds = np.array([sum(room[k + 1:]) for k in range(len(sizes))])
    time, body = _aligned(sum(room) // WAYS, WAYS).ravel(), np.zeros(rounds[0], dtype=np.int32)
    time[:] = np.inf
    for k, (first, size) in enumerate(zip(rounds[1:], sizes[1:])):
        body[first:first + size] = np.arange(size) * WAYS**(k + 1)
    return Calendar(time, body, rounds)


def _whole_matches(n):
    return -(-n // WAYS) * WAYS


def _grid(system):
    inverse = np.linalg.inv(system.box)
    heights = 1 / np.sqrt((inverse**2).sum(axis=0))
    normals = inverse * heights
    return Grid(system.box.copy(), inverse, np.append(heights, 1 / np.linalg.eigvalsh(normals.T @ normals).max()))


def _levels(kinds):
    """The level of size (kinds,) of each kind: the radii of its neighbourhoods within a level differ by a factor of two at most."""
    radius = kinds[:, state.LARGEST] + kinds[:, state.MARGIN_LENGTH]
    return np.unique(np.floor(np.log2(radius / radius.min())), return_inverse=True)[1].ravel()


def _cells(system, kinds, kind):
    """Empty grids, one for each level."""
    level = kinds[:, state.LEVEL].astype(int)
    heights = _grid(system).heights[:3]
    levels, reaches, cells = np.zeros((level.max() + 1, state.LEVEL_ROW), dtype=np.int64), np.zeros((level.max() + 1, 2)), 0
    for k in range(len(levels)):
        reaches[k, 0] = (kinds[level == k, state.LARGEST] + kinds[level == k, state.MARGIN_LENGTH]).max()
        width = max(NARROWEST * reaches[k, 0], np.cbrt(CELL_BODIES * system.volume / max((level[kind] == k).sum(), 1)))
        levels[k, :3] = np.maximum(np.floor(heights / width), 1)
        levels[k, state.FIRST_CELL] = cells
        cells += levels[k, :3].prod()
        reaches[k, 1] = np.abs(system.box / levels[k, :3, None]).sum() / reaches[k, 0]
    return _empty_cells(levels, reaches, cells, system.n, CELL_ROOM)


def _empty_cells(levels, reaches, cells, n, room):
    blocks = -(-room // state.LANES)
    room = blocks * state.LANES
    places = _aligned(cells * blocks, state.BLOCK_ROW // 2).view(np.float32).reshape(cells, blocks, state.BLOCK_ROW)
    places[:, :, state.PLACE_POSITION:state.PLACE_POSITION + state.LANES] = state.NOBODY
    return Cells(levels, reaches, places, np.zeros((cells, room), dtype=np.int32), np.zeros(cells, dtype=np.int32),
                 np.full((n, 2), -1, dtype=np.int32), np.zeros(state.HITS + room, dtype=np.int64))


def _with_roomy_cells(world):
    """The same world with more room in every cell of its grids, if one of them is full."""
    old = world.cells
    cells, room = old.bodies.shape
    if (old.count < room).all():
        return world
    new = _empty_cells(old.levels, old.reaches, cells, len(old.where), room + room // 3)
    new.places[:, :old.places.shape[1]], new.bodies[:, :room], new.count[:], new.where[:] = old.places, old.bodies, old.count, old.where
    return world._replace(cells=new)


def _packed(world, room=0):
    """The same world with its lists in order, each with a little more room than it has entries, or with this room if that is more."""
    old = world.lists
    lists = _lists(np.maximum(old.spans[:-1, state.COUNT] + SPARE_ROOM, room))
    for column in (state.COUNT, state.AWAITED, state.SLOT, state.MET_PARTNER, state.MET_IMAGE):
        lists.spans[:, column] = old.spans[:, column]
    lists.escapes[:, state.ESCAPE_TIME] = old.escapes[:, state.ESCAPE_TIME]
    copy_entries(old, lists, np.empty(len(old.numbers), dtype=np.int32))
    return world._replace(lists=lists)


def _aligned(rows, columns):
    """Zeros whose rows begin on cache lines (of 64 bytes)."""
    store = np.zeros(rows * columns + 8)
    start = -store.ctypes.data % 64 // 8
    return store[start:start + rows * columns].reshape(rows, columns)


def _aligned_copy(array):
    copy = _aligned(*array.shape)
    copy[:] = array
    return copy
