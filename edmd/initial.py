"""Where a run starts: crystals that ASE builds, random systems."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from math import ceil, pi, sqrt
from typing import TYPE_CHECKING

import numpy as np

from ccd import checks
from ccd.annotations import ArrayLike
from ccd.contacts import contact_functions
from edmd.building import margin_lengths
from edmd.system import System
from edmd.velocities import thermalized

if TYPE_CHECKING:
    from ase import Atoms

START_FRACTION = 0.3    # packing fraction of a crystal that is to melt, unless its lattice holds less
ROOMY = 0.85            # part of what the lattice holds at most, where that is less
BODIES_PER_CELL = 4     # fcc
LEAST_BODIES = 8
DENSEST = 0.75          # packing fraction for which the cell must have room around every body
LATTICES = ("fcc", "bcc", "sc", "hcp")
SPARSE = 0.02           # packing fraction at which random bodies are first laid down
RANDOM_RATE = 0.15      # speed at which surfaces grow from there to the wanted packing fraction, in thermal speeds
ATTEMPTS = 10_000       # rounds of moving the bodies that overlap


def lattice(name: str, semi_axes: ArrayLike, packing_fraction: float, cells: Sequence[int] = (5, 5, 5), seed: int = 0,
            stretched: bool = False, masses: ArrayLike = 1.0, inertia: str | ArrayLike = "solid") -> System:
    """A crystal of parallel bodies, built by ASE, with thermal velocities at kT = 1.

    name: "fcc", "bcc", "sc" (cubic cells) or "hcp" (orthorhombic cell, ideal c/a); semi_axes (3,) along x, y, z; cells: unit cells in each
    direction. stretched=True maps the lattice of touching spheres together with the shape, so that fcc and hcp reach pi / sqrt(18) for any
    axes; otherwise the lattice stays as it is, and holds less. ValueError says how much, when packing_fraction is above that.
    """
    if name not in LATTICES:
        raise ValueError(f"name = {name!r}: expected one of {', '.join(LATTICES)}; build any other crystal with ASE and edmd.from_ase")
    semi_axes = checks.semi_axes("semi_axes", semi_axes)
    packing_fraction = _packing_fraction(packing_fraction)
    seed = checks.natural_number("seed", seed)
    counts = _counts("cells", cells, "three positive integers")
    if len(counts) != 3:
        raise ValueError(f"cells = {cells!r}: expected three positive integers")
    from ase.build import bulk

    unit = bulk("X", name, a=1.0, cubic=True) if name != "hcp" else bulk("X", name, a=1.0, covera=sqrt(8 / 3), orthorhombic=True)
    shape = semi_axes / np.cbrt(semi_axes.prod()) if stretched else np.ones(3)
    size = np.cbrt(len(unit) * 4 * pi / 3 * semi_axes.prod() / packing_fraction / unit.cell.volume)
    unit.set_cell(unit.cell @ np.diag(size * shape), scale_atoms=True)
    # an offset keeps the bodies off the faces of the cell, where rounding would decide which image is the home one
    unit.positions += unit.cell.lengths() / 8
    one = System(unit.positions, np.tile([1.0, 0, 0, 0], (len(unit), 1)), semi_axes, np.array(unit.cell))
    largest = packing_fraction * one.smallest_scale()**3
    if largest < packing_fraction * (1 - 1e-12):
        raise ValueError(f"packing_fraction = {packing_fraction}: the {name} lattice of these bodies holds at most {largest:.6f}"
                         + ("" if stretched else " (stretched=True may hold more)"))
    return thermalized(from_ase(unit.repeat(counts), semi_axes, masses=masses, inertia=inertia), seed)


def crystal(n, semi_axes, start_fraction=None, seed=0):
    """n parallel bodies on an fcc lattice as near to a cube as their number allows, surplus sites empty, with thermal velocities at kT = 1.

    start_fraction: packing fraction, by default 0.3, or less for shapes that do not fit. The cell has room for a dense packing.
    """
    semi_axes = checks.semi_axes("semi_axes", semi_axes)
    if not isinstance(n, int | np.integer) or n < LEAST_BODIES:
        raise ValueError(f"n = {n!r}: expected a whole number of bodies, at least {LEAST_BODIES}")
    edge = ceil(np.cbrt(n / BODIES_PER_CELL) - 1e-9)
    cells = next(cells for cells in ((edge - 1, edge - 1, edge), (edge - 1, edge, edge), (edge, edge, edge))
                 if BODIES_PER_CELL * np.prod(cells) >= n)
    sites = BODIES_PER_CELL * int(np.prod(cells))
    if start_fraction is not None:
        most = _most(semi_axes) * n / sites
        start_fraction = checks.real_number("start_fraction", start_fraction, f"a number below {most:.4f} for this shape on an fcc "
                                            "lattice", above=0, below=most)
    else:
        start_fraction = min(START_FRACTION, ROOMY * _most(semi_axes) * n / sites)
    full = lattice("fcc", semi_axes, start_fraction * sites / n, cells, seed)
    stay = np.sort(np.random.default_rng(seed).permutation(sites)[:n])
    system = System(full.positions[stay], full.orientations[stay], semi_axes, full.box)
    longest = (semi_axes.max() + margin_lengths(semi_axes[None])[0]) * np.cbrt(DENSEST / system.packing_fraction)
    if system.box.diagonal().min() < 2 * longest:
        raise ValueError(f"n = {n}: too few bodies of this shape, each would come near its own periodic image when packed; expected at "
                         f"least {ceil(n * (2 * longest / system.box.diagonal().min())**3)}")
    return thermalized(system, seed)


def from_ase(atoms: Atoms, semi_axes: ArrayLike | None = None, orientations: ArrayLike | None = None, masses: ArrayLike | None = None,
             inertia: str | ArrayLike | None = None, species: ArrayLike | None = None) -> System:
    """A System from periodic ase.Atoms: positions and cell, turned so that the first cell vector lies along x, the second in xy.

    What is not given comes from the atoms, as `System.to_ase` and extended XYZ have it: semi_axes (as in System) from the array
    aspherical_shape; orientations (n, 4), (w, x, y, z), from orientation, (x, y, z, w), else all parallel to the axes; masses from mass or
    the masses that were set, else 1; velocities from velo or the momenta, angular velocities from omega, else rest; species from the tags;
    inertia from moments_of_inertia when the shapes are the atoms' own too, else "solid". Bodies and motion turn with the cell.
    """
    if not atoms.pbc.all():
        raise ValueError(f"atoms.pbc = {atoms.pbc.tolist()}: expected three periodic directions")
    arrays = atoms.arrays
    if semi_axes is None:
        if "aspherical_shape" not in arrays:
            raise ValueError("semi_axes = None: expected three lengths, one row of three a species or a body, or atoms with an array "
                             f"aspherical_shape; they have {', '.join(arrays)}")
        semi_axes = arrays["aspherical_shape"]
        inertia = arrays.get("moments_of_inertia") if inertia is None else inertia
    if masses is None:
        masses = arrays.get("mass", atoms.get_masses() if atoms.has("masses") else 1.0)
    if species is None and atoms.has("tags"):
        species = atoms.get_tags()
    velocities = arrays.get("velo", atoms.get_velocities() if atoms.has("momenta") else None)
    turning = arrays.get("omega")
    if atoms.cell.handedness < 0:           # the same lattice, its vectors turned round
        atoms = atoms.copy()
        atoms.set_cell(-atoms.cell[:])
    cell, rotation = atoms.cell.standard_form()
    if orientations is None:
        orientations = [(1.0, 0, 0, 0)] * len(atoms)
        if "orientation" in arrays:
            what = f"quaternions (x, y, z, w), ({len(atoms)}, 4)"
            orientations = checks.real_array("orientation", arrays["orientation"], (len(atoms), 4), what)[:, [3, 0, 1, 2]]
    positions, box = atoms.positions, np.array(cell)
    if not np.allclose(rotation, np.eye(3), atol=1e-14):
        from scipy.spatial.transform import Rotation

        positions, velocities, turning = (None if vectors is None else vectors @ rotation.T for vectors in (positions, velocities, turning))
        w, x, y, z = np.transpose(checks.unit_quaternions("orientations", orientations, (len(atoms), 4)))
        turned = Rotation.from_matrix(rotation) * Rotation.from_quat(np.stack([x, y, z, w], axis=1))
        orientations = turned.as_quat()[:, [3, 0, 1, 2]]
    else:
        box = np.array(atoms.cell)
    return System(positions, orientations, semi_axes, np.tril(box), velocities, turning, masses, "solid" if inertia is None else inertia,
                  species)


def random_system(n: int | Sequence[int], semi_axes: ArrayLike, packing_fraction: float, seed: int = 0, masses: ArrayLike = 1.0,
                  inertia: str | ArrayLike = "solid") -> System:
    """Bodies at random, without overlap, in a cubic cell, with thermal velocities at kT = 1.

    n: number of bodies with semi_axes (3,), or counts (k,) of k species with semi_axes (k, 3). The bodies are laid down at random
    while small and grow to their size in event-driven dynamics. ValueError when they jam before packing_fraction.
    """
    from edmd.simulation import Simulation

    packing_fraction = _packing_fraction(packing_fraction)
    what = "three lengths, or one row of three a species"
    rows = np.atleast_2d(checks.semi_axes("semi_axes", semi_axes, (3,) if np.ndim(semi_axes) == 1 else (None, 3), what))
    seed = checks.natural_number("seed", seed)
    counts = _counts("n", [n] if np.ndim(n) == 0 else n, f"one positive whole number for each of the {len(rows)} rows of semi_axes")
    if len(rows) != len(counts):
        raise ValueError(f"n = {n!r}: expected one positive whole number for each of the {len(rows)} rows of semi_axes")
    species = np.repeat(np.arange(len(counts)), counts)
    wanted = rows[species]
    edge = np.cbrt(4 * pi / 3 * wanted.prod(axis=1).sum() / packing_fraction)
    start = min(packing_fraction, SPARSE)
    small = wanted * np.cbrt(start / packing_fraction)
    rng = np.random.default_rng(seed)
    positions, orientations = _laid_down(small, edge, rng)
    system = thermalized(System(positions, orientations, small, edge, masses=masses, inertia=inertia, species=species), rng)
    if start < packing_fraction:
        simulation = Simulation(system)
        try:
            simulation.compress(RANDOM_RATE / small.max() / sqrt(system.masses.max()), until_packing_fraction=packing_fraction)
        except ValueError as problem:
            raise ValueError(f"packing_fraction = {packing_fraction}: random bodies do not get there ({problem})") from None
        system = simulation.system
    return thermalized(System(system.positions, system.orientations, wanted, edge, masses=masses, inertia=inertia,
                              species=species), rng)


def _counts(name, value, what):
    """Positive integers as a tuple."""
    try:
        counts = tuple(operator.index(count) for count in value)
    except TypeError:
        counts = ()
    if not counts or min(counts) < 1:
        raise ValueError(f"{name} = {value!r}: expected {what}")
    return counts


def _packing_fraction(value):
    return checks.real_number("packing_fraction", value, "a number between 0 and 1", above=0, below=1)


def _laid_down(semi_axes, edge, rng):
    """Random positions and orientations; one body of every overlapping pair is laid down again until none overlaps."""
    n, box = len(semi_axes), edge * np.eye(3)
    positions, orientations = rng.uniform(0, edge, size=(n, 3)), rng.normal(size=(n, 4))
    for _ in range(ATTEMPTS):
        _, second, f = contact_functions(positions, orientations, semi_axes, box)
        again = np.unique(second[f < 1.01])
        if len(again) == 0:
            return positions, orientations
        positions[again], orientations[again] = rng.uniform(0, edge, size=(len(again), 3)), rng.normal(size=(len(again), 4))
    raise ValueError(f"no room for {n} bodies of {semi_axes.max():.6g} in a cell of edge {edge:.6g}: use more bodies")


def _most(semi_axes):
    """The packing fraction at which parallel bodies on a cubic fcc lattice touch."""
    sparse = lattice("fcc", semi_axes, 1e-6, (1, 1, 1))
    a = sparse.box[0, 0]
    neighbours = a / 2 * np.array([[1, 1, 0], [1, 0, 1], [0, 1, 1], [2, 0, 0], [0, 2, 0], [0, 0, 2], [1, 1, 2], [1, 2, 1], [2, 1, 1]])
    touching = 0.5 * np.sqrt(((neighbours / semi_axes)**2).sum(axis=1)).min()
    return sparse.packing_fraction * touching**3
