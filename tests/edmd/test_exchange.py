"""Systems and runs as other programs see them, and back: extended XYZ, GSD, LAMMPS data and dump, ASE (docs/file_format.md)."""

import ase.io
import fluids
import h5py
import MDAnalysis
import numpy as np
import other_programs as other
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import edmd

READABLE = pytest.mark.parametrize("format", other.FORMATS)
EXACT = {"extxyz": other.FIELDS,
         "lammps-data": ("positions", "orientations", "semi_axes", "box", "velocities", "species"),
         "lammps-dump": ("positions", "orientations", "semi_axes", "velocities", "angular_velocities", "masses", "species"),
         "gsd": ("semi_axes", "species")}
CLOSE = {"extxyz": 0, "lammps-data": 1e-14, "lammps-dump": 1e-15, "gsd": other.SINGLE}      # relative to the largest value of its kind
TURNING = 4             # of this, times the largest over the smallest moment, are angular velocities: momenta are what is written


def back(format, system, folder):
    path = folder / f"system{other.FORMATS[format]}"
    assert edmd.export(system, path, overwrite=True) == 1
    return edmd.read_system(path)


def assert_same(copy, original, exact, close, fields=other.FIELDS):
    for name in fields:
        one, two = getattr(copy, name), getattr(original, name)
        assert one.dtype == two.dtype
        if name in exact:
            assert np.array_equal(one, two), name
        elif name == "angular_velocities":
            slender = original.moments.max(axis=1) / original.moments.min(axis=1)
            size = TURNING * slender * np.linalg.norm(two, axis=1)
            assert (np.linalg.norm(one - two, axis=1) <= close * size).all(), name
        else:
            size = np.abs(original.box).sum() if name in ("positions", "box") else np.abs(two).max()
            assert np.abs(one - two).max() <= close * size, name


def test_motion_turns_with_the_cell():
    """Atoms turned as a whole: velocities and angular velocities stay what they were as the bodies see them."""
    one = other.system(4)
    turn = Rotation.from_quat([0.1, -0.5, 0.3, 0.8])
    atoms = one.to_ase()
    atoms.set_cell(turn.apply(one.box))
    atoms.positions = turn.apply(one.positions)
    atoms.set_velocities(turn.apply(one.velocities))
    atoms.set_array("omega", turn.apply(one.angular_velocities))
    atoms.set_array("orientation", (turn * other.scipy_rotation(one)).as_quat())
    copy = edmd.from_ase(atoms)
    assert_same(copy, one, (), 1e-14, ("box", "positions", "masses", "moments"))
    for name in ("velocities", "angular_velocities"):
        seen = [other.scipy_rotation(system).inv().apply(getattr(system, name)) for system in (copy, one)]
        assert seen[0] == pytest.approx(seen[1], abs=1e-13)


def test_what_is_given_goes_before_what_the_atoms_have():
    one = other.system(4)
    copy = edmd.from_ase(one.to_ase(), (1, 1, 2), masses=2.0, species=np.ones(one.n, dtype=int))
    assert (copy.semi_axes == (1, 1, 2)).all()
    assert (copy.masses == 2).all()
    assert (copy.species == 1).all()
    assert copy.moments == pytest.approx(np.tile([2.0, 2.0, 0.8], (one.n, 1)))       # of the new shape, not of the atoms' own
    bare = one.to_ase()
    bare.set_array("aspherical_shape", None)
    with pytest.raises(ValueError, match="semi_axes = None"):
        edmd.from_ase(bare)
    bare.set_array("orientation", None)
    bare.set_array("orientation", np.ones((one.n, 3)))
    with pytest.raises(ValueError, match="orientation"):
        edmd.from_ase(bare, (1, 1, 1))


@READABLE
@settings(derandomize=True, max_examples=15, deadline=None)
@given(seed=st.integers(0, 2**32), cell=st.sampled_from(["skew", "straight"]), shapes=st.integers(1, 3), n=st.integers(1, 8))
def test_round_trip(tmp_path_factory, format, seed, cell, shapes, n):
    other.needs_format(format)
    original = other.system(seed, cell, shapes, n)
    assert_same(back(format, original, tmp_path_factory.getbasetemp()), original, EXACT[format], CLOSE[format])


