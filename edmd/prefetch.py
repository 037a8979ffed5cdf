"""Memory asked for before it is needed. In a system larger than the caches a collision waits for memory longer than it computes, and what
it will need is known early: by the lists, and by the calendar, which has the next event at hand. In any system an event asks at its begin
for what it will read. A hint changes no result.
"""

from math import inf

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, overload

from ccd.compiling import kernel
from edmd.calendar import WAYS, earliest_but, whose
from edmd.state import AWAITED, BEGIN, BLOCK_ROW, COUNT, TWIN

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
def fetch_surroundings(world, body):
    """The anchor and the list of a body, whose span is at hand."""
    fetch_anchor(world.anchors, body)
    _fetch_list(world.lists, body)


@kernel
def _fetch_list(lists, body):
    begin = int(lists.spans[body, BEGIN])
    for entry in range(begin, begin + int(lists.spans[body, COUNT])):
        fetch(lists.numbers[entry], 0)


@kernel
def fetch_pair(world, entry, body, partner):
    """What a look at a pair takes."""
    fetch(world.lists.numbers[world.lists.links[entry, TWIN]], 0)
    fetch_body(world, partner)
    fetch_body(world, body)


@kernel
def fetch_collision(world, body, partner, ahead):
    """What a collision takes besides. ahead: in a system that does not fit into the caches."""
    fetch_surroundings(world, partner)
    if ahead:
        _fetch_place(world.calendar, partner)
        begin = int(world.lists.spans[body, BEGIN])
        for entry in range(begin, begin + int(world.lists.spans[body, COUNT])):
            fetch(world.lists.numbers[world.lists.links[entry, TWIN]], 0)


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
            time, rival = earliest_but(times, rounds[k] + match * WAYS, won % WAYS)
            earlier = time < earliest
            earliest, place = time if earlier else earliest, rounds[k] + match * WAYS + rival if earlier else place
        won = match
    return whose(calendar, place)


@kernel
def fetch_next(world, body):
    """What the first steps of the event after this body's take. -> whose event that is, most likely"""
    calendar = world.calendar
    body = likely_next(calendar, body)
    fetch(world.lists.spans[body], 0)
    fetch_body(world, body)
    _fetch_place(calendar, body)
    return body


@kernel
def _fetch_place(calendar, body):
    """Where the calendar has the event of a body, and what is decided there."""
    place = body
    for k in range(len(calendar.rounds) - 1):
        fetch(calendar.time, calendar.rounds[k] + place)
        place //= WAYS
        fetch(calendar.body, calendar.rounds[k + 1] + place)


@kernel
def fetch_event(world, body):
    """What its event takes besides, once `fetch_next` has brought the span that tells: its list, and whom it awaits or its own anchor."""
    awaited = int(world.lists.spans[body, AWAITED])
    if awaited != body:
        fetch(world.lists.spans[awaited], 0)
        fetch_body(world, awaited)
    else:
        fetch_anchor(world.anchors, body)
    _fetch_list(world.lists, body)
