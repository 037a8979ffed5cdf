"""Two bodies side by side, in the lanes of vector registers (ccd/lanes.py): as they are at some time for those who look at them, and
brought up to date where they are stored, for a collision.
"""

from ccd import rotation
from ccd.compiling import kernel
from ccd.free_top import is_short, top_from, turn_shortly, turning_of
from ccd.lanes import abreast, first, first_of, second, second_of, two
from ccd.revolution import turning_axis
from ccd.rotation import axes_of_any, body_axes, unit
from ccd.separation import semi_axis_vectors
from ccd.vectors import add, add_scaled, dot, load, scale
from edmd.flight import (
    Flight,
    both,
    each,
    kind_of,
    middle_square,
    set_free_turning,
    set_turning,
    store_both,
    store_pose,
    turned,
)
from edmd.state import (
    ACROSS,
    ACROSS_SQUARE,
    ALONG_SQUARE,
    BEND,
    FOURTH,
    FREE,
    FREE_MOMENTS,
    GENERAL,
    LARGEST,
    MOMENTUM,
    MOTION,
    NOW,
    ORIENTATION,
    POLE,
    POSITION,
    SEMI_AXES,
    SPREAD,
    STILL,
    THIRD,
    TIME,
    TOP,
    VECTORS,
    VELOCITY,
)


@kernel
def flights_of(world, body, partner, time):
    """Two bodies as they are at some time. They stay where they are."""
    a, b, turn_a, turn_b = world.bodies[body], world.bodies[partner], world.turns[body], world.turns[partner]
    kind_a, kind_b = world.kinds[kind_of(world, body)], world.kinds[kind_of(world, partner)]
    since, velocity, momentum = time - each(a, b, TIME), both(a, b, VELOCITY), both(a, b, MOMENTUM)
    position, spin = add_scaled(both(a, b, POSITION), since, velocity), scale(each(kind_a, kind_b, ACROSS), momentum)
    bend, fourth, none = each(turn_a, turn_b, BEND), each(turn_a, turn_b, FOURTH), two(0.0, 0.0)
    if kind_a[POLE] != GENERAL and kind_b[POLE] != GENERAL:
        pole_a, pole_b, square = int(kind_a[POLE]), int(kind_b[POLE]), dot(spin, spin)
        axis = scale(1.0 / two(kind_a[SEMI_AXES + pole_a], kind_b[SEMI_AXES + pole_b]),
                     abreast(load(a, VECTORS + 3 * pole_a), load(b, VECTORS + 3 * pole_b)))
        squares = each(kind_a, kind_b, ACROSS_SQUARE), each(kind_a, kind_b, ALONG_SQUARE), square
        return Flight(position, velocity, True, turning_axis(axis, spin, square, since), (spin, squares, none, bend, none, fourth))
    axes = axes_of_any(_turned_both((a, b), (turn_a, turn_b), (kind_a, kind_b), since))
    free_spin, acceleration = turning_of(axes, momentum, both(kind_a, kind_b, FREE_MOMENTS))
    middle = middle_square(each(kind_a, kind_b, LARGEST), each(kind_a, kind_b, SPREAD))
    third = two(turn_a[THIRD] if kind_a[MOTION] == FREE else 0.0, turn_b[THIRD] if kind_b[MOTION] == FREE else 0.0)
    return Flight(position, velocity, False, semi_axis_vectors(both(kind_a, kind_b, SEMI_AXES), axes),
                  (add(spin, free_spin), acceleration, middle, bend, third, fourth))


@kernel
def _turned_both(rows, turns, kinds, time):
    """The orientations so much later than the rows have them; of free tops not made unit.

    Any two motions take the same way: one that is not free has free moments of 0, a free one has no constant rate.
    """
    (a, b), (turn_a, turn_b), (kind_a, kind_b) = rows, turns, kinds
    q = (each(a, b, ORIENTATION),) + both(a, b, ORIENTATION + 1)
    if kind_a[MOTION] == FREE or kind_b[MOTION] == FREE:
        half, moments = 0.5 * time, both(kind_a, kind_b, FREE_MOMENTS)
        top = top_from(each(turn_a, turn_b, TOP), both(turn_a, turn_b, TOP + 1), each(turn_a, turn_b, TOP + 4),
                       each(turn_a, turn_b, TOP + 5), each(turn_a, turn_b, TOP + 6), moments)
        if not is_short(top, half):
            one, other = turned(a, turn_a, kind_a, first(time)), turned(b, turn_b, kind_b, second(time))
            return two(one[0], other[0]), two(one[1], other[1]), two(one[2], other[2]), two(one[3], other[3])
        q = turn_shortly(top, q, moments, half)
    if kind_a[MOTION] != FREE or kind_b[MOTION] != FREE:
        q = rotation.turn(q, scale(each(kind_a, kind_b, ACROSS), both(a, b, MOMENTUM)), time)
    return q


@kernel
def arrive_both(world, body, partner):
    """Move two bodies, whose momenta are about to change, to the present: what is constant in their flights is left for
    `set_turning_of_both`. -> their axes in the lab"""
    now, a, b = world.clock[NOW], world.bodies[body], world.bodies[partner]
    kind_a, kind_b = world.kinds[kind_of(world, body)], world.kinds[kind_of(world, partner)]
    since = now - each(a, b, TIME)
    position = add_scaled(both(a, b, POSITION), since, both(a, b, VELOCITY))
    q = unit(_turned_both((a, b), (world.turns[body], world.turns[partner]), (kind_a, kind_b), since))
    axes = body_axes(q)
    vectors = semi_axis_vectors(both(kind_a, kind_b, SEMI_AXES), axes)
    s, p, r = vectors
    if kind_a[MOTION] != STILL:
        store_pose(a, (first(q[0]), first(q[1]), first(q[2]), first(q[3])), (first_of(s), first_of(p), first_of(r)))
    if kind_b[MOTION] != STILL:
        store_pose(b, (second(q[0]), second(q[1]), second(q[2]), second(q[3])), (second_of(s), second_of(p), second_of(r)))
    store_both(a, b, POSITION, position)
    a[TIME] = b[TIME] = now
    return axes


@kernel
def set_turning_of_both(world, body, partner):
    """`set_turning` of two bodies that are up to date."""
    a, b, turn_a, turn_b = world.bodies[body], world.bodies[partner], world.turns[body], world.turns[partner]
    kind_a, kind_b = world.kinds[kind_of(world, body)], world.kinds[kind_of(world, partner)]
    if kind_a[MOTION] == FREE and kind_b[MOTION] == FREE:
        set_free_turning((a, b), (turn_a, turn_b), (kind_a, kind_b))
    else:
        set_turning(a, turn_a, kind_a)
        set_turning(b, turn_b, kind_b)
