"""Rules and touching pairs that the tests of collision rules share."""

import numpy as np

import edmd

RULES = {"elastic": edmd.Elastic(), "inelastic": edmd.Inelastic(0.8), "plastic": edmd.Inelastic(0.0),
         "viscoelastic": edmd.Viscoelastic(0.3), "power law": edmd.PowerLaw(0.6, velocity=1.5), "rough": edmd.Rough(0.9, 0.4),
         "sticking": edmd.Rough(0.7, 0.0), "perfectly rough": edmd.Rough(1.0, 1.0), "slippery": edmd.Rough(0.8, -1.0)}
PAIRS = {"spheres": ((1, 1, 1.0), (0.5, 0.5, 0.5)), "prolate and oblate": ((0.6, 0.6, 1.8), (1.2, 0.5, 1.2)),
         "triaxial and sphere": ((1.3, 1.0, 0.7), (0.8, 0.8, 0.8)), "needle and plate": ((2.0, 0.25, 0.25), (1.5, 1.5, 0.2)),
         "triaxial": ((1.3, 1.0, 0.7), (0.9, 0.7, 1.4))}
EDGE = 40.0


def about_to_collide(axes, seed):
    """Two spinning bodies of unequal masses that meet soon, near the middle of a large cell."""
    rng = np.random.default_rng(seed)
    towards = rng.normal(size=3)
    towards *= 4.5 / np.linalg.norm(towards)
    centre = np.full(3, EDGE / 2)
    return edmd.System([centre - towards / 2, centre + towards / 2 + rng.uniform(-0.15, 0.15, 3)], rng.normal(size=(2, 4)), axes, EDGE,
                       [towards / 3 + rng.normal(scale=0.1, size=3), -towards / 4], rng.normal(size=(2, 3)), masses=[1.0, 2.7])


def line(positions, velocities, rule, radius=0.5, edge=60.0):
    """Spheres on a line in a long box, under a rule."""
    n = len(positions)
    at = np.column_stack([np.add(positions, 10.0), np.full((n, 2), edge / 2)])
    moving = np.column_stack([velocities, np.zeros((n, 2))])
    return edmd.Simulation(edmd.System(at, [[1, 0, 0, 0]] * n, (radius, radius, radius), edge, moving), rule=rule)
