"""Memory asked for before it is needed. In a system larger than the caches a collision waits for memory longer than it computes, and what
it will need is known early: by the lists, and by the calendar, which has the next event at hand. In any system an event asks at its begin
for what it will read. A hint changes no result.
"""

from math import inf

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, overload

from ccd.compiling import kernel
from edmd.calendar import WAYS, whose
from edmd.state import BEGIN, BLOCK_ROW, COUNT, PARTNER, SLOT

LINE = 8                    # float64 of a cache line
READ, KEEP, DATA = 0, 3, 1  # what llvm.prefetch takes: to be read, into the nearest cache, no code


def fetch(row, k):
    """Ask for the cache line of row[k], of an array of one dimension. In plain Python nothing."""


@overload(fetch)
def _fetch(row, k):
    def asked(row, k):
        _ask(row, k)
    return asked


@intrinsic
def _ask(_, row, k):
    def generate(context, builder, signature, arguments):
        place = builder.gep(context.make_array(signature.args[0])(context, builder, arguments[0]).data, [arguments[1]])
        pointer, number = ir.IntType(8).as_pointer(), ir.IntType(32)
        prefetch = builder.module.declare_intrinsic("llvm.prefetch", [pointer],
                                                    ir.FunctionType(ir.VoidType(), [pointer, number, number, number]))
        builder.call(prefetch, [builder.bitcast(place, pointer), number(READ), number(KEEP), number(DATA)])
        return context.get_dummy_value()
    return types.void(row, types.intp), generate


@kernel
def fetch_body(world, body):
    """What a look at a body takes."""
    row, turn = world.bodies[body], world.turns[body]
    for k in range(0, len(row), LINE):
        fetch(row, k)
    for k in range(0, len(turn), LINE):
        fetch(turn, k)


@kernel
def fetch_anchor(anchors, body):
    anchor = anchors[body]
    for k in range(0, len(anchor), LINE):
        fetch(anchor, k)


@kernel
def fetch_list(lists, body):
    """The list of a body, whose span is at hand."""
    begin = int(lists.spans[body, BEGIN])
    for entry in range(begin, begin + int(lists.spans[body, COUNT])):
        fetch(lists.numbers[entry], 0)


@kernel
def fetch_surroundings(world, body):
    """The anchor and the list of a body, whose span is at hand."""
    fetch_anchor(world.anchors, body)
    fetch_list(world.lists, body)


@kernel
def fetch_cell(cells, cell):
    """What is asked of a cell, for two blocks of bodies, which most cells fill."""
    fetch(cells.count, cell)
    for block in range(min(2, cells.places.shape[1])):
        for k in range(0, BLOCK_ROW, 2 * LINE):
            fetch(cells.places[cell, block], k)
    fetch(cells.bodies[cell], 0)


@kernel
def likely_next(calendar, body):
    """Whose event is the earliest of all but this body's, as far as the last two matches that it won tell; itself, if they do not."""
    rounds, times = calendar.rounds, calendar.time
    earliest, place, won = inf, int(rounds[0]) + body, body
    for k in range(len(rounds) - 1):
        match = won // WAYS
        if k >= len(rounds) - 3:
            for rival in range(rounds[k] + match * WAYS, rounds[k] + (match + 1) * WAYS):
                earlier = times[rival] < earliest and rival != rounds[k] + won
                earliest, place = times[rival] if earlier else earliest, rival if earlier else place
        won = match
    return whose(calendar, place)


@kernel
def fetch_next(world, body):
    """What the first steps of the event after this body's take. -> whose event that is, most likely"""
    calendar = world.calendar
    place = body = likely_next(calendar, body)
    fetch(world.lists.spans[body], 0)
    fetch_body(world, body)
    for k in range(len(calendar.rounds) - 1):
        fetch(calendar.time, calendar.rounds[k] + place)
        place //= WAYS
        fetch(calendar.body, calendar.rounds[k + 1] + place)
    return body


@kernel
def fetch_pair(world, body):
    """What its event takes besides, once `fetch_next` and `fetch_list` have brought what tells: the partner, or its own anchor."""
    lists, slot = world.lists, int(world.lists.spans[body, SLOT])
    if 0 <= slot < lists.spans[body, COUNT]:
        partner = int(lists.links[int(lists.spans[body, BEGIN]) + slot, PARTNER])
        fetch(lists.spans[partner], 0)
        fetch_body(world, partner)
    else:
        fetch_anchor(world.anchors, body)
