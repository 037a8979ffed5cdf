"""Starting states that many tests share: random fluids of each kind of shape, made once a session."""

from functools import lru_cache

import edmd

SHAPES = {"sphere": (1.0, 1.0, 1.0), "prolate": (1.0, 1.0, 2.0), "oblate": (1.0, 1.0, 0.5), "triaxial": (1.25, 1.0, 0.8)}


@lru_cache(maxsize=64)
def _made(semi_axes, n, packing_fraction, seed):
    return edmd.random_system(n, semi_axes, packing_fraction, seed=seed)


def fluid(semi_axes, n=32, packing_fraction=0.4, seed=1):
    """A random System at kT = 1; semi_axes: three lengths or the name of one of SHAPES."""
    return _made(tuple(SHAPES.get(semi_axes, semi_axes)), n, packing_fraction, seed).copy()
