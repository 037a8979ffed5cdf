"""Compression to a jammed packing, as a user asks for it: a crystal melts, the fluid is compressed until it jams."""

from __future__ import annotations

import time
from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ccd import checks
from ccd.annotations import AnyPath, ArrayLike
from ccd.contacts import contact_numbers, contact_pairs, mean_contact_number, rattlers
from edmd.compression import check_growth, checked_pressure
from edmd.config import Compress, Config, Crystal, Output, Run
from edmd.initial import DENSEST, crystal
from edmd.rules.elastic import Elastic
from edmd.runs import do_stage, run
from edmd.simulation import Simulation
from edmd.system import System

if TYPE_CHECKING:
    from edmd.observers import Observer

FLUID_RATE, FLUID_PRESSURE = 1e-2, 100.0
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


def pack(n: int, semi_axes: ArrayLike, rate: float = 1e-3, seed: int = 0, until_pressure: float = 1e8, fluid_rate: float | None = None,
         start_fraction: float | None = None, melt: float = 100, contact_gap: float | None = None, output: AnyPath | None = None,
         overwrite: bool = False, observers: Iterable[Observer] = ()) -> Packing:
    """Pack n equal ellipsoids: an fcc crystal built by ASE melts, and the fluid is compressed (Lubachevsky and Stillinger) until it jams.

    semi_axes (3,): at the start; the bodies end larger (system.semi_axes), in their proportions.
    rate: growth of the semi-axes, as 1 + rate t at kT = 1 and mass 1, from a reduced pressure of 100 on.
    seed: of the thermal velocities, and of the sites that stay empty when n is no number of a crystal.
    until_pressure: the reduced pressure P V / (n kT) that counts as jammed, at most 1e12.
    fluid_rate: growth up to a reduced pressure of 100 (default 0.01 / (abc)^(1/3), or rate if faster): spheres do not crystallise.
    start_fraction: packing fraction of the crystal (default 0.3, or less for shapes that do not fit).
    melt: collisions per particle before the compression.
    contact_gap: see Packing (default 1000 / until_pressure, at most 0.01: contacts have closed to that, near ones have not).
    output: an H5MD file for the whole course, refused when it exists unless overwrite is true: a run as `edmd.run` does it, which
    `edmd.resume` continues when it is interrupted.

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
    contact_gap = closed_gap(until_pressure) if contact_gap is None else checks.real_number(
        "contact_gap", contact_gap, "a positive number", above=0)
    start = crystal(n, semi_axes, start_fraction, seed)
    longest = semi_axes.max() * np.cbrt(DENSEST / start.packing_fraction)
    check_growth("rate", rate, longest)
    check_growth("fluid_rate", fluid_rate, longest)
    stages: list[Run | Compress] = [Run(collisions_per_particle=melt)] if melt else []
    stages.append(Compress(((0.0, fluid_rate), (FLUID_PRESSURE, rate)), until_pressure=until_pressure))
    began = time.process_time()
    if output is None:
        simulation = Simulation(start, seed)
        for stage in stages:
            do_stage(simulation, stage, observers)
    else:
        config = Config(seed, Crystal(int(n), tuple(semi_axes.tolist()), start_fraction), tuple(stages),
                        Output(str(output), {"packing_fraction": 0.01, "pressure_factor": 2.0}), Elastic())
        simulation = run(config, overwrite=overwrite, observers=observers)
    seconds = time.process_time() - began
    system = simulation.system
    contacts = contacts_in(system, contact_gap)
    return Packing(system, simulation.packing_fraction, simulation.last_means.reduced_pressure, contacts.numbers, contacts.mean,
                   contacts.rattlers, simulation.nematic_order, simulation.collisions, seconds)


class Contacts(NamedTuple):
    """As in Packing: contact numbers (n,), their mean over the bodies that are held, rattlers (n,)."""

    numbers: np.ndarray
    mean: float
    rattlers: np.ndarray


def contacts_in(system, gap):
    """Which bodies touch, mu - 1 < gap, in a jammed state."""
    pairs = contact_pairs(system.positions, system.orientations, system.semi_axes, system.box, gap)
    return Contacts(contact_numbers(pairs, system.n), mean_contact_number(pairs, system.n), rattlers(pairs, system.n))


def closed_gap(until_pressure):
    """The gap below which contacts have closed, and near ones have not, in a compression that ended at this reduced pressure."""
    return min(WIDEST_GAP, CLOSED / until_pressure)
