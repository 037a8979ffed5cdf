"""Every invariant holds from any start: shapes nearly round or long, few bodies, cells that are skew, wide or hardly wide enough."""

from contextlib import suppress

import numpy as np
import pytest

import edmd

RULES = [edmd.Elastic()] * 4 + [edmd.Inelastic(0.9), edmd.Inelastic(0.7, contact_share=1e-3), edmd.Rough(0.9, 0.5)]


def any_shape(rng):
    kind = rng.integers(4)
    if kind == 0:
        shape = np.ones(3)
    elif kind == 1:
        shape = 1 + 10 ** rng.uniform(-8, -1) * rng.uniform(-1, 1, 3)
    elif kind == 2:
        shape = np.array([1, 1, 10 ** rng.uniform(-1, 1)])
    else:
        shape = 10 ** rng.uniform(-0.5, 0.5, 3)
    return shape * 10 ** rng.uniform(-0.2, 0.2)


def any_start(rng):
    """A system on a skew lattice of two or three sites each way, some of them empty, in which no two bodies can overlap."""
    along, species = int(rng.integers(2, 4)), int(rng.integers(1, 4))
    n = along**3 - int(rng.integers(0, 4))
    axes = np.array([any_shape(rng) for _ in range(species)])[rng.integers(0, species, n)]
    skew = np.eye(3) + np.tril(rng.uniform(-0.5, 0.5, (3, 3)), -1) * (rng.random() < 0.5)
    box = skew * 2 * axes.max() * along * 10 ** rng.uniform(0.005, 0.35)
    sites = np.stack(np.meshgrid(*[np.arange(along)] * 3), axis=-1).reshape(-1, 3)[rng.permutation(along**3)[:n]]
    masses = 10 ** rng.uniform(-1, 1, n) if rng.random() < 0.3 else np.ones(n)
    orientations = rng.normal(size=(n, 4))
    velocities, spins = rng.normal(size=(n, 3)), rng.normal(size=(n, 3)) * 10 ** rng.uniform(-4, 1) * (rng.random() < 0.7)
    velocities[1:] *= rng.random() < 0.9
    velocities -= masses @ velocities / masses.sum()
    return edmd.System((sites + 0.5) / along @ box, orientations / np.linalg.norm(orientations, axis=1)[:, None], axes, box, velocities,
                       spins, masses=masses, inertia=["solid", "sphere"][rng.integers(2)])


@pytest.mark.parametrize("seed", [*range(40), *(pytest.param(seed, marks=pytest.mark.validate) for seed in range(40, 800))])
def test_any_start(seed, tmp_path):
    rng = np.random.default_rng(seed)
    simulation = edmd.Simulation(any_start(rng), rule=RULES[rng.integers(len(RULES))])
    simulation.stall_path = tmp_path / "stalled.npz"
    with suppress(edmd.Stalled):                            # which a gas that collapses is
        for _ in range(6):
            simulation.run(collisions=int(rng.integers(1, 40)))
            simulation.verify()
    assert simulation.collisions > 0
