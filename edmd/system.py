"""System: the bodies, their motion and their periodic cell, as a user hands them over and gets them back."""

from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING

import numpy as np

from ccd import Ellipsoid, batch, checks
from ccd.annotations import Array, ArrayLike, Floats
from ccd.contacts import contact_functions
from edmd.inertia import principal_moments

if TYPE_CHECKING:
    from ase import Atoms

PER_BODY = ("positions", "orientations", "semi_axes", "velocities", "angular_velocities", "masses", "moments", "species")


class System:
    """Hard ellipsoids in a periodic cell. Reduced units: lengths, masses and energies free, time = length sqrt(mass / energy).

    positions (n, 3); orientations (n, 4), quaternions (w, x, y, z) that turn body into lab; semi_axes (3,), (n, 3) or, with species, one
    row a species; box: edge length, (3,) edges, or (3, 3) with the cell vectors as rows, lower triangular (`edmd.from_ase` turns any
    other cell). velocities, angular_velocities (n, 3), in the lab frame, default to rest. masses: one number or (n,).

    inertia: "solid" (uniform density), "sphere" (isotropic, of the sphere of equal volume and mass), or any principal moments (3,) or
    (n, 3), about the semi-axes. Free bodies turn exactly with them. Structure, packing fraction and pressure in equilibrium do not depend
    on inertia.
    species (n,): integers that label the bodies.
    """

    def __init__(self, positions: ArrayLike, orientations: ArrayLike, semi_axes: ArrayLike, box: ArrayLike,
                 velocities: ArrayLike | None = None, angular_velocities: ArrayLike | None = None, masses: ArrayLike = 1.0,
                 inertia: str | ArrayLike = "solid", species: ArrayLike | None = None) -> None:
        self.positions = checks.real_array("positions", positions, (None, 3), "an array (n, 3)")
        n = len(self.positions)
        if n == 0:
            raise ValueError("positions is empty: expected at least one body")
        self.orientations = checks.unit_quaternions("orientations", orientations, (n, 4), f"quaternions ({n}, 4)")
        self.species = np.zeros(n, dtype=np.int32) if species is None else _labels(species, n)
        self.semi_axes = _semi_axes(semi_axes, self.species)
        self.box = cell_vectors(box)
        still = np.zeros((n, 3))
        what = f"an array ({n}, 3)"
        self.velocities = still if velocities is None else checks.real_array("velocities", velocities, (n, 3), what)
        self.angular_velocities = (still.copy() if angular_velocities is None
                                   else checks.real_array("angular_velocities", angular_velocities, (n, 3), what))
        self.masses = checks.real_array("masses", np.full(n, masses) if np.ndim(masses) == 0 else masses, (n,), f"one number or ({n},)")
        if not (self.masses > 0).all():
            raise ValueError(f"masses = {masses!r}: every mass must be positive")
        self.inertia = inertia
        self.moments = principal_moments(inertia, self.semi_axes, self.masses)

    @property
    def n(self) -> int:
        return len(self.positions)

    @property
    def volume(self) -> float:
        """Volume of the cell."""
        return float(self.box[0, 0] * self.box[1, 1] * self.box[2, 2])

    @property
    def packing_fraction(self) -> float:
        return float(4 * pi / 3 * self.semi_axes.prod(axis=1).sum() / self.volume)

    @property
    def bodies(self) -> batch.Bodies:
        """The bodies at rest, for `ccd.batch`."""
        return batch.Bodies(self.semi_axes, self.positions, self.orientations)

    def body(self, index: int) -> Ellipsoid:
        """One body as a `ccd.Ellipsoid`."""
        return Ellipsoid(self.semi_axes[index], self.positions[index], self.orientations[index])

    def copy(self) -> System:
        return self.subset(np.arange(self.n))

    def subset(self, indices: ArrayLike) -> System:
        """The System of some of the bodies, in this order, in the same cell."""
        part = object.__new__(System)
        for name in PER_BODY:
            setattr(part, name, getattr(self, name)[indices])
        part.box, part.inertia = self.box.copy(), self.inertia if isinstance(self.inertia, str) else part.moments
        return part

    def makeup(self) -> System:
        """A copy of what no run changes, read-only. Where the bodies are and how they move is left out. What is the same for all takes no
        memory."""
        like = self.subset(np.arange(self.n))
        like.positions[:] = like.velocities[:] = like.angular_velocities[:] = 0.0
        like.orientations[:] = np.eye(4)[0]
        for name in PER_BODY:
            rows = getattr(like, name)
            if (rows == rows[0]).all():
                setattr(like, name, np.broadcast_to(rows[0].copy(), rows.shape))
        like.inertia = self.inertia if isinstance(self.inertia, str) else like.moments
        return like

    def contact_functions(self, gap: float = 0.0) -> tuple[Array, Array, Floats]:
        """The pairs whose bounding spheres touch when scaled by 1 + gap, and their contact functions; see `ccd.contacts`."""
        return contact_functions(self.positions, self.orientations, self.semi_axes, self.box, gap)

    def smallest_scale(self) -> float:
        """The factor by which all bodies must be scaled for the closest pair to touch: below 1 for an overlap, inf if none is close."""
        _, _, f = self.contact_functions()
        return float(np.sqrt(f.min())) if len(f) else np.inf

    def to_ase(self) -> Atoms:
        """ase.Atoms, from which `edmd.from_ase` makes the same System again.

        OVITO maps the arrays orientation (x, y, z, w), aspherical_shape (semi-axes) and omega (angular velocities) by themselves;
        moments_of_inertia is ours. The species are ASE's tags, and the symbols too, for colours: X, H, He, ... ASE keeps velocities as
        momenta.
        """
        import ase

        atoms = ase.Atoms(symbols=element_symbols(self.species), positions=self.positions, cell=self.box, pbc=True, tags=self.species)
        atoms.set_masses(self.masses)
        atoms.set_velocities(self.velocities)
        for name, array in {"orientation": self.orientations[:, [1, 2, 3, 0]], "aspherical_shape": self.semi_axes,
                            "omega": self.angular_velocities, "moments_of_inertia": self.moments}.items():
            atoms.set_array(name, array)
        return atoms


