"""Thermal velocities."""

from __future__ import annotations

from math import sqrt

import numpy as np

from ccd import checks
from ccd.precession import SPHERE, symmetry_axes
from ccd.quaternions import to_lab
from edmd.inertia import temperature_of
from edmd.system import System

SPINS = ("drawn", "none", "counted")


def thermalized(system: System, seed: int | np.random.Generator = 0, temperature: float = 1.0, spin: str = "drawn") -> System:
    """A copy with velocities and angular velocities from the Maxwell distribution, no total momentum, and exactly this temperature (kT).

    spin: what smooth bodies never change, the spin of spheres and that of bodies of revolution about their axes, is "drawn" like the rest
    and does not count for the temperature; or "none", for gases that cool, where it would hold the axes like gyroscopes; or "counted", for
    rough bodies.
    """
    if spin not in SPINS:
        raise ValueError(f"spin = {spin!r}: expected one of {', '.join(map(repr, SPINS))}")
    temperature = checks.real_number("temperature", temperature, "a positive number (kT)", above=0)
    rng = np.random.default_rng(seed)
    system = system.copy()
    n, masses = system.n, system.masses[:, None]
    system.velocities = rng.normal(size=(n, 3)) * np.sqrt(temperature / masses)
    if n > 1:
        system.velocities -= (masses * system.velocities).sum(axis=0) / masses.sum()
    in_body = rng.normal(size=(n, 3)) * np.sqrt(temperature / system.moments)
    if spin == "none":
        kinds = symmetry_axes(system.semi_axes)
        in_body[(kinds[:, None] == np.arange(3)) | (kinds == SPHERE)[:, None]] = 0.0
    system.angular_velocities = to_lab(system.orientations, in_body)
    factor = sqrt(temperature / temperature_of(system, spin == "counted"))
    system.velocities *= factor
    system.angular_velocities *= factor
    return system