@settings(derandomize=True, max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32), cell=st.sampled_from(["skew", "straight"]), shapes=st.integers(1, 3))
def test_round_trip_through_ase(seed, cell, shapes):
    """Bit for bit, positions outside the cell too; velocities, which ASE keeps as momenta, to a rounding."""
    original = other.system(seed, cell, shapes, outside=True)
    copy = edmd.from_ase(original.to_ase())
    assert_same(copy, original, set(other.FIELDS) - {"velocities"}, 3e-16)


def test_a_second_trip_through_gsd_changes_nothing_more(tmp_path):
    other.needs_format("gsd")
    once = back("gsd", other.system(3), tmp_path)
    assert_same(back("gsd", once, tmp_path), once, set(other.FIELDS) - {"orientations", "angular_velocities"}, other.SINGLE)


@READABLE
def test_bodies_outside_the_cell_are_written_inside_with_their_image(format, tmp_path):
    other.needs_format(format)
    original = other.system(5, outside=True)
    copy = back(format, original, tmp_path)
    places, images = other.in_cell(original)
    assert np.abs(copy.positions - places @ copy.box).max() < 1e-5 * original.box.max()
    path = tmp_path / f"system{other.FORMATS[format]}"
    if format == "gsd":
        import gsd.hoomd

        with gsd.hoomd.open(str(path)) as file:
            written = file[0].particles.image
    elif format == "extxyz":
        written = ase.io.read(path).arrays["map_shift"]
    else:
        start = "Atoms" if format == "lammps-data" else "ITEM: ATOMS"
        rows = path.read_text().split(start)[1].split("\n\n" if format == "lammps-data" else "\n", 1)[1].split("\n\n")[0]
        table = np.array([row.split() for row in rows.strip().splitlines()], dtype=float)
        written = table[:, 7:10] if format == "lammps-data" else table[:, 6:9]
    assert np.array_equal(written, images)


# independent readers

def test_ase_reads_extended_xyz(tmp_path):
    one = other.system(7)
    edmd.export(one, tmp_path / "one.xyz")
    atoms = ase.io.read(tmp_path / "one.xyz")
    assert np.array_equal(atoms.positions, one.positions)
    assert np.array_equal(atoms.cell[:], one.box)
    assert atoms.pbc.all()
    assert np.array_equal(atoms.arrays["orientation"], one.orientations[:, [1, 2, 3, 0]])
    assert np.array_equal(atoms.arrays["aspherical_shape"], one.semi_axes)
    assert np.array_equal(atoms.get_tags(), one.species)
    assert np.array_equal(atoms.numbers, one.species)
    assert atoms.info["time"] == 0


def test_extended_xyz_that_ase_wrote_keeps_its_eight_decimals(tmp_path):
    one = other.system(7)
    ase.io.write(tmp_path / "one.xyz", one.to_ase(), format="extxyz")
    copy = edmd.read_system(tmp_path / "one.xyz")
    for name in other.FIELDS:
        assert np.abs(getattr(copy, name) - getattr(one, name)).max() < 4e-8, name
    assert np.array_equal(copy.species, one.species)


