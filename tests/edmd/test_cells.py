"""The cells in which bodies are found: by brute force over all images, for sizes far apart and cells of any skew."""

import fluids
import numpy as np
import pytest

import edmd
from edmd import building, state

SKEWED = np.array([[1.0, 0.0, 0.0], [0.5, 0.9, 0.0], [-0.4, 0.3, 0.8]])


def listed(world):
    """(body, partner, image) of every entry of every list."""
    found = set()
    for body, (begin, count) in enumerate(world.lists.spans[:-1, :2]):
        for entry in range(begin, begin + count):
            found.add((body, int(world.lists.links[entry, state.PARTNER]),
                       tuple(world.lists.images[entry, state.IMAGE:state.IMAGE + 3].tolist())))
    return found


def spheres_within_reach(world):
    """The same for spheres by definition: anchors whose neighbourhoods overlap."""
    position, radius = world.anchors[:, state.ANCHOR_POSITION:state.ANCHOR_POSITION + 3], world.anchors[:, state.ANCHOR_RADIUS]
    found = set()
    for image in np.ndindex(5, 5, 5):
        image = np.array(image) - 2
        apart = position[None] + image @ world.grid.box - position[:, None]
        near = (apart**2).sum(axis=2) < (radius[:, None] + radius[None])**2
        found |= {(i, j, tuple(image.tolist())) for i, j in zip(*np.nonzero(near)) if i != j or image.any()}
    return found


@pytest.mark.parametrize(("counts", "radii", "levels"), [([60], [1.0], 1), ([40, 20], [1.0, 1.5], 1), ([120, 6, 2], [0.4, 1.0, 4.0], 3)])
@pytest.mark.parametrize("box", [np.eye(3), SKEWED], ids=["cubic", "skewed"])
def test_every_neighbour_is_found(counts, radii, levels, box):
    rng = np.random.default_rng(3)
    radius = np.repeat(radii, counts)
    box = box * np.cbrt(4 / 3 * np.pi * (radius**3).sum() / 0.02 / np.linalg.det(box))
    positions = spread(rng, radius, box)
    system = edmd.thermalized(edmd.System(positions, np.eye(4)[np.zeros(len(radius), int)], np.repeat(radius[:, None], 3, axis=1), box), 1)
    simulation = edmd.Simulation(system)
    assert len(simulation._world.cells.levels) == levels
    for _ in range(3):
        assert listed(simulation._world) == spheres_within_reach(simulation._world)
        simulation.run(collisions=50)


def spread(rng, radius, box):
    """Places without overlap, drawn one after another."""
    images = np.array(list(np.ndindex(3, 3, 3))) - 1
    places = np.zeros((0, 3))
    while len(places) < len(radius):
        trial, reach = rng.random(3) @ box, radius[:len(places)] + radius[len(places)]
        apart = np.linalg.norm(places[:, None] - trial + images @ box, axis=2).min(axis=1) if len(places) else np.zeros(0)
        if (apart > 1.01 * reach).all():
            places = np.vstack([places, trial])
    return places


def test_crowded_cells_get_more_room(monkeypatch):
    """Cells with room for eight bodies end with room for all, and the run is the same."""
    monkeypatch.setattr(building, "CELL_BODIES", 20.0)
    monkeypatch.setattr(building, "CELL_ROOM", 64)
    like = edmd.Simulation(fluids.fluid("prolate", 60, 0.4, seed=5)).run(collisions=300)
    monkeypatch.setattr(building, "CELL_ROOM", 8)
    simulation = edmd.Simulation(fluids.fluid("prolate", 60, 0.4, seed=5))
    room = simulation._world.cells.bodies.shape[1]
    assert room > 8
    assert simulation._world.cells.count.max() <= room
    simulation.run(collisions=300).verify()
    assert np.array_equal(simulation.system.positions, like.system.positions)


def test_a_mixture_of_sizes_one_to_ten():
    system = edmd.random_system([2, 400], [(5.0, 5.0, 6.0), (0.5, 0.5, 0.7)], 0.2, seed=2)
    simulation = edmd.Simulation(system)
    assert len(simulation._world.cells.levels) == 2
    for _ in range(3):
        simulation.run(collisions=300)
        simulation.verify()
