"""The densest crystals known: built exactly, found again by compression, and hard when they vibrate."""

import json
from pathlib import Path

import ase
import independent
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import edmd

DENSEST = np.pi / np.sqrt(18)
CRYSTALS = json.loads((Path(__file__).parents[1] / "oracles" / "crystals.json").read_text())
AXES = [(1.0, 1.0, 1.0), (1.0, 1.0, 2.0), (1.0, 1.0, 0.3), (1.25, 1.0, 0.8), (0.4, 3.0, 1.0)]


@pytest.mark.parametrize("name", ["fcc", "hcp"])
@pytest.mark.parametrize("semi_axes", AXES)
def test_stretched_lattice_of_touching_bodies(name, semi_axes):
    """The affine image of close-packed spheres: pi / sqrt(18), twelve contacts a body, for any axes."""
    system = edmd.lattice(name, semi_axes, DENSEST, cells=(2, 2, 2), stretched=True)
    assert independent.packing_fraction(system) == pytest.approx(DENSEST, rel=1e-12)
    assert system.packing_fraction == pytest.approx(DENSEST, rel=1e-12)
    assert (independent.contact_counts(system, 1e-12) == 12).all()
    assert independent.smallest_scale(system) > 1 - 1e-12


def sm2(scale=1.0, cells=(2, 2, 2)):
    """The crystal of crystals.json, its cell scaled."""
    data = CRYSTALS["sm2_sqrt3"]
    quaternions = []
    for particle in data["particles"]:
        turned, _ = Rotation.align_vectors([particle["u"]], [[0, 0, 1]])
        quaternions.append(turned.as_quat())
    atoms = ase.Atoms("X4", positions=[p["x"] for p in data["particles"]], cell=data["cell"], pbc=True)
    atoms.set_array("orientation", np.array(quaternions))
    atoms.positions += 0.1
    atoms.set_cell(atoms.cell * scale, scale_atoms=True)
    return edmd.from_ase(atoms.repeat(cells), data["axes"])


def test_sm2_has_fourteen_contacts():
    crystal = sm2()
    assert crystal.packing_fraction == pytest.approx(0.770731577660887, rel=1e-12)
    assert (independent.contact_counts(crystal, 1e-12) == 14).all()
    assert independent.smallest_scale(crystal) > 1 - 1e-12


@pytest.mark.parametrize(("name", "cells", "semi_axes"), [("fcc", (3, 3, 3), (1, 1, 1.0)), ("hcp", (4, 2, 2), (1, 1, 1.0)),
                                                         ("fcc", (3, 3, 3), (1, 1, 1.5)), ("fcc", (3, 3, 3), (1.25, 1, 0.8))])
def test_expanded_crystal_is_compressed_back(name, cells, semi_axes):
    """From 0.70 back to pi / sqrt(18). Bodies that are no spheres are too heavy to turn: other crystals are as dense or denser."""
    inertia = "solid" if len(set(semi_axes)) == 1 else (1e16,) * 3
    start = edmd.lattice(name, semi_axes, 0.70, cells=cells, stretched=True, inertia=inertia, seed=4)
    simulation = edmd.Simulation(start)
    simulation.run(collisions_per_particle=20)
    simulation.compress(1e-2, until_pressure=1e8)
    assert simulation.packing_fraction == pytest.approx(DENSEST, rel=1e-6)
    assert simulation.packing_fraction < DENSEST * (1 + 1e-12)
    assert independent.smallest_scale(simulation.system) > 1 - 1e-9


@pytest.mark.parametrize("start", [lambda: edmd.lattice("fcc", (1.25, 1, 0.8), 0.6, cells=(2, 2, 2), stretched=True),
                                   lambda: edmd.thermalized(sm2((0.770731577660887 / 0.6)**(1 / 3)), 3)], ids=["fcc", "sm2"])
def test_no_gap_of_a_vibrating_crystal_drops_below_zero(start):
    simulation = edmd.Simulation(start())
    smallest = []
    look = edmd.Observer(edmd.Every(time=0.0371), lambda view: smallest.append(independent.smallest_scale(view.system)))
    simulation.run(collisions=2000, observers=[look])
    assert len(smallest) > 40
    assert min(smallest) > 1 - 1e-12
    assert min(smallest) < 1.001, "no pair came near: this test would see nothing"


@pytest.mark.parametrize(("name", "most"), [("bcc", np.pi * np.sqrt(3) / 8), ("sc", np.pi / 6), ("fcc", DENSEST), ("hcp", DENSEST)])
def test_lattice_says_how_much_it_holds(name, most):
    """Spheres, and stretched bodies: the maximum is met, what is beyond it is refused with the number."""
    for semi_axes in ((1, 1, 1), (1, 1.3, 0.6)):
        full = edmd.lattice(name, semi_axes, most * (1 - 1e-13), cells=(2, 2, 2), stretched=True)
        assert full.packing_fraction == pytest.approx(most, rel=1e-12)
        with pytest.raises(ValueError, match=f"packing_fraction.*at most {most:.6f}"):
            edmd.lattice(name, semi_axes, most + 1e-6, stretched=True)


def test_unstretched_lattice_holds_what_the_cube_allows():
    """Parallel 1:1:2 on a cubic fcc lattice of edge a: they touch along z at a = 4 and across the face at a = 2 sqrt(2), so at a = 4."""
    spheroid = 4 * np.pi / 3 * 2
    most = 4 * spheroid / 4**3
    tight = edmd.lattice("fcc", (1, 1, 2), most * (1 - 1e-12), cells=(2, 2, 2))
    assert independent.smallest_scale(tight) == pytest.approx(1, abs=1e-9)
    with pytest.raises(ValueError, match=f"at most {most:.6f}.*stretched"):
        edmd.lattice("fcc", (1, 1, 2), most * 1.001)


@pytest.mark.parametrize(("arguments", "names"), [
    (("fcb", (1, 1, 1), 0.5), "name"),
    (("fcc", (1, 1), 0.5), "semi_axes"),
    (("fcc", (1, 1, -1), 0.5), "semi_axes"),
    (("fcc", (1, 1, 1), 0.0), "packing_fraction"),
    (("fcc", (1, 1, 1), 1.5), "packing_fraction"),
    (("fcc", (1, 1, 1), float("nan")), "packing_fraction"),
    (("fcc", (1, 1, 1), 0.5, (0, 1, 1)), "cells"),
    (("fcc", (1, 1, 1), 0.5, (1.5, 1, 1)), "cells"),
    (("fcc", (1, 1, 1), 0.5, (1, 1)), "cells"),
    (("fcc", (1, 1, 1), 0.5, 3), "cells"),
])
def test_bad_lattices_are_refused_by_name(arguments, names):
    with pytest.raises(ValueError, match=names):
        edmd.lattice(*arguments)