def test_gsd_as_hoomd_defines_it(tmp_path):
    """Centred positions, (w, x, y, z), an Ellipsoid for every type, and the angular momentum quaternion: S = Im(q* P) / 2."""
    hoomd = pytest.importorskip("gsd.hoomd")
    one = other.system(8)
    edmd.export(one, tmp_path / "one.gsd")
    with hoomd.open(str(tmp_path / "one.gsd")) as file:
        frame = file[0]
    bodies = frame.particles
    assert bodies.position.dtype == bodies.orientation.dtype == np.float32
    width, depth, height, xy, xz, yz = frame.configuration.box
    cell = np.array([[width, 0, 0], [xy * depth, depth, 0], [xz * height, yz * height, height]])
    assert np.abs(cell - one.box).max() < 1e-6 * one.box.max()
    assert np.abs(bodies.position + cell.sum(axis=0) / 2 - one.positions).max() < 1e-6 * one.box.max()
    shapes = [bodies.type_shapes[k] for k in bodies.typeid]
    assert {shape["type"] for shape in shapes} == {"Ellipsoid"}
    assert np.array_equal([[shape[axis] for axis in "abc"] for shape in shapes], one.semi_axes)
    assert [int(bodies.types[k]) for k in bodies.typeid] == one.species.tolist()
    w, x, y, z = bodies.orientation.T.astype(float)
    p = bodies.angmom.astype(float)
    conjugate_times_p = np.stack([w * p[:, 1] - x * p[:, 0] - y * p[:, 3] + z * p[:, 2],
                                  w * p[:, 2] - y * p[:, 0] - z * p[:, 1] + x * p[:, 3],
                                  w * p[:, 3] - z * p[:, 0] - x * p[:, 2] + y * p[:, 1]], axis=1)
    in_body = conjugate_times_p / 2 / bodies.moment_inertia
    turning = Rotation.from_quat(np.stack([x, y, z, w], axis=1)).apply(in_body)
    assert np.abs(turning - one.angular_velocities).max() < 3e-6


def as_mdanalysis_reads(path, **more):
    options = {".dump": {"format": "LAMMPSDUMP", "topology_format": "LAMMPSDUMP"}, ".gsd": {},
               ".data": {"atom_style": "id type ellipsoidflag density x y z"}}
    return MDAnalysis.Universe(str(path), **options[path.suffix], **more)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("format", "cell"), [("lammps-data", "skew"), ("lammps-dump", "skew"), ("gsd", "straight")])
def test_mdanalysis_reads_cells_places_and_types(format, cell, seed, tmp_path):
    """Tilts of both signs. Not the cell of GSD when it is skew: MDAnalysis 2.11 takes its tilts for angles."""
    other.needs_format(format)
    one = other.system(seed, cell)
    path = tmp_path / f"one{other.FORMATS[format]}"
    edmd.export(one, path)
    universe = as_mdanalysis_reads(path)
    assert np.abs(universe.trajectory.ts.triclinic_dimensions - one.box).max() < 1e-6 * one.box.max()
    middle = one.box.sum(axis=0) / 2 if format == "gsd" else 0
    assert np.abs(universe.atoms.positions + middle - one.positions).max() < 1e-6 * one.box.max()
    assert universe.atoms.types.astype(int).tolist() == (one.species + (format != "gsd")).tolist()


def test_mdanalysis_reads_shapes_and_turning_from_a_dump(tmp_path):
    one = other.system(9)
    edmd.export(one, tmp_path / "one.dump")
    columns = {"shapex": 2 * one.semi_axes[:, 0], "shapey": 2 * one.semi_axes[:, 1], "shapez": 2 * one.semi_axes[:, 2],
               "quatw": one.orientations[:, 0], "quati": one.orientations[:, 1], "quatj": one.orientations[:, 2],
               "quatk": one.orientations[:, 3], "mass": one.masses, "omegax": one.angular_velocities[:, 0],
               "omegay": one.angular_velocities[:, 1], "omegaz": one.angular_velocities[:, 2]}
    read = as_mdanalysis_reads(tmp_path / "one.dump", additional_columns=list(columns)).trajectory.ts
    assert read.velocities == pytest.approx(one.velocities, abs=1e-6)
    for name, values in columns.items():
        assert read.data[name] == pytest.approx(values, rel=1e-6), name


