"""What a compression may be asked for: its rates, where it ends, in words."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ccd import checks
from ccd.annotations import ArrayLike

FASTEST = 2.0               # speed of a growing surface, in thermal speeds, beyond which compression has no physics
GIVE_UP = 1e10              # reduced pressure at which a compression to a packing fraction ends in vain
JAMMED = 1e12               # highest reduced pressure: gaps are then some 1e-12 of a body, positions known to 1e-16 of the cell
OPENED = 1e-12              # relative size that bodies which touch lose at once when they begin to shrink: contacts at no gap know no time
IDLE = 12                   # horizons after which an epoch of shrinking bodies ends without its collisions: their surfaces outrun them
PRESSURE = f"a reduced pressure above 1, at most {JAMMED:g}"
RATES = "a growth rate, not zero, or pairs of a reduced pressure and the positive rate from there on, the first from 0"


def checked_rates(name: str, rate: ArrayLike | Mapping[float, float]) -> tuple[tuple[float, float], ...]:
    """Pairs (reduced pressure, rate from there on) of a number, a mapping or pairs, as `Simulation.compress` takes them."""
    try:
        several = isinstance(rate, Mapping) or np.ndim(rate) > 0
    except ValueError:                                          # rows of different lengths
        several = True
    if not several:
        number = checks.real_number(name, rate, RATES)
        if number == 0:
            raise ValueError(f"{name} = {rate!r}: expected {RATES}")
        return ((0.0, number),)
    pairs = checks.real_array(name, [*rate.items()] if isinstance(rate, Mapping) else rate, (None, 2), RATES)
    pairs = pairs[np.argsort(pairs[:, 0], kind="stable")]
    pressures, rates = pairs.T
    if len(pairs) == 0 or not 0 <= pressures[0] <= 1 or (np.diff(pressures) == 0).any() or not (rates > 0).all():
        raise ValueError(f"{name} = {rate!r}: expected {RATES}")
    return tuple(map(tuple, pairs.tolist()))


def checked_pressure(until_pressure: float) -> float:
    """A reduced pressure at which a compression can end; ValueError in words."""
    return checks.real_number("until_pressure", until_pressure, PRESSURE, above=1, at_most=JAMMED)


def checked_packing_fraction(until_packing_fraction: float, now: float, rate: float) -> float:
    """A packing fraction to which this rate leads from that of now; ValueError in words."""
    goal = checks.real_number("until_packing_fraction", until_packing_fraction, "a number between 0 and 1", above=0, below=1)
    if (goal - now) * rate <= 0:
        raise ValueError(f"until_packing_fraction = {goal}: the packing fraction is {now:.6g} and rate = {rate} leads away from it; "
                         f"expected one {'above' if rate > 0 else 'below'} it, or a {'negative' if rate > 0 else 'positive'} rate")
    return goal


def check_growth(name: str, rate: float, longest: float) -> None:
    """ValueError when the surfaces of bodies with this longest semi-axis (times the root of the mass) would outrun the bodies at kT = 1."""
    if rate * longest > FASTEST:
        raise ValueError(f"{name} = {rate}: surfaces would move {rate * longest:.3g} times as fast as the bodies at kT = 1; expected at "
                         f"most {FASTEST / longest:.3g} for bodies of this size")
