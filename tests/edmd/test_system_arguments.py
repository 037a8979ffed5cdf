"""System: what is accepted, what is refused and in which words, what it tells about itself."""

import ase
import fluids
import independent
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import edmd

GOOD = {"positions": [[1, 1, 1], [5, 5, 5.0]], "orientations": [[1, 0, 0, 0]] * 2, "semi_axes": (1, 1, 2.0), "box": 10.0}


def system(**changes):
    return edmd.System(**{**GOOD, **changes})


@pytest.mark.parametrize(("name", "value"), [
    ("positions", np.zeros((0, 3))),
    ("positions", [[1, 2], [3, 4]]),
    ("positions", [1, 2, 3]),
    ("positions", [[1, 1, np.nan], [5, 5, 5]]),
    ("positions", [[1, 1, np.inf], [5, 5, 5]]),
    ("positions", "everywhere"),
    ("positions", None),
    ("orientations", [[1, 0, 0, 0]]),
    ("orientations", [[1, 0, 0], [1, 0, 0]]),
    ("orientations", [[1, 0, 0, 0], [0, 0, 0, 0]]),
    ("orientations", [[1, 0, 0, 0], [np.nan, 0, 0, 0]]),
    ("semi_axes", (1, 1)),
    ("semi_axes", (1, 1, 0)),
    ("semi_axes", (1, 1, -2)),
    ("semi_axes", (1, 1, np.nan)),
    ("semi_axes", [[1, 1, 1]] * 3),
    ("semi_axes", 1.0),
    ("box", 0.0),
    ("box", -3.0),
    ("box", (10, 10)),
    ("box", (10, 10, -10)),
    ("box", np.nan),
    ("box", [[10, 1, 0], [0, 10, 0], [0, 0, 10]]),
    ("box", [[10, 0, 0], [0, -10, 0], [0, 0, 10]]),
    ("box", np.zeros((3, 3))),
    ("box", "big"),
    ("velocities", [[1, 0, 0]]),
    ("velocities", [[np.nan, 0, 0], [0, 0, 0]]),
    ("angular_velocities", [[1, 0, 0, 0]] * 2),
    ("angular_velocities", [[np.inf, 0, 0], [0, 0, 0]]),
    ("masses", 0.0),
    ("masses", -1.0),
    ("masses", [1.0, 0.0]),
    ("masses", [1.0, 1.0, 1.0]),
    ("masses", np.nan),
    ("inertia", "hollow"),
    ("inertia", (1, 1, 0)),
    ("inertia", (1, 1)),
    ("inertia", np.nan),
    ("species", [0]),
    ("species", [0, -1]),
    ("species", [0.0, 1.0]),
    ("species", "ab"),
])
def test_bad_input_names_its_argument(name, value):
    with pytest.raises(ValueError, match=rf"^{name}\b") as refused:
        system(**{name: value})
    assert 10 < len(str(refused.value)) < 1000


def test_any_principal_moments_are_taken():
    assert system(semi_axes=(1.25, 1, 0.8), inertia=(1, 2, 3)).moments[1].tolist() == [1, 2, 3]
    assert system(semi_axes=(1.25, 1, 0.8), inertia=(2, 2, 2)).moments == pytest.approx(2)
    assert system(inertia=(2, 2, 5)).moments[0] == pytest.approx([2, 2, 5])


def test_defaults():
    s = system()
    assert s.n == 2
    assert not s.velocities.any()
    assert not s.angular_velocities.any()
    assert s.velocities is not s.angular_velocities
    assert s.masses.tolist() == [1, 1]
    assert s.species.tolist() == [0, 0]
    assert np.array_equal(s.box, 10 * np.eye(3))


@pytest.mark.parametrize("box", [10, 10.0, [10], (10, 10, 10), 10 * np.eye(3), (10 * np.eye(3)).tolist()])
def test_forms_of_the_box(box):
    assert np.array_equal(system(box=box).box, 10 * np.eye(3))


