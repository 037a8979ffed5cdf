"""When a run cannot go on: which bodies, why, what to do, and a file with the state."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ccd.annotations import AnyPath
from edmd.rules.elastic import Elastic

TOUCHING = 1e-9             # relative gap up to which bodies count as those that have collapsed
LISTED = 12                 # bodies named one by one
SPARING = 1e-3              # contact time to suggest, in thermal times


class Stalled(RuntimeError):
    """Events go on but time stands still, or nothing moves any more. bodies: their indices. path: the file with the state, or None; what
    `Simulation.load` makes of it stalls at its next event, and its `system` can start another simulation, with another rule."""

    def __init__(self, words: str, bodies: Sequence[int] = (), path: AnyPath | None = None) -> None:
        super().__init__(words)
        self.bodies, self.path = tuple(bodies), path


def at_rest(simulation):
    """The Stalled to raise when no body moves and the run waits for collisions."""
    return Stalled(f"after {simulation.collisions} collisions, at {simulation.time:.17g}, the bodies are at rest and never collide again; "
                   "expected a time instead of a number of collisions", range(simulation.n), _saved(simulation))


def time_stands_still(simulation, body):
    """The Stalled to raise when this body has event after event."""
    bodies, path = _in_touch(simulation.system, body), _saved(simulation)
    named = ", ".join(map(str, bodies[:LISTED])) + (f" and {len(bodies) - LISTED} more" if len(bodies) > LISTED else "")
    words = (f"time stands still at {simulation.time:.17g} after {simulation.collisions} collisions, at packing fraction "
             f"{simulation.packing_fraction:.12g}: body {body} has event after event; bodies in touch with it: {named}")
    rule = simulation.rule
    if not isinstance(rule, Elastic):
        words += ". Inelastic collapse: they collide ever faster and lose all relative velocity in no time. "
        words += ("Try a longer contact_time or contact_share" if rule.contact_time or rule.contact_share else "The TC model avoids it: "
                  f"{type(rule).__name__}(..., contact_share={SPARING:g}), or a contact_time")
    return Stalled(words + ("" if path is None else f". State: {path}"), bodies, path)


def _saved(simulation):
    try:
        simulation.save(simulation.stall_path)
    except (OSError, ValueError):           # a folder that cannot be written must not hide why the run has ended
        return None
    return simulation.stall_path


def _in_touch(system, body):
    """The bodies that touch this one, directly or over others, and itself."""
    first, second, f = system.contact_functions()
    near = np.sqrt(f) - 1 < TOUCHING
    found, frontier = {int(body)}, {int(body)}
    while frontier:
        beside = [*second[near & np.isin(first, list(frontier))], *first[near & np.isin(second, list(frontier))]]
        frontier = {int(other) for other in beside} - found
        found |= frontier
    return sorted(found)
