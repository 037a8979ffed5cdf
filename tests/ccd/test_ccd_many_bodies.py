"""Which of many bodies can touch, and which do, in periodic cells of any shape: against all pairs of all images."""

import numpy as np
import pytest
import reference

from ccd.contacts import contact_functions, contact_numbers, contact_pairs, mean_contact_number, rattlers
from ccd.culling import close_pairs, near_pairs

CELLS = {
    "cube": 2.0 * np.eye(3),
    "slab": np.diag([3.0, 2.0, 0.5]),
    "sheared": np.array([[2.0, 0, 0], [1.4, 1.5, 0], [-0.9, 0.8, 1.8]]),
    "very skew": np.array([[1.0, 0, 0], [1.7, 1.0, 0], [-1.2, 2.1, 1.2]]),
    "left-handed and turned": np.array([[0.3, 1.9, 0.2], [1.7, -0.1, 0.4], [0.2, 0.3, 2.1]]),
}


def all_images(positions, cell, reach):
    """Every (first, second, separation) closer than reach (i, j) -> length, each pair of images once, by brute force."""
    inside = positions @ np.linalg.inv(cell) % 1.0 @ cell
    bodies = range(len(positions))
    longest = max(reach(i, j) for i in bodies for j in bodies)
    # a shift by s cells moves a body by s times the distance between two opposite faces, at least; two more make up for any place inside
    furthest = np.ceil(longest * np.linalg.norm(np.linalg.inv(cell), axis=0)).astype(int) + 2
    shifts = np.stack(np.meshgrid(*(np.arange(-s, s + 1) for s in furthest), indexing="ij"), axis=-1).reshape(-1, 3)
    forward = np.array([tuple(s) > (0, 0, 0) for s in shifts])
    found = []
    for i in bodies:
        for j in bodies[i:]:
            separations = inside[j] - inside[i] + shifts @ cell
            near = np.linalg.norm(separations, axis=1) <= reach(i, j)
            if i == j:
                near &= forward
            found += [(i, j, s) for s in separations[near]]
    return found


def listed(pairs):
    """In an order and orientation of its own: from the smaller index, own images with the first component that is not 0 positive."""
    rows = []
    for i, j, s in pairs:
        s = np.round(s, 9) + 0.0
        if i > j or (i == j and tuple(s) < (0, 0, 0)):
            i, j, s = j, i, -s + 0.0
        rows.append((int(i), int(j), *s.tolist()))
    return sorted(rows)


@pytest.mark.parametrize("cutoff", [0.4, 1.3, 3.1])
@pytest.mark.parametrize("shape", CELLS)
def test_near_pairs_are_all_pairs_of_all_images_once(shape, cutoff):
    positions = 5 * np.random.default_rng(1).normal(size=(7, 3))
    found = listed(zip(*near_pairs(positions, CELLS[shape], cutoff)))
    assert found == listed(all_images(positions, CELLS[shape], lambda i, j: cutoff))
    assert len(found) > 5 or cutoff < 1


@pytest.mark.parametrize("shape", CELLS)
def test_close_pairs_are_those_of_touching_bounding_spheres(shape):
    rng = np.random.default_rng(2)
    positions, radii = 5 * rng.normal(size=(7, 3)), rng.uniform(0.1, 0.9, 7)
    found = listed(zip(*close_pairs(positions, radii, CELLS[shape], gap=0.2)))
    assert found == listed(all_images(positions, CELLS[shape], lambda i, j: radii[i] + radii[j] + 0.2))


@pytest.mark.parametrize("shape", CELLS)
def test_contact_functions_are_those_of_the_reference(shape):
    rng = np.random.default_rng(3)
    positions, q, axes = 5 * rng.normal(size=(5, 3)), rng.normal(size=(5, 4)), rng.uniform(0.2, 0.7, (5, 3))
    first, second, f = contact_functions(positions, q, axes, CELLS[shape], gap=0.1)
    matrices = [reference.shape_matrix(a, reference.quat_to_R(o)) for a, o in zip(axes, q)]
    expected = all_images(positions, CELLS[shape], lambda i, j: (axes[i].max() + axes[j].max()) * 1.1)
    assert len(first) == len(expected)
    values = {}
    for i, j, s in expected:
        values.setdefault((i, j), []).append(reference.pw(matrices[i], matrices[j], s)[0])
    found = {}
    for i, j, value in zip(np.minimum(first, second), np.maximum(first, second), f):
        found.setdefault((int(i), int(j)), []).append(value)
    assert found.keys() == values.keys()
    for pair in found:
        np.testing.assert_allclose(sorted(found[pair]), sorted(values[pair]), rtol=1e-11)


def test_the_densest_crystal_of_ellipsoids_has_fourteen_contacts_a_body():
    """SM2 (Donev et al. 2004), rebuilt by the reference from its symmetry: two orientations, in-plane ratio sqrt 3."""
    cell, shape_a, shape_b, tau, _ = reference.sm2_crystal()
    np.testing.assert_allclose([np.diag(shape_a), np.diag(shape_b)], [[3, 1, 1], [1, 3, 1]], rtol=1e-14)
    axes = np.tile([np.sqrt(3), 1, 1], (2, 1))
    q = np.array([[1, 0, 0, 0], [np.sqrt(0.5), 0, 0, np.sqrt(0.5)]])
    pairs = contact_pairs(np.array([np.zeros(3), tau]), q, axes, cell.T, gap=1e-9)
    assert contact_numbers(pairs, 2).tolist() == [14, 14]
    assert not rattlers(pairs, 2).any()
    assert mean_contact_number(pairs, 2) == 14


def test_rattlers_go_one_after_the_other():
    """A complete graph of five holds; a sixth body on three of them, and a seventh that leans on the sixth, do not."""
    five = [(i, j) for i in range(5) for j in range(i)]
    pairs = np.array([*five, (5, 0), (5, 1), (5, 2), (5, 6), (6, 3), (6, 4), (6, 0)])
    assert rattlers(pairs, 7).tolist() == [False] * 7                   # the two hold each other
    assert rattlers(pairs[:-1], 7).tolist() == [False] * 5 + [True] * 2     # one contact fewer, and both are loose
    assert mean_contact_number(pairs[:-1], 7) == 4
    assert rattlers(np.empty((0, 2), dtype=int), 3).all()
    assert np.isnan(mean_contact_number(np.empty((0, 2), dtype=int), 3))
