"""Compression to a jammed packing, as a user asks for it: a crystal melts, the fluid is compressed until it jams."""

import time
from math import ceil
from typing import NamedTuple

import numpy as np

from ccd import checks
from ccd.contacts import contact_numbers, contact_pairs, mean_contact_number, rattlers
from edmd.initial import lattice, thermalized
from edmd.observers import Milestones
from edmd.outputs import check_output
from edmd.simulation import Simulation, check_growth, checked_pressure
from edmd.system import System
from edmd.tolerances import MARGIN
from edmd.trajectory import Trajectory

START_FRACTION = 0.3            # packing fraction of the crystal that melts, unless its lattice holds less
ROOMY = 0.85                    # part of what the lattice holds at most, where that is less
BODIES_PER_CELL = 4             # fcc
LEAST_BODIES = 8
FLUID_RATE, FLUID_PRESSURE = 1e-2, 100.0
DENSEST = 0.75                  # packing fraction for which the cell must have room around every body
CLOSED, WIDEST_GAP = 1000.0, 0.01


class Packing(NamedTuple):
    """A jammed packing. contact_numbers (n,): contacts mu - 1 < contact_gap; mean_contact_number: of the bodies that are held, among
    themselves; rattlers (n,): those that are not; pressure: reduced, P V / (n kT), at the end; seconds: CPU time of the events."""

    system: System
    packing_fraction: float
    pressure: float
    contact_numbers: np.ndarray
    mean_contact_number: float
    rattlers: np.ndarray
    nematic_order: float
    collisions: int
    seconds: float


def pack(n, semi_axes, rate=1e-3, seed=0, until_pressure=1e8, fluid_rate=None, start_fraction=None, melt=100, contact_gap=None,
         output=None, overwrite=False, observers=()):
    """Pack n equal ellipsoids: an fcc crystal built by ASE melts, and the fluid is compressed (Lubachevsky and Stillinger) until it jams.

    semi_axes (3,): at the start; the bodies end larger (system.semi_axes), in their proportions.
    rate: growth of the semi-axes, as 1 + rate t at kT = 1 and mass 1, from a reduced pressure of 100 on.
    seed: of the thermal velocities, and of the sites that stay empty when n is no number of a crystal.
    until_pressure: the reduced pressure P V / (n kT) that counts as jammed.
    fluid_rate: growth up to a reduced pressure of 100 (default 0.01 / (abc)^(1/3), or rate if faster): spheres do not crystallise.
    start_fraction: packing fraction of the crystal (default 0.3, or less for shapes that do not fit).
    melt: collisions per particle before the compression.
    contact_gap: see Packing (default 1000 / until_pressure, at most 0.01: contacts have closed to that, near ones have not).
    output: an H5MD file for the whole course, refused when it exists unless overwrite is true.

    -> Packing. ValueError names what cannot be.
    """
    semi_axes = checks.semi_axes("semi_axes", semi_axes)
    rate = checks.real_number("rate", rate, "a positive growth rate", above=0)
    if fluid_rate is None:
        fluid_rate = max(rate, FLUID_RATE / np.cbrt(semi_axes.prod()))
    fluid_rate = checks.real_number("fluid_rate", fluid_rate, "a positive growth rate", above=0)
    seed = checks.natural_number("seed", seed)
    melt = checks.real_number("melt", melt, "a number of collisions per particle, not negative", at_least=0)
    until_pressure = checked_pressure(until_pressure)
    contact_gap = min(WIDEST_GAP, CLOSED / until_pressure) if contact_gap is None else checks.real_number(
        "contact_gap", contact_gap, "a positive number", above=0)
    start = _crystal(n, semi_axes, start_fraction, seed)
    longest = semi_axes.max() * np.cbrt(DENSEST / start.packing_fraction)
    check_growth("rate", rate, longest)
    check_growth("fluid_rate", fluid_rate, longest)
    parameters = {"n": int(n), "semi_axes": semi_axes.tolist(), "rate": rate, "fluid_rate": fluid_rate, "seed": seed,
                  "until_pressure": until_pressure, "start_fraction": start.packing_fraction, "melt": melt}
    if output is not None:
        check_output(output, overwrite)
    simulation = Simulation(start, seed)
    began = time.process_time()
    if output is None:
        _melt_and_compress(simulation, (fluid_rate, rate), until_pressure, melt, observers)
    else:
        with Trajectory(output, Milestones(), parameters, overwrite) as trajectory:
            _melt_and_compress(simulation, (fluid_rate, rate), until_pressure, melt, [*observers, trajectory])
    seconds = time.process_time() - began
    system = simulation.system
    pairs = contact_pairs(system.positions, system.orientations, system.semi_axes, system.box, contact_gap)
    return Packing(system, simulation.packing_fraction, simulation.last_means.reduced_pressure, contact_numbers(pairs, n),
                   mean_contact_number(pairs, n), rattlers(pairs, n), simulation.nematic_order, simulation.collisions, seconds)