@READABLE
def test_ovito_shows_ellipsoids(format, tmp_path, monkeypatch):
    """OVITO maps every column by itself: shape, orientation (x, y, z, w), cell and images."""
    monkeypatch.setenv("QT_QPA_PLATFORM", "offscreen")
    ovito = pytest.importorskip("ovito.io")
    other.needs_format(format)
    one = other.system(10, outside=True)
    path = tmp_path / f"one{other.FORMATS[format]}"
    edmd.export(one, path)
    read = ovito.import_file(str(path), **({"atom_style": "ellipsoid"} if format == "lammps-data" else {})).compute()
    bodies, cell = read.particles, np.array(read.cell[...])
    single = 2 * other.SINGLE
    assert np.abs(bodies["Aspherical Shape"][...] - one.semi_axes).max() < single * one.semi_axes.max()
    assert np.abs(bodies["Orientation"][...] - one.orientations[:, [1, 2, 3, 0]]).max() < single
    assert np.abs(cell[:, :3].T - one.box).max() < single * one.box.max()
    places, images = other.in_cell(one)
    assert np.abs(bodies.positions[...] - cell[:, 3] - places @ one.box).max() < 10 * single * one.box.max()
    assert np.array_equal(bodies["Periodic Image"][...], images)
    assert np.abs(bodies["Velocity"][...] - one.velocities).max() < 10 * single
    assert len(bodies.particle_types.types) == 3
    if format in ("extxyz", "lammps-dump"):
        assert bodies["Angular Velocity"][...] == pytest.approx(one.angular_velocities, rel=1e-15)


def test_lammps_reads_data_and_its_own_files_come_back(tmp_path):
    """The program itself: shapes, quaternions, masses, the energy of rotation; and what it then writes."""
    program = other.lammps()
    one = other.system(11, n=20)
    edmd.export(one, tmp_path / "in.data")
    columns = [f"c_all[{k}]" for k in range(1, 8)]
    names = ["quatw", "quati", "quatj", "quatk", "shapex", "shapey", "shapez"]
    program.commands_string(f"""
        units lj
        atom_style ellipsoid
        box tilt large
        read_data {tmp_path}/in.data
        compute all all property/atom {" ".join(names)}
        compute rotation all erotate/asphere
        variable rotation equal c_rotation
        pair_style zero {one.box.max() / 4}
        pair_coeff * *
        dump all all custom 1 {tmp_path}/out.dump id type mass x y z vx vy vz {" ".join(columns)}
        dump_modify all format float %.17g {" ".join(f"colname {column} {name}" for column, name in zip(columns, names))}
        run 0
        write_data {tmp_path}/out.data""")
    in_body = other.scipy_rotation(one).inv().apply(one.angular_velocities)
    energy = 0.5 * (other.solid_inertia(one.semi_axes, one.masses) * in_body**2).sum()
    assert program.extract_variable("rotation") == pytest.approx(energy, rel=1e-12)
    program.close()
    fields = ("positions", "orientations", "semi_axes", "box", "velocities", "masses", "species")
    assert_same(edmd.read_system(tmp_path / "out.data"), one, (), 1e-14, (*fields, "angular_velocities"))
    assert_same(edmd.read_system(tmp_path / "out.dump"), one, (), 1e-14, fields)


# runs

@pytest.fixture(scope="module")
def growing(tmp_path_factory):
    """A compression of a mixture whose cell was made to change too: path, and the frames as h5py has them."""
    path = tmp_path_factory.mktemp("run") / "growing.h5md"
    start = fluids.fluid("prolate", 32, 0.3)
    start.species[::3] = 1
    simulation = edmd.Simulation(start)
    with edmd.Trajectory(path, edmd.Every(collisions=60)) as trajectory:
        simulation.run(collisions_per_particle=30, observers=[trajectory])
        simulation.compress(0.1, until_packing_fraction=0.4, observers=[trajectory])
    with h5py.File(path, "a") as file:
        group = file["particles/trajectory"]
        assert group["image/value"][:].any()
        frames = len(group["position/step"])
        stretch = np.linspace(1, 1.1, frames)
        group["box/edges/value"][:] *= stretch[:, None, None]
        return path, {name: group[f"{name}/value"][:] for name in ("position", "image", "semi_axes", "orientation", "box/edges")} | {
            "step": group["position/step"][:], "time": group["position/time"][:]}


