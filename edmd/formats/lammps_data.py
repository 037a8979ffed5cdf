"""LAMMPS data files, atom_style ellipsoid, for `read_data`: one state, and the way back."""

from math import pi

import numpy as np

import edmd
from ccd.quaternions import to_body, to_lab
from edmd.formats.text import TILTS, table, words
from edmd.inertia import solid_moments
from edmd.system import System

BOUNDS = ("xlo", "ylo", "zlo")
WIDTHS = {"Atoms": (7, 10), "Ellipsoids": (8,), "Velocities": (7,)}     # columns; Atoms with or without images


def write(path, frames):
    """The one frame. A density makes the mass, and angular momentum belongs to LAMMPS' inertia, that of the solid ellipsoid."""
    (system, images, time, step), = frames
    number, box = np.arange(1, system.n + 1), system.box
    density = system.masses / _volumes(system.semi_axes)
    momenta = to_lab(system.orientations, solid_moments(system.semi_axes, system.masses)
                     * to_body(system.orientations, system.angular_velocities))
    with open(path, "w", encoding="utf-8") as file:
        file.write(f"edmd {edmd.__version__}, atom_style ellipsoid, units lj, time {float(time)!r}, collisions {int(step)}\n\n"
                   f"{system.n} atoms\n{system.species.max() + 1} atom types\n{system.n} ellipsoids\n\n")
        for bound, length in zip(BOUNDS, np.diag(box).tolist()):
            file.write(f"0.0 {length} {bound} {bound[0]}hi\n")
        if np.tril(box, -1).any():
            file.write(f"{words(box[TILTS])} xy xz yz\n")
        file.write("\nAtoms # ellipsoid\n\n" + table(number, system.species + 1, np.ones(system.n, dtype=int), density, system.positions,
                                                    images))
        file.write("\nEllipsoids\n\n" + table(number, 2 * system.semi_axes, system.orientations))
        file.write("\nVelocities\n\n" + table(number, system.velocities, momenta))


def read(path, frame=-1, inertia=None):
    if frame not in (0, -1):
        raise ValueError(f"frame = {frame}: a LAMMPS data file holds one frame; expected 0 or -1")
    header, sections = _parse(path)
    edges = np.array([header.get(f"{bound} {bound[0]}hi", (-0.5, 0.5)) for bound in BOUNDS])
    box = np.diag(edges[:, 1] - edges[:, 0])
    box[TILTS] = header.get("xy xz yz", (0, 0, 0))
    atoms, shapes = (_rows(sections, name, path) for name in ("Atoms", "Ellipsoids"))
    motion = _rows(sections, "Velocities", path) if "Velocities" in sections else np.column_stack([atoms[:, 0], np.zeros((len(atoms), 6))])
    if not (atoms[:, 2] == 1).all() or not all(np.array_equal(atoms[:, 0], other[:, 0]) for other in (shapes, motion)):
        raise ValueError(f"path = {str(path)!r}: expected every atom with ellipsoidflag 1, a line in Ellipsoids and one in Velocities")
    semi_axes = shapes[:, 1:4] / 2
    still = System(atoms[:, 4:7] - edges[:, 0], shapes[:, 4:8], semi_axes, box, masses=atoms[:, 3] * _volumes(semi_axes),
                   species=atoms[:, 1].astype(int) - 1)
    turning = to_lab(still.orientations, to_body(still.orientations, motion[:, 4:7]) / solid_moments(semi_axes, still.masses))
    return System(still.positions, still.orientations, still.semi_axes, box, motion[:, 1:4], turning, still.masses,
                  "solid" if inertia is None else inertia, still.species)


def _volumes(semi_axes):
    return 4 * pi / 3 * semi_axes.prod(axis=1)


def _parse(path):
    """-> the header {words behind the numbers: numbers}, and the rows of each section, as lists of words."""
    header, sections, rows = {}, {}, None
    try:
        with open(path, encoding="utf-8") as file:
            next(file, None)                        # LAMMPS skips the first line too
            lines = [line.split("#")[0].split() for line in file]
    except (OSError, UnicodeDecodeError) as problem:
        raise ValueError(f"path = {str(path)!r}: cannot be read as text ({problem})") from None
    for line in filter(None, lines):
        numbers = [word for word in line if not word[0].isalpha()]
        if not numbers:
            rows = sections[" ".join(line)] = []
        elif rows is None:
            header[" ".join(line[len(numbers):])] = _floats([numbers], path)[0]
        else:
            rows.append(line)
    if "Atoms" not in sections or any("avec" in words for words in header):
        raise ValueError(f"path = {str(path)!r}: not a LAMMPS data file with a section Atoms and a box xlo xhi, ylo yhi, zlo zhi, xy xz yz")
    return header, sections


def _rows(sections, name, path):
    """The rows of a section (n, columns), in the order of the atoms' numbers."""
    rows = sections.get(name, [])
    if not rows or {len(row) for row in rows} - set(WIDTHS[name]) or len({len(row) for row in rows}) > 1:
        raise ValueError(f"path = {str(path)!r}: section {name}: expected lines of {' or '.join(map(str, WIDTHS[name]))} numbers, as "
                         "atom_style ellipsoid has them")
    values = _floats(rows, path)
    return values[np.argsort(values[:, 0], kind="stable")]


def _floats(rows, path):
    try:
        return np.array(rows, dtype=float)
    except ValueError as problem:
        raise ValueError(f"path = {str(path)!r}: not a LAMMPS data file ({problem})") from None