def test_semi_axes_one_for_all_one_a_body_one_a_species():
    rows = [[1, 1, 1], [0.5, 0.5, 2.0]]
    assert system(semi_axes=rows).semi_axes.tolist() == rows
    three = edmd.System(np.arange(9).reshape(3, 3) * 3.0, [[1, 0, 0, 0]] * 3, rows, 30.0, species=[1, 0, 1])
    assert three.semi_axes.tolist() == [rows[1], rows[0], rows[1]]


def test_quaternions_are_made_unit():
    s = system(orientations=[[2, 0, 0, 0], [1, 1, 1, 1]])
    assert s.orientations.tolist() == [[1, 0, 0, 0], [0.5] * 4]


@pytest.mark.parametrize("box", [10.0, (8, 9, 10), [[8, 0, 0], [3, 9, 0], [-2, 1, 10]]])
def test_packing_fraction(box):
    s = edmd.System(np.zeros((2, 3)), [[1, 0, 0, 0]] * 2, [[1, 1, 2], [0.5, 0.6, 0.7]], box)
    assert s.packing_fraction == pytest.approx(independent.packing_fraction(s), rel=1e-14)
    assert s.volume == pytest.approx(np.linalg.det(s.box), rel=1e-14)


@pytest.mark.parametrize("semi_axes", [(1, 1, 2.0), (2.0, 1, 1), (1, 0.3, 1), (1.25, 1, 0.8), (0.7, 0.7, 0.7)])
def test_moments_of_inertia(semi_axes):
    s = system(semi_axes=semi_axes, masses=[2.0, 3.0])
    assert s.moments == pytest.approx(independent.solid_moments(s.semi_axes, s.masses), rel=1e-14)
    ball = system(semi_axes=semi_axes, masses=[2.0, 3.0], inertia="sphere")
    assert ball.moments == pytest.approx(np.outer([0.8, 1.2], np.ones(3)) * np.prod(semi_axes)**(2 / 3), rel=1e-14)


def test_arrays_handed_over_are_copied():
    positions = np.array(GOOD["positions"])
    s = system(positions=positions)
    positions[:] = 7
    assert s.positions.tolist() == GOOD["positions"]


@pytest.mark.parametrize("shape", fluids.SHAPES)
def test_copy_is_exact_and_independent(shape):
    """To the last bit, after growth as well, with the moments of inertia that the dynamics uses."""
    for inertia in ("solid", (0.5, 0.5, 0.5)):
        start = fluids.fluid(shape, 32, 0.3)
        simulation = edmd.Simulation(edmd.System(start.positions, start.orientations, start.semi_axes, start.box, start.velocities,
                                                 start.angular_velocities, inertia=inertia))
        original = simulation.compress(0.2, until_packing_fraction=0.4).system
        copy = original.copy()
        assert independent.same_bits(copy, original)
        assert copy.moments == pytest.approx(original.moments, rel=1e-12)
        copy.positions[:] = 0
        assert original.positions.any()


def relative_geometry(s):
    """Contact functions of all close pairs, sorted by body: what no rotation of the whole changes."""
    i, j, f = independent.contact_functions(s, 0.2)
    order = np.lexsort((f, np.maximum(i, j), np.minimum(i, j)))
    return np.minimum(i, j)[order], np.maximum(i, j)[order], f[order]


def assert_same_geometry(a, b):
    for x, y in zip(relative_geometry(a), relative_geometry(b)):
        assert x == pytest.approx(y, abs=1e-10)


@pytest.mark.parametrize("shape", ["prolate", "triaxial"])
def test_to_ase_and_back(shape):
    s = fluids.fluid(shape, 32, 0.45)
    atoms = s.to_ase()
    assert atoms.pbc.all()
    assert atoms.arrays["orientation"] == pytest.approx(s.orientations[:, [1, 2, 3, 0]])
    assert np.array_equal(atoms.arrays["aspherical_shape"], s.semi_axes)
    assert atoms.get_velocities() == pytest.approx(s.velocities)
    assert atoms.get_masses() == pytest.approx(s.masses)
    back = edmd.from_ase(atoms, s.semi_axes)
    assert np.array_equal(back.positions, s.positions)
    assert np.array_equal(back.box, s.box)
    assert_same_geometry(back, s)