@pytest.mark.parametrize("format", ["extxyz", "gsd", "lammps-dump"])
def test_every_frame_has_its_own_shape_and_cell(growing, format, tmp_path):
    other.needs_format(format)
    path, frames = growing
    target = tmp_path / f"run{other.FORMATS[format]}"
    assert edmd.export(path, target) == len(frames["step"]) > 5
    for frame in (0, 3, -1):
        system = edmd.read_system(target, frame)
        close = {"abs": 1e-5} if format == "gsd" else {"rel": 1e-13}
        assert system.semi_axes == pytest.approx(frames["semi_axes"][frame], **close)
        assert system.box == pytest.approx(frames["box/edges"][frame], **close)
        assert system.orientations == pytest.approx(frames["orientation"][frame], **close)
        assert system.positions == pytest.approx(frames["position"][frame], **close)
        assert system.species.sum() == 11
    assert frames["semi_axes"][-1, 0, 0] > 1.05 * frames["semi_axes"][0, 0, 0]


def test_steps_times_and_unwrapped_positions(growing, tmp_path):
    path, frames = growing
    edmd.export(path, tmp_path / "run.xyz", frames="2:9:3")
    edmd.export(path, tmp_path / "run.dump", frames=slice(2, 9, 3))
    images = ase.io.read(tmp_path / "run.xyz", index=":")
    dump = as_mdanalysis_reads(tmp_path / "run.dump", lammps_coordinate_convention="unscaled", unwrap_images=True)
    assert [atoms.info["step"] for atoms in images] == frames["step"][2:9:3].tolist() == [ts.data["step"] for ts in dump.trajectory]
    assert [atoms.info["time"] for atoms in images] == frames["time"][2:9:3].tolist()
    for atoms, k in zip(images, (2, 5, 8)):
        unwrapped = frames["position"][k] + frames["image"][k] @ frames["box/edges"][k]
        assert atoms.positions + atoms.arrays["map_shift"] @ atoms.cell[:] == pytest.approx(unwrapped, rel=1e-13, abs=1e-13)
        assert dump.trajectory[k // 3].positions == pytest.approx(unwrapped, abs=1e-4)


def test_gsd_keeps_steps_and_times(growing, tmp_path):
    hoomd = pytest.importorskip("gsd.hoomd")
    path, frames = growing
    edmd.export(path, tmp_path / "run.gsd")
    with hoomd.open(str(tmp_path / "run.gsd")) as file:
        assert [frame.configuration.step for frame in file] == frames["step"].tolist()
        assert [frame.log["time"][0] for frame in file] == frames["time"].tolist()


def test_lammps_data_holds_the_last_frame_or_the_one_asked_for(growing, tmp_path):
    path, frames = growing
    assert edmd.export(path, tmp_path / "last.data") == 1
    assert edmd.read_system(tmp_path / "last.data").semi_axes == pytest.approx(frames["semi_axes"][-1], rel=1e-15)
    assert edmd.export(path, tmp_path / "third.data", frames=3) == 1
    assert edmd.read_system(tmp_path / "third.data").positions == pytest.approx(frames["position"][3], rel=1e-15)


def test_a_system_read_back_runs_on(tmp_path):
    """The same collisions as the original: extended XYZ is exact."""
    start = fluids.fluid("prolate", 32, 0.4)
    edmd.export(start, tmp_path / "start.xyz")
    ends = [edmd.Simulation(one, seed=3) for one in (start, edmd.read_system(tmp_path / "start.xyz"))]
    for simulation in ends:
        simulation.run(collisions=500)
    assert np.array_equal(ends[0].system.positions, ends[1].system.positions)


# files of others

def test_gsd_of_others(tmp_path):
    """Types by letters, spheres by their diameter; without moments of inertia, with three different ones, and with another inertia."""
    hoomd = pytest.importorskip("gsd.hoomd")
    frame = hoomd.Frame()
    frame.particles.N, frame.particles.types, frame.particles.typeid = 2, ["A", "B"], [1, 0]
    frame.particles.position = np.array([[-4, 0, 0], [4, 0, 0]], dtype=np.float32)
    frame.particles.type_shapes = [{"type": "Sphere", "diameter": 3.0}, {"type": "Ellipsoid", "a": 1, "b": 2, "c": 3}]
    frame.configuration.box = [10, 10, 10, 0, 0, 0]

    def written(name):
        with hoomd.open(str(tmp_path / name), "w") as file:
            file.append(frame)
        return tmp_path / name

    system = edmd.read_system(written("a.gsd"))
    assert system.semi_axes.tolist() == [[1, 2, 3], [1.5, 1.5, 1.5]]
    assert system.species.tolist() == [1, 0]
    assert system.positions.tolist() == [[1, 5, 5], [9, 5, 5]]
    assert system.moments == pytest.approx(edmd.System([[0, 0, 0]] * 2, [[1, 0, 0, 0]] * 2, system.semi_axes, 10).moments)
    frame.particles.moment_inertia = np.array([[1, 2, 3], [1, 1, 1]], dtype=np.float32)
    frame.particles.angmom = np.array([[0, 2, 0, 0], [0, 0, 0, 2]], dtype=np.float32)
    triaxial = written("b.gsd")
    assert edmd.read_system(triaxial).moments[0].tolist() == [1, 2, 3]
    assert edmd.read_system(triaxial, inertia="solid").angular_velocities.tolist() == [[1, 0, 0], [0, 0, 1]]
    frame.particles.type_shapes = [{"type": "ConvexPolyhedron"}, {}]
    with pytest.raises(ValueError, match="ConvexPolyhedron"):
        edmd.read_system(written("c.gsd"))


def test_lammps_data_with_another_origin_order_and_no_velocities(tmp_path):
    path = tmp_path / "other.data"
    path.write_text("made by hand\n\n2 atoms\n1 atom types\n2 ellipsoids\n-5 5 xlo xhi\n-5 6 ylo yhi # a comment\n0 4 zlo zhi\n\n"
                    "Atoms\n\n2 1 1 2.0 1 2 3\n1 1 1 1.0 -5 -5 0\n\nEllipsoids\n\n1 2 2 4 1 0 0 0\n2 1 1 1 0 1 0 0\n")
    system = edmd.read_system(path)
    assert system.positions.tolist() == [[0, 0, 0], [6, 7, 3]]
    assert system.semi_axes.tolist() == [[1, 1, 2], [0.5, 0.5, 0.5]]
    assert system.masses == pytest.approx([4 / 3 * np.pi * 2, 2 * 4 / 3 * np.pi / 8])
    assert system.box.tolist() == np.diag([10, 11, 4]).tolist()
    assert system.orientations.tolist() == [[1, 0, 0, 0], [0, 1, 0, 0]]
    assert not system.angular_velocities.any()


def test_lammps_dump_of_others(tmp_path):
    """Columns in any order, unsorted, with words among them; no masses, no motion; an origin of its own."""
    path = tmp_path / "other.dump"
    frame = ("ITEM: TIMESTEP\n{}\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS xy xz yz pp pp pp\n-6 5 -1\n-5 5 0\n1 9 0\n"
             "ITEM: ATOMS element id shapex shapey shapez type x y z quatw quati quatj quatk\n"
             "Ar 2 1 1 4 3 0 0 2 0 0 0 1\nKr 1 2 2 2 1 -5 -5 1 1 0 0 0\n")
    path.write_text("ITEM: UNITS\nlj\n" + frame.format(10) + "ITEM: TIME\n0.5\n" + frame.format(20))
    for frame in (0, 1):
        system = edmd.read_system(path, frame)
        assert system.box.tolist() == [[10, 0, 0], [-1, 10, 0], [0, 0, 8]]
        assert system.positions.tolist() == [[0, 0, 0], [5, 5, 1]]
        assert system.semi_axes.tolist() == [[1, 1, 1], [0.5, 0.5, 2]]
        assert system.orientations.tolist() == [[1, 0, 0, 0], [0, 0, 0, 1]]
        assert system.species.tolist() == [0, 2]
        assert system.masses.tolist() == [1, 1]
        assert not system.velocities.any()


def test_h5md_with_another_inertia(growing):
    moments = edmd.read_system(growing[0], inertia="sphere").moments
    assert moments[:, 2] == pytest.approx(moments[:, 0])
    assert np.array_equal(edmd.read_system(growing[0], format="h5md").positions, edmd.read_system(growing[0]).positions)
