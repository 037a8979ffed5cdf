import MDAnalysis as mda
import numpy as np
import pytest
from runs import fcc, random_quaternions, write_run

import analysis
from ccd.culling import near_pairs

ROUND = np.array([0.5, 0.5, 0.5])
UPRIGHT = np.array([1.0, 0, 0, 0])


def frame(positions, semi_axes):
    n = len(positions)
    return positions, np.tile(UPRIGHT, (n, 1)), np.tile(semi_axes, (n, 1))


@pytest.mark.parametrize("cutoff", [0.3, 1.1, 2.95])
def test_near_pairs_are_all_pairs_of_all_images(cutoff):
    rng = np.random.default_rng(9)
    cell = np.array([[1.0, 0, 0], [0.7, 0.8, 0], [-0.4, 0.5, 1.3]])
    positions = rng.normal(size=(5, 3))
    shifts = np.stack(np.meshgrid(*[np.arange(-20, 21)] * 3, indexing="ij"), axis=-1).reshape(-1, 3) @ cell
    expected = []
    for i in range(5):
        for j in range(i + 1):
            distances = np.linalg.norm(positions[j] - positions[i] + shifts, axis=1)
            near = np.sort(distances[(distances < cutoff) & (distances > 0)])
            expected += [(j, i, d) for d in (near[::2] if i == j else near)]  # an own image stands on both sides
    first, second, separation = near_pairs(positions, cell, cutoff)
    found = zip(np.minimum(first, second), np.maximum(first, second), np.linalg.norm(separation, axis=1))
    np.testing.assert_allclose(sorted(found), sorted(expected), atol=1e-12)
    steps = np.linalg.solve(cell.T, (positions[first] + separation - positions[second]).T)
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-12)


@pytest.mark.parametrize("stretch", [(1, 1, 1), (1, 1, 2), (0.5, 1, 1), (1.25, 1, 0.8)])
@pytest.mark.parametrize("cells", [1, 2, 3])
def test_every_body_of_a_touching_fcc_crystal_has_twelve(stretch, cells):
    positions, cell = fcc(cells)
    pairs = analysis.contact_pairs(*frame(positions * stretch, ROUND * stretch), cell * stretch)
    assert pairs.dtype == np.int64
    numbers = analysis.contact_numbers(pairs, len(positions))
    assert numbers.tolist() == [12] * len(positions)
    assert not analysis.rattlers(pairs, len(positions)).any()


def test_one_body_in_the_primitive_cell_touches_its_own_images():
    primitive = np.sqrt(0.5) * np.array([[0, 1, 1], [1, 0, 1], [1, 1, 0.0]])
    pairs = analysis.contact_pairs(*frame(np.zeros((1, 3)), ROUND), primitive)
    assert pairs.tolist() == [[0, 0]] * 6
    assert analysis.contact_numbers(pairs, 1).tolist() == [12]


def test_the_gap_is_a_factor_of_growth():
    positions, cell = fcc(2)
    assert len(analysis.contact_pairs(*frame(positions * 1.002, ROUND), cell * 1.002, gap=1.9e-3)) == 0
    assert len(analysis.contact_pairs(*frame(positions * 1.002, ROUND), cell * 1.002, gap=2.1e-3)) == 6 * 32
    overlapping = analysis.contact_pairs(*frame(positions * 0.99, ROUND), cell * 0.99)
    assert len(overlapping) == 6 * 32


def test_a_turned_pair_touches_where_supports_say():
    # two needles end to end along (1, 1, 0), and side by side
    turn = np.array([np.cos(np.pi / 8), 0, 0, np.sin(np.pi / 8)])
    along, across = np.array([1, 1, 0]) / np.sqrt(2), np.array([1, -1, 0]) / np.sqrt(2)
    axes = np.tile([2.0, 0.25, 0.25], (2, 1))
    for direction, distance in ((along, 4.0), (across, 0.5)):
        for factor, count in ((0.9995, 1), (1.0005, 1), (1.0015, 0)):
            positions = np.array([[5.0, 5, 5], [5, 5, 5] + direction * distance * factor])
            assert len(analysis.contact_pairs(positions, np.tile(turn, (2, 1)), axes, 12 * np.eye(3))) == count


def test_contacts_do_not_depend_on_where_the_cell_is_cut():
    rng = np.random.default_rng(6)
    cell = np.array([[3.0, 0, 0], [1.2, 2.9, 0], [-0.7, 0.9, 3.1]])
    positions, q = rng.random((14, 3)) @ cell, random_quaternions(rng, 14)
    axes = rng.uniform(0.3, 0.9, (14, 3))
    numbers = analysis.contact_numbers(analysis.contact_pairs(positions, q, axes, cell), 14)
    moved = np.linalg.solve(cell.T, (positions + [0.4, 1.3, -2.2]).T).T % 1 @ cell
    np.testing.assert_array_equal(analysis.contact_numbers(analysis.contact_pairs(moved, q, axes, cell), 14), numbers)
    doubled = np.concatenate([positions, positions + cell[2]])
    pairs = analysis.contact_pairs(doubled, np.tile(q, (2, 1)), np.tile(axes, (2, 1)), cell * [[1], [1], [2]])
    np.testing.assert_array_equal(analysis.contact_numbers(pairs, 28), np.tile(numbers, 2))
    assert numbers.sum() > 0


def test_a_loose_body_in_a_cage_is_the_only_rattler():
    positions, cell = fcc(3)
    axes = np.tile(ROUND, (len(positions), 1))
    axes[17] *= 0.9
    pairs = analysis.contact_pairs(positions, np.tile(UPRIGHT, (len(positions), 1)), axes, cell)
    loose = analysis.rattlers(pairs, len(positions))
    assert np.flatnonzero(loose).tolist() == [17]
    assert analysis.contact_numbers(pairs, len(positions)).sum() == 12 * 108 - 24


