"""Whether two bodies are neighbours: whether the gap between their anchors is below the sum of their margins (docs/theory.md, section 4).

Cheap planes settle the far, in columns of a scratch array so that the arithmetic becomes vector instructions: the plane across the line of
centres, and that of two bodies in the ratio of their margins. The pencil decides what is left.
"""

from math import sqrt

from ccd.compiling import kernel
from ccd.separation import best_plane, normal, shape_matrix, support
from ccd.tolerances import COARSE
from ccd.vectors import dot, load, norm, scale, subtract
from edmd.flight import load_vectors
from edmd.pairs import direction_of, imaged, is_sphere
from edmd.state import ANCHOR_MARGIN, ANCHOR_POSITION, ANCHOR_RADIUS, ANCHOR_VECTORS, PARTNER
from edmd.tolerances import SURELY_NEAR

BLOCK, WIDTH = 32, 8                    # bodies looked into at once, and a multiple of the lanes of a vector instruction
APART, VECTORS, MARGIN, GAP, DIRECTION, COLUMNS = (BLOCK * column for column in (0, 3, 12, 13, 14, 17))


@kernel
def beyond(r, anchor, other, ball):
    """Whether a body, r away, is too far to be a neighbour even if it filled its bounding sphere. ball: the body of the anchor is one."""
    square, within = dot(r, r), anchor[ANCHOR_RADIUS] + other[ANCHOR_RADIUS]
    if ball or square >= within * within:
        return square >= within * within
    return square - support(load_vectors(anchor, ANCHOR_VECTORS), r) >= (other[ANCHOR_RADIUS] + anchor[ANCHOR_MARGIN]) * sqrt(square)


@kernel
def put(column, k, r, anchor):
    """Put a body, r away, among those to be looked into."""
    _set_three(column, APART + k, r)
    for i in range(9):
        column[VECTORS + i * BLOCK + k] = anchor[ANCHOR_VECTORS + i]
    column[MARGIN + k] = anchor[ANCHOR_MARGIN]


@kernel
def part(column, count, anchor):
    """The best of the cheap planes, and its gap, between the body of this anchor and each of those put."""
    s_a, own, x_a = load_vectors(anchor, ANCHOR_VECTORS), anchor[ANCHOR_MARGIN], shape_matrix(load_vectors(anchor, ANCHOR_VECTORS))
    for k in range((count + WIDTH - 1) // WIDTH * WIDTH):
        r, s_b = _three(column, APART + k), _shape(column, k)
        across = scale(1.0 / norm(r), r)
        n = normal(x_a, shape_matrix(s_b), r, own / (own + column[MARGIN + k]))
        gap_across, gap = plane_gap(across, r, s_a, s_b), plane_gap(n, r, s_a, s_b)
        better = gap_across > gap
        column[GAP + k] = gap_across if better else gap
        _set_three(column, DIRECTION + k, (across[0] if better else n[0], across[1] if better else n[1], across[2] if better else n[2]))


@kernel
def near(column, k, anchor, balls):
    """Whether a body that was put is a neighbour, and the plane that tells; balls: whether both are, which every plane tells."""
    margins, n = anchor[ANCHOR_MARGIN] + column[MARGIN + k], _three(column, DIRECTION + k)
    if balls or column[GAP + k] >= margins:
        return column[GAP + k] < margins, n
    return _by_pencil(_three(column, APART + k), load_vectors(anchor, ANCHOR_VECTORS), _shape(column, k), n, margins)


@kernel
def still_near(world, body, entry):
    """Whether two neighbours are neighbours still: their last plane settles the very near."""
    a, b = world.anchors[body], world.anchors[world.lists.links[entry, PARTNER]]
    r = imaged(world, entry, subtract(load(b, ANCHOR_POSITION), load(a, ANCHOR_POSITION)))
    if is_sphere(world, body) and is_sphere(world, int(world.lists.links[entry, PARTNER])):
        within = a[ANCHOR_RADIUS] + b[ANCHOR_RADIUS]
        return dot(r, r) < within * within
    margins, n = a[ANCHOR_MARGIN] + b[ANCHOR_MARGIN], direction_of(world.lists, entry)
    s_a, s_b = load_vectors(a, ANCHOR_VECTORS), load_vectors(b, ANCHOR_VECTORS)
    if plane_gap(n, r, s_a, s_b) < SURELY_NEAR * margins:
        return True
    listed, _ = _by_pencil(r, s_a, s_b, n, margins)
    return listed


@kernel
def _by_pencil(r, s_a, s_b, n, margins):
    h_a, h_b = support(s_a, n), support(s_b, n)
    n, _, _ = best_plane(s_a, s_b, r, h_a / (h_a + h_b), COARSE)
    return plane_gap(n, r, s_a, s_b) < margins, n


@kernel
def plane_gap(n, r, s_a, s_b):
    return dot(n, r) - support(s_a, n) - support(s_b, n)


@kernel
def _set_three(column, start, v):
    column[start], column[start + BLOCK], column[start + 2 * BLOCK] = v


@kernel
def _three(column, start):
    return column[start], column[start + BLOCK], column[start + 2 * BLOCK]


@kernel
def _shape(column, k):
    return _three(column, VECTORS + k), _three(column, VECTORS + 3 * BLOCK + k), _three(column, VECTORS + 6 * BLOCK + k)
