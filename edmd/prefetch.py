"""Memory asked for before it is needed. In a system larger than the caches a collision waits for memory longer than it computes, and what
it will need is known early: by the lists, and by the calendar, which has the next event at hand. A hint changes no result.
"""

from math import inf

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, overload

from ccd.compiling import kernel
from edmd.calendar import WAYS
from edmd.state import BEGIN, COUNT, PARTNER

LINE = 8                    # float64 of a cache line
READ, KEEP, DATA = 0, 3, 1  # what llvm.prefetch takes: to be read, into the nearest cache, no code


def fetch(row, k):
    """Ask for the cache line of row[k], of an array of one dimension; what is not in the array is not asked for."""


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
    row = world.bodies[body]
    for k in range(0, len(row), LINE):
        fetch(row, k)
    fetch(world.turns[body], 0)


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
def next_body(calendar, body):
    """Whose event is the earliest of all but this body's: it has lost a match that this body has won. The body itself, if none has any."""
    rounds, times, place = calendar.rounds, calendar.time, body
    earliest, winner = inf, body
    for k in range(len(rounds) - 1):
        match = place // WAYS
        first = rounds[k] + match * WAYS
        for rival in range(first, first + WAYS):
            earlier = times[rival] < earliest and rival != rounds[k] + place
            earliest, winner = times[rival] if earlier else earliest, int(calendar.body[rival]) if earlier else winner
        place = match
    return winner


@kernel
def fetch_next(world, body):
    """What the first steps of a body's event take."""
    calendar, place = world.calendar, body
    fetch_body(world, body)
    fetch_anchor(world.anchors, body)
    fetch(world.lists.spans[body], 0)
    fetch(calendar.slot, body)
    for k in range(len(calendar.rounds) - 1):
        fetch(calendar.time, calendar.rounds[k] + place)
        place //= WAYS
        fetch(calendar.body, calendar.rounds[k + 1] + place)


@kernel
def fetch_partner(world, body):
    """What the event of a body takes besides, once `fetch_next` has brought what tells."""
    lists, slot = world.lists, int(world.calendar.slot[body])
    fetch_list(lists, body)
    if 0 <= slot < lists.spans[body, COUNT]:
        partner = int(lists.links[int(lists.spans[body, BEGIN]) + slot, PARTNER])
        fetch_body(world, partner)
        fetch_anchor(world.anchors, partner)
        fetch(world.lists.spans[partner], 0)
        fetch_list(lists, partner)