def test_taking_one_away_frees_the_next():
    complete = [(i, j) for i in range(5) for j in range(i)]  # five bodies that hold each other, four contacts each
    tail = [(4, 5), (3, 5), (2, 5), (5, 6), (6, 7)]  # 5 has four contacts until 6 is gone, and 6 two until 7 is
    assert np.flatnonzero(analysis.rattlers(complete + tail, 8)).tolist() == [5, 6, 7]
    assert analysis.rattlers(complete[1:], 5).all()
    assert analysis.rattlers(np.empty((0, 2), dtype=np.int64), 3).tolist() == [True] * 3


def test_along_a_trajectory(tmp_path):
    positions, cell = fcc(3)
    axes = np.tile(ROUND, (2, len(positions), 1))
    axes[0] *= 0.99
    axes[1, 17] *= 0.9
    path = write_run(tmp_path / "run.h5md", positions, UPRIGHT, axes, cell, [0, 1])
    results = analysis.ContactNumbers(mda.Universe(path).atoms).run().results
    assert results.rattlers.tolist() == [108, 1]
    assert np.isnan(results.mean[0])
    assert results.mean[1] == pytest.approx((12 * 108 - 24) / 107, abs=1e-12)
    assert results.contact_numbers.shape == (2, 108)
    assert results.contact_numbers[1, 17] == 0
    assert not results.held[0].any()
    assert np.flatnonzero(~results.held[1]).tolist() == [17]


def test_in_full_precision(tmp_path):
    """A gap of 1e-9 is far below the float32 of `atoms.positions`."""
    positions, cell = fcc(2)
    path = write_run(tmp_path / "run.h5md", positions, UPRIGHT, ROUND, cell, [0])
    atoms = mda.Universe(path).atoms
    assert analysis.ContactNumbers(atoms, gap=1e-9).run().results.mean.tolist() == [12.0]


# near contacts

def simple_cubic(distance, cells=4):
    return distance * np.stack(np.meshgrid(*[np.arange(cells)] * 3, indexing="ij"), axis=-1).reshape(-1, 3), distance * cells * np.eye(3)


def test_gaps_of_a_crystal_are_those_of_its_shells():
    positions, cell = simple_cubic(1.03)
    found = analysis.gaps(*frame(positions, ROUND), cell, largest=0.5)
    np.testing.assert_allclose(found, [0.03] * 3 * 64 + [1.03 * np.sqrt(2) - 1] * 6 * 64, atol=1e-12)
    overlapping = analysis.gaps(*frame(positions, 1.1 * ROUND), cell, largest=0.01)
    np.testing.assert_allclose(overlapping, [1.03 / 1.1 - 1] * 3 * 64, atol=1e-12)


def test_neighbours_within_a_gap_along_a_trajectory(tmp_path):
    """A stretched crystal: its gaps are those of the spheres. Two frames: the second a little denser."""
    positions, cell = simple_cubic(1.01)
    stretch = np.array([1, 1, 2.0])
    axes = np.array([1, 1.005])[:, None, None] * np.tile(ROUND * stretch, (64, 1))
    path = write_run(tmp_path / "run.h5md", positions * stretch, UPRIGHT, axes, cell * stretch, [0, 1])
    results = analysis.NearContacts(mda.Universe(path).atoms, smallest=1.1e-3, largest=1.0, bins=300).run().results
    shells = {np.sqrt(1): 6, np.sqrt(2): 12, np.sqrt(3): 8}
    expected = sum(number * (results.gap > 1.01 * shell / scale - 1) / 2 for shell, number in shells.items() for scale in (1, 1.005))
    np.testing.assert_allclose(results.contacts, expected, atol=1e-12)
    assert np.sum(results.density * np.diff(results.gap)) == pytest.approx(26, abs=1e-9)


def test_spheres_at_random_have_gaps_as_the_volume(tmp_path):
    """Centres of an ideal gas: neighbours with mu < m fill a sphere of radius m, overlaps included."""
    rng = np.random.default_rng(3)
    n, frames, side = 200, 20, 8.0
    path = write_run(tmp_path / "run.h5md", side * rng.random((frames, n, 3)), UPRIGHT, ROUND, side * np.eye(3), np.arange(frames))
    results = analysis.NearContacts(mda.Universe(path).atoms, smallest=0.01, largest=1.0, bins=20).run().results
    expected = (n - 1) / side**3 * 4 / 3 * np.pi * (1 + results.gap)**3
    pairs = expected * n * frames / 2
    assert np.all(np.abs(results.contacts / expected - 1) < 4 / np.sqrt(pairs))
    with pytest.raises(ValueError, match="smallest, largest"):
        analysis.NearContacts(mda.Universe(path).atoms, smallest=0.1, largest=0.01)


@pytest.mark.parametrize(("name", "value"), [("positions", np.zeros((4, 2))), ("orientations", np.ones((3, 4))),
                                             ("semi_axes", np.zeros((4, 3))), ("cell", np.zeros((3, 3))), ("gap", 0.0)])
def test_what_is_not_a_frame_is_refused(name, value):
    arguments = dict(zip(("positions", "orientations", "semi_axes"), frame(fcc(1)[0], ROUND)), cell=fcc(1)[1], gap=1e-3)
    with pytest.raises(ValueError, match=name):
        analysis.contact_pairs(**arguments | {name: value})