def element_symbols(species):
    """A chemical symbol for each species, as programs for atoms ask for one and colour by it: X for 0, then H, He, ..."""
    from ase.data import chemical_symbols

    return [chemical_symbols[label % len(chemical_symbols)] for label in species]


def wrap(positions, box):
    """Positions inside the cell (n, 3), and the images (n, 3) they were in: positions = wrapped + images @ box."""
    images = np.floor(positions @ np.linalg.inv(box))
    return positions - images @ box, images.astype(np.int32)


def cell_vectors(box):
    """The cell vectors (3, 3) of a length, three edges, or rows; they must be right-handed and lower triangular."""
    what = "a length, three edges (3,), or three cell vectors as rows (3, 3)"
    shape = () if np.size(box) == 1 else (3,) if np.ndim(box) == 1 else (3, 3)
    box = checks.real_array("box", np.ravel(box)[0] if shape == () else box, shape, what)
    if box.ndim < 2:
        box = np.diag(np.full(3, box) if box.ndim == 0 else box)
    if np.triu(box, 1).any() or not (np.diag(box) > 0).all():
        raise ValueError(f"box = {box.tolist()}: expected positive edges and a lower triangular matrix (first vector along x, second in "
                         "the xy plane); edmd.from_ase brings any other cell into this form")
    return box


def _labels(species, n):
    labels = np.asarray(species)
    if labels.shape != (n,) or not np.issubdtype(labels.dtype, np.integer) or (labels < 0).any():
        raise ValueError(f"species: expected {n} integers from 0 on, not {species!r}")
    return labels.astype(np.int32)


def _semi_axes(value, species):
    n = len(species)
    if np.ndim(value) == 1:
        return np.tile(_made_equal(checks.semi_axes("semi_axes", value)[None]), (n, 1))
    rows = checks.semi_axes("semi_axes", value, (None, 3), f"three lengths, one row of three a species, or ({n}, 3)")
    rows = _made_equal(rows)
    if len(rows) == n:
        return rows
    if len(rows) == species.max() + 1:
        return rows[species]
    raise ValueError(f"semi_axes has {len(rows)} rows: expected {n} (one a body) or {species.max() + 1} (one a species)")


def _made_equal(rows):
    """Semi-axes that agree but for rounding (1e-12) are made equal: whether a body is one of revolution is asked with ==."""
    for one, other in ((0, 1), (1, 2), (0, 2)):
        rows[:, other] = np.where(abs(rows[:, other] - rows[:, one]) <= 1e-12 * rows[:, one], rows[:, one], rows[:, other])
    return rows
