"""Whether two bodies are neighbours: whether the gap of their anchors is below the sum of their margins (docs/theory.md, section 4)."""

from ccd.compiling import kernel
from ccd.separation import best_plane, support
from ccd.tolerances import COARSE
from ccd.vectors import dot, load, norm, scale, subtract
from edmd.flight import load_vectors
from edmd.pairs import direction_of, imaged, is_sphere
from edmd.state import ANCHOR_MARGIN, ANCHOR_POSITION, ANCHOR_RADIUS, ANCHOR_VECTORS, PARTNER
from edmd.tolerances import SURELY_NEAR


@kernel
def near(r, a, b, balls):
    """Whether bodies with these anchors, r apart, are neighbours, and the plane that tells; balls: whether both are."""
    if balls:
        return _balls_near(r, a, b), scale(1.0 / norm(r), r)
    return _by_pencil(r, a, b, a[ANCHOR_MARGIN] / (a[ANCHOR_MARGIN] + b[ANCHOR_MARGIN]))


@kernel
def still_near(world, body, entry):
    """Whether two neighbours are neighbours still: their last plane settles the very near.

    It tells nothing of two bodies that have long passed each other, which it may keep apart for ever. They must be let go, since another
    image of one may come near the other.
    """
    a, b = world.anchors[body], world.anchors[world.lists.links[entry, PARTNER]]
    r = imaged(world, entry, subtract(load(b, ANCHOR_POSITION), load(a, ANCHOR_POSITION)))
    if not _balls_near(r, a, b):
        return False
    if is_sphere(world, body) and is_sphere(world, int(world.lists.links[entry, PARTNER])):
        return True
    n = direction_of(world.lists, entry)
    h_a, h_b = support(load_vectors(a, ANCHOR_VECTORS), n), support(load_vectors(b, ANCHOR_VECTORS), n)
    if dot(n, r) - h_a - h_b < SURELY_NEAR * (a[ANCHOR_MARGIN] + b[ANCHOR_MARGIN]):
        return True
    listed, _ = _by_pencil(r, a, b, h_a / (h_a + h_b))
    return listed


@kernel
def _balls_near(r, a, b):
    """Whether the spheres about two neighbourhoods overlap."""
    within = a[ANCHOR_RADIUS] + b[ANCHOR_RADIUS]
    return dot(r, r) < within * within


@kernel
def _by_pencil(r, a, b, start):
    s_a, s_b = load_vectors(a, ANCHOR_VECTORS), load_vectors(b, ANCHOR_VECTORS)
    n, _, _ = best_plane(s_a, s_b, r, start, COARSE)
    return dot(n, r) - support(s_a, n) - support(s_b, n) < a[ANCHOR_MARGIN] + b[ANCHOR_MARGIN], n
