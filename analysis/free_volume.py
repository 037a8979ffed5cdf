"""How much room is left near jamming? The free-volume equation of state, and the room of each body in its cage."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from analysis.frames import ThreadedAnalysis
from ccd import Status, batch, checks
from ccd.annotations import Any, ArrayLike, Floats
from ccd.culling import near_pairs

if TYPE_CHECKING:
    from MDAnalysis import AtomGroup

AT_ONCE = 200_000               # flights computed at a time


def jamming_point(packing_fraction: ArrayLike, reduced_pressure: ArrayLike, above: float = 100.0) -> tuple[float, float]:
    """The packing fraction at which the pressure diverges, and the number f of the law, from the points of a compression.

    P V / (n kT) = f / (1 - phi / phi_J) near jamming (Salsburg and Wood, J. Chem. Phys. 37, 798 (1962)): f is the number of degrees of
    freedom a body, 3 (1 - 1/n) for n spheres whose common motion does not count. `packing_fraction` and `reduced_pressure` (m,); points
    of a reduced pressure below `above` do not count, the law is a limit. Least squares of the relative deviations of 1/P, which is linear
    in phi. Returns (phi_J, f). ValueError for fewer than three such points, or a pressure that does not rise with the packing fraction.
    """
    phi = checks.real_array("packing_fraction", packing_fraction, (None,), "numbers (m,)")
    z = checks.real_array("reduced_pressure", reduced_pressure, (len(phi),), f"numbers ({len(phi)},)")
    phi, z = phi[z >= above], z[z >= above]
    if len(phi) < 3 or np.ptp(phi) == 0:
        raise ValueError(f"reduced_pressure: {len(phi)} points above {above}; expected three or more, at different densities")
    densest, width = phi.max(), np.ptp(phi)
    intercept, slope = np.linalg.lstsq(np.stack([z, z * (densest - phi) / width], axis=1), np.ones(len(z)), rcond=None)[0]
    if slope <= 0:
        raise ValueError("reduced_pressure: it does not rise with the packing fraction")
    jammed = densest + intercept / slope * width
    return float(jammed), float(width / (slope * jammed))


def free_volumes(positions: ArrayLike, orientations: ArrayLike, semi_axes: ArrayLike, cell: ArrayLike, reach: float = 0.5,
                 directions: int = 500) -> Floats:
    """The volume (n,) that the centre of each body can see while all others, and its own orientation, stay as they are.

    The integral of s^3 / 3 over all directions, with s the way to the first contact by `ccd`'s certified shoot: the whole free volume of
    a body in its cage where that is seen from its centre, as it is near jamming (it is a polyhedron then), and less where it has corners.
    Over `directions` equal patches of the sphere: some 1 % at 300. A cage is open, and the volume nan, when a way of `reach` times the
    longest semi-axis of all meets nobody. 0 for a body that overlaps. Arguments as `analysis.contact_pairs`. In cubed units of length.
    """
    bodies = batch.Bodies(semi_axes, positions, orientations)
    cell = checks.cell_vectors("cell", cell)
    if checks.natural_number("directions", directions) == 0:
        raise ValueError(f"directions = {directions}: expected at least one, some hundred for 1 %")
    longest = checks.real_number("reach", reach, "a positive number", above=0) * bodies.semi_axes.max()
    first, second, separation = near_pairs(bodies.center, cell, longest + 2 * bodies.semi_axes.max())
    others = first != second                                    # an own image moves along
    mover = np.concatenate([first[others], second[others]])
    obstacle = np.concatenate([second[others], first[others]])
    separation = np.concatenate([separation[others], -separation[others]])
    volumes, n, m = np.zeros(len(bodies)), len(bodies), len(mover)
    for several in np.array_split(sphere_points(directions), 1 + directions * m // AT_ONCE):
        k = len(several)
        flying, resting = [batch.Bodies(np.tile(bodies.semi_axes[who], (k, 1)), center, np.tile(bodies.orientation[who], (k, 1)), velocity)
                           for who, center, velocity in ((mover, np.zeros((k * m, 3)), np.repeat(several, m, axis=0)),
                                                         (obstacle, np.tile(separation, (k, 1)), None))]
        time, status = batch.first_contact(flying, resting, longest)
        time[status == Status.UNRESOLVED] = np.nan
        way = np.full((k, n), np.inf)
        np.minimum.at(way, (np.repeat(np.arange(k), m), np.tile(mover, k)), time)
        volumes += np.sum(np.where(np.isinf(way), np.nan, way)**3, axis=0) / 3 * 4 * np.pi / directions
    return volumes


def sphere_points(n):
    """n unit vectors (n, 3) that share the sphere equally: a spiral whose turns are golden."""
    z = (2 * np.arange(n) + 1) / n - 1
    angle = np.pi * (1 + np.sqrt(5)) * np.arange(n)
    return np.stack([np.sqrt(1 - z * z) * np.cos(angle), np.sqrt(1 - z * z) * np.sin(angle), z], axis=1)


class FreeVolumes(ThreadedAnalysis):
    """Free volumes of the atoms along a trajectory: `FreeVolumes(u.atoms).run(start=-1)`; `results.volumes` (frames, n), as `free_volumes`.

    Takes some 2 ms a body and frame for each hundred directions.
    """

    SERIES = ("volumes",)

    def __init__(self, atomgroup: AtomGroup, reach: float = 0.5, directions: int = 500, **kwargs: Any) -> None:
        super().__init__(atomgroup, **kwargs)
        self.reach, self.directions = reach, directions

    def _frame(self):
        return (free_volumes(*self.bodies, self.cell, self.reach, self.directions),)