@pytest.mark.parametrize("seed", range(4))
def test_a_cell_in_any_attitude(seed):
    """Turned as a whole, with its bodies: the cell is brought into lower triangular form, and nothing relative changes."""
    rng = np.random.default_rng(seed)
    s = fluids.fluid("triaxial", 32, 0.45)
    s = edmd.System(s.positions, s.orientations, s.semi_axes, np.array([[1, 0, 0], [1, 1, 0], [0, -1, 1]]) @ s.box)
    turn = Rotation.from_quat(rng.normal(size=4))
    quaternions = (turn * Rotation.from_quat(s.orientations[:, [1, 2, 3, 0]])).as_quat()
    atoms = ase.Atoms("X32", positions=turn.apply(s.positions), cell=turn.apply(s.box), pbc=True)
    atoms.set_array("orientation", quaternions)
    for back in (edmd.from_ase(atoms, s.semi_axes), edmd.from_ase(atoms, s.semi_axes, orientations=quaternions[:, [3, 0, 1, 2]])):
        assert not np.triu(back.box, 1).any()
        assert (np.diag(back.box) > 0).all()
        assert back.packing_fraction == pytest.approx(s.packing_fraction, rel=1e-12)
        assert_same_geometry(back, s)


def test_a_left_handed_cell():
    """Three vectors of negative determinant span the same lattice; no mirror image of the bodies is made."""
    s = fluids.fluid("triaxial", 32, 0.45)
    atoms = ase.Atoms("X32", positions=s.positions, cell=s.box[[1, 0, 2]], pbc=True)
    atoms.set_array("orientation", s.orientations[:, [1, 2, 3, 0]])
    back = edmd.from_ase(atoms, s.semi_axes)
    assert back.volume == pytest.approx(s.volume)
    assert_same_geometry(back, s)


def test_from_ase_refuses_open_cells_and_wrong_orientations():
    atoms = ase.Atoms("X2", positions=GOOD["positions"], cell=[10] * 3, pbc=(True, True, False))
    with pytest.raises(ValueError, match="pbc"):
        edmd.from_ase(atoms, (1, 1, 1))
    atoms.pbc = True
    with pytest.raises(ValueError, match="orientations"):
        edmd.from_ase(atoms, (1, 1, 1), orientations=[[1, 0, 0, 0]])
    atoms.set_cell(np.zeros((3, 3)))
    with pytest.raises(ValueError, match=r"box|cell"):
        edmd.from_ase(atoms, (1, 1, 1))


def test_smallest_scale_and_contact_functions():
    s = fluids.fluid("prolate", 32, 0.45)
    assert s.smallest_scale() == pytest.approx(independent.smallest_scale(s), rel=1e-10)
    _, _, f = s.contact_functions()
    _, _, g = independent.contact_functions(s)
    assert np.sort(f) == pytest.approx(np.sort(g), rel=1e-10)
    lonely = system()
    assert lonely.smallest_scale() == np.inf or lonely.smallest_scale() > 1


@pytest.mark.parametrize("inertia", ["solid", (1.0, 1.0, 2.0)])
def test_what_is_the_same_for_all_bodies_takes_no_memory(inertia):
    """A makeup of a mixture keeps what differs, and its copies can be written to."""
    equal = system(inertia=inertia).makeup()
    names = "positions", "orientations", "semi_axes", "velocities", "angular_velocities", "masses", "moments", "species"
    assert [getattr(equal, name).strides[0] for name in names] == [0] * len(names)
    assert equal.moments == pytest.approx(system(inertia=inertia).moments, abs=0)
    assert equal.copy().masses.flags.writeable
    mixture = system(masses=[1, 2], inertia=inertia).makeup()
    assert mixture.masses.tolist() == [1, 2]
    assert mixture.semi_axes.strides[0] == 0