def _melt_and_compress(simulation, rates, until_pressure, melt, observers):
    if melt:
        simulation.run(collisions_per_particle=melt, observers=observers)
    simulation.compress(rates[0], until_pressure=min(FLUID_PRESSURE, until_pressure), observers=observers)
    if until_pressure > FLUID_PRESSURE:
        simulation.compress(rates[1], until_pressure=until_pressure, observers=observers)


def _crystal(n, semi_axes, start_fraction, seed):
    """Parallel bodies on an fcc lattice as near to a cube as their number allows, surplus sites empty."""
    if not isinstance(n, int | np.integer) or n < LEAST_BODIES:
        raise ValueError(f"n = {n!r}: expected a whole number of bodies, at least {LEAST_BODIES}")
    edge = ceil(np.cbrt(n / BODIES_PER_CELL) - 1e-9)
    cells = next(cells for cells in ((edge - 1, edge - 1, edge), (edge - 1, edge, edge), (edge, edge, edge))
                 if BODIES_PER_CELL * np.prod(cells) >= n)
    sites = BODIES_PER_CELL * int(np.prod(cells))
    if start_fraction is not None:
        start_fraction = checks.real_number("start_fraction", start_fraction, f"a number below {_most(semi_axes) * n / sites:.4f} for this "
                                            "shape on an fcc lattice", above=0, below=_most(semi_axes) * n / sites)
    else:
        start_fraction = min(START_FRACTION, ROOMY * _most(semi_axes) * n / sites)
    full = lattice("fcc", semi_axes, start_fraction * sites / n, cells, seed)
    stay = np.sort(np.random.default_rng(seed).permutation(sites)[:n])
    system = System(full.positions[stay], full.orientations[stay], semi_axes, full.box)
    longest = (semi_axes.max() + MARGIN * np.cbrt(semi_axes.prod())) * np.cbrt(DENSEST / system.packing_fraction)
    if system.box.diagonal().min() < 2 * longest:
        raise ValueError(f"n = {n}: too few bodies of this shape, each would come near its own periodic image when packed; expected at "
                         f"least {ceil(n * (2 * longest / system.box.diagonal().min())**3)}")
    return thermalized(system, seed)


def _most(semi_axes):
    """The packing fraction at which parallel bodies on a cubic fcc lattice touch."""
    sparse = lattice("fcc", semi_axes, 1e-6, (1, 1, 1))
    a = sparse.box[0, 0]
    neighbours = a / 2 * np.array([[1, 1, 0], [1, 0, 1], [0, 1, 1], [2, 0, 0], [0, 2, 0], [0, 0, 2], [1, 1, 2], [1, 2, 1], [2, 1, 1]])
    touching = 0.5 * np.sqrt(((neighbours / semi_axes)**2).sum(axis=1)).min()
    return sparse.packing_fraction * touching**3
