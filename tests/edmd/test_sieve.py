"""The sieve of the cells: it lets every neighbour through, whatever the shapes, sizes and places, and few others."""

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

import edmd
from edmd import building, sieve, state
from edmd.rules.kinds import chosen_rule

SHAPES = {"spheres": [1, 1, 1], "needles": [1, 1, 100], "long": [1, 1, 10], "plates": [100, 100, 1], "three axes": [1, 3, 10],
          "leaf": [0.1, 5, 6]}


def kinds_of(semi_axes):
    """Rows of the table of kinds, as a world has them."""
    n, apart = len(semi_axes), 4 * semi_axes.max()
    system = edmd.System(np.arange(n)[:, None] * [apart, 0, 0], np.eye(4)[np.zeros(n, int)], semi_axes, np.eye(3) * n * apart)
    world = building.build_world(edmd.thermalized(system), chosen_rule(1.0, None))
    return world.kinds[world.bodies[:, state.KIND].astype(int)]


def anchor_of(kind, rotation, size):
    anchor = np.zeros(state.ANCHOR_ROW)
    vectors = size * kind[state.SEMI_AXES:state.SEMI_AXES + 3, None] * rotation.as_matrix().T
    anchor[state.ANCHOR_VECTORS:state.ANCHOR_VECTORS + 9] = vectors.ravel()
    anchor[state.ANCHOR_SIZE], anchor[state.ANCHOR_MARGIN] = size, size * kind[state.MARGIN_LENGTH]
    return anchor


def sifted(kinds, rotations, size, places, unit):
    """Whether the sieve lets bodies at these places (k, 3) through; the first kind and rotation are those of the body at the origin."""
    own, *others = [(kind, anchor_of(kind, rotation, size)) for kind, rotation in zip(kinds, rotations)]
    blocks = np.zeros((1, state.BLOCK_ROW), dtype=np.float32)
    blocks[:, :state.LANES] = state.NOBODY
    for slot, (place, (kind, anchor)) in enumerate(zip(places, others)):
        sieve.keep(blocks, slot, tuple(place * unit), sieve.hull(anchor, kind, unit))
    lengths = unit * (abs(places).sum(axis=1).max() + 2 * size * kinds[:, state.LARGEST].max())
    near = sieve.sift(blocks[0], (0.0, 0.0, 0.0), sieve.hull(own[1], own[0], unit), lengths)
    through = blocks[0, state.PLACE_GAP:state.PLACE_GAP + state.LANES] <= 0
    assert not through[len(others):].any(), "an empty slot"
    assert near or not through.any()
    return through[:len(others)]


def close_places(rng, axes, margins):
    """Places for bodies about one at the origin, from contact to further than three times the margins. axes: (k, 3, 3), columns."""
    direction = rng.normal(size=(len(axes) - 1, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    inside = sum(1 / np.linalg.norm(np.linalg.inv(a) @ direction[..., None], axis=1)[:, 0] for a in (axes[:1], axes[1:]))
    beside = sum(np.linalg.norm(direction[:, None] @ a, axis=2)[:, 0] for a in (axes[:1], axes[1:]))
    return direction * (inside + rng.random(len(direction)) * (beside - inside) + rng.uniform(0, 3, len(direction)) * margins)[:, None]


def gap_of(n, a, b, r):
    """Of the plane of this direction, of any length: a distance that the bodies certainly have."""
    return (n @ r - np.linalg.norm(n @ a) - np.linalg.norm(n @ b)) / np.linalg.norm(n)


def surely_apart(a, b, r, wanted):
    """The gap of the best of a few of the pencil's planes, or if that is not what is wanted, of the best of all near it."""
    planes = [np.linalg.solve((1 - share) * (a @ a.T) + share * (b @ b.T), r) for share in np.linspace(0.05, 0.95, 10)]
    best = max(planes, key=lambda n: gap_of(n, a, b, r))
    gap = gap_of(best, a, b, r)
    if gap >= wanted:
        return gap
    return -minimize(lambda n: -gap_of(n, a, b, r), best / np.linalg.norm(best), method="Nelder-Mead", tol=1e-9 * np.linalg.norm(r)).fun


@pytest.mark.parametrize("one", SHAPES)
def test_every_neighbour_is_let_through(one):
    """A body is kept back only where a plane, in numpy, tells that it is further than the margins; and most of those are."""
    rng = np.random.default_rng(list(SHAPES).index(one))
    for other in SHAPES:
        far = kept_back = 0
        for length, size, smaller in ((1.0, 1.0, 1.0), (1.0, 1e-2, 1.0), (1e-6, 0.7, 1e-3), (1e6, 0.9, 1e3)):
            kinds = kinds_of(length * np.array([SHAPES[one]] + state.LANES * [np.multiply(SHAPES[other], smaller)]))
            for _ in range(3):
                rotations = Rotation.random(1 + state.LANES, random_state=rng)
                axes = size * rotations.as_matrix() * kinds[:, None, state.SEMI_AXES:state.SEMI_AXES + 3]
                margins = size * (kinds[0, state.MARGIN_LENGTH] + kinds[1:, state.MARGIN_LENGTH])
                places = close_places(rng, axes, margins)
                through = sifted(kinds, rotations, size, places, 1 / kinds[1, state.LARGEST])
                gaps = np.array([surely_apart(axes[0], *pair) for pair in zip(axes[1:], places, np.where(through, 0.0, margins))])
                assert (gaps[~through] >= margins[~through]).all(), other
                far, kept_back = far + (gaps > 1.3 * margins).sum(), kept_back + (~through[gaps > 1.3 * margins]).sum()
        assert far > 0, other
        assert one != other or kept_back > 0.5 * far


def test_the_hull_holds_the_body():
    """By its squared support values in many directions; of a body of revolution it is the body."""
    rng = np.random.default_rng(1)
    semi_axes = np.vstack([np.exp(rng.uniform(-3, 3, (30, 3))), [[1, 1, 4], [4, 1, 1], [1, 4, 1], [4, 4, 1], [2, 2, 2]]])
    n = rng.normal(size=(500, 3))
    for axes, kind in zip(semi_axes, kinds_of(semi_axes)):
        hull = np.full(3, kind[state.HULL_ACROSS])
        hull[int(kind[state.HULL])] = kind[state.HULL_ALONG]
        excess = n**2 @ hull - n**2 @ axes**2
        assert (excess >= -1e-13 * (n**2 @ hull)).all()
        if len(set(axes)) < 3:
            assert abs(excess).max() <= 1e-12 * hull.max() * 20
