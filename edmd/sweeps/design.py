"""Which runs a sweep is made of: points from grids, lists and draws, their replicas, and for each a name and a seed that stay when the
design is extended."""

from __future__ import annotations

import hashlib
import json
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from ccd import checks
from edmd.config import as_toml, only_known

RANGES = {"uniform": "uniform = [low, high]", "log": "log = [low, high], both positive", "integer": "integer = [low, high], whole numbers",
          "choice": "choice = [...]"}
SEED_BITS = 53                  # what every program that reads the table can hold, float64 too


class Planned(NamedTuple):
    """One run of a sweep: the name of its directory, its parameters, which replica it is, its own seed."""

    name: str
    parameters: dict[str, Any]
    replica: int
    seed: int


def points_of(grid):
    """The points of a grid (a dict of lists: every combination) or of a list of points (dicts), as dicts that JSON can hold."""
    if isinstance(grid, dict):
        values = [_values(key, one) for key, one in grid.items()]
        return [dict(zip(grid, combination)) for combination in product(*values)]
    if not isinstance(grid, list | tuple) or not all(isinstance(point, dict) for point in grid):
        raise ValueError(f"grid = {grid!r}: expected a dict of lists of values, or a list of points, which are dicts")
    return [{key: plain(f"grid[{i}].{key}", value) for key, value in point.items()} for i, point in enumerate(grid)]


def random_points(ranges: dict[str, dict[str, Any]], draws: int, seed: int = 0) -> list[dict[str, Any]]:
    """Points drawn at random, for `sweep` to take as its grid. More draws with the same seed begin with the same points.

    ranges: a dict of {"uniform": [low, high]}, {"log": [low, high]} (uniform in the logarithm), {"integer": [low, high]} (both included) or
    {"choice": [...]}. -> a list of `draws` dicts.
    """
    if not isinstance(ranges, dict) or not ranges:
        raise ValueError(f"ranges = {ranges!r}: expected at least one key with its range, such as {{{RANGES['uniform']}}}")
    draws, seed = checks.natural_number("draws", draws), checks.natural_number("seed", seed)
    columns = {}
    for key, one in ranges.items():
        stream = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=_words(key)))
        columns[key] = _drawn(key, one, stream.random(draws))
    return [dict(zip(columns, point)) for point in zip(*columns.values())]


def combined(*designs):
    """Every point of a design with every one of the others; designs without points do not count."""
    taken = [design for design in designs if design]
    keys: list[set[str]] = [set().union(*design) for design in taken]
    for i, some in enumerate(keys):
        for others in keys[:i]:
            if some & others:
                raise ValueError(f"{min(some & others)}: is named twice; expected it in one of [grid], [[list]] and [random]")
    return [{key: value for part in parts for key, value in part.items()} for parts in product(*taken)]


def plan(points, replicas, seed):
    """The runs of these points. ValueError when two would be the same run."""
    seen: dict[bytes, int] = {}
    runs = []
    for number, point in enumerate(points):
        digest = hashlib.sha256(json.dumps(_canonical(point), sort_keys=True).encode()).digest()
        if digest in seen:
            raise ValueError(f"{named(point)}: comes twice, as points {seen[digest]} and {number}, and two runs cannot be in one "
                             "directory; expected every point once (replicas repeat it with other seeds)")
        seen[digest] = number
        words = np.frombuffer(digest, dtype="<u4").tolist()
        for replica in range(replicas):
            state = np.random.SeedSequence(seed, spawn_key=(replica, *words)).generate_state(1, np.uint64)[0]
            runs.append(Planned(f"{digest.hex()[:12]}-{replica}", point, replica, int(state) >> (64 - SEED_BITS)))
    return runs


def named(point):
    """A point in words."""
    return ", ".join(f"{key} = {as_toml(value)}" for key, value in point.items()) or "the only point"


def flat(value, name=""):
    """The numbers and texts in nested lists and tables, each under its keys joined by dots."""
    if not isinstance(value, dict | list) or not value:
        return {name: value}
    items = value.items() if isinstance(value, dict) else enumerate(value)
    return {path: one for key, item in items for path, one in flat(item, f"{name}.{key}" if name else str(key)).items()}


def _values(key, values):
    values = values.tolist() if isinstance(values, np.ndarray) else values
    if not isinstance(values, list | tuple | range) or not len(values):
        raise ValueError(f"grid.{key} = {values!r}: expected a list of values")
    return [plain(f"grid.{key}", value) for value in values]


def plain(name, value):
    """A value as JSON gives it back."""
    value = value.tolist() if isinstance(value, np.ndarray | np.generic) else value
    try:
        return json.loads(json.dumps(value))
    except (TypeError, ValueError):
        raise ValueError(f"{name} = {value!r}: expected numbers, text, true or false, and lists and tables of them") from None


def _drawn(key, one, u):
    """The values at u (draws,), uniform in [0, 1)."""
    name = f"random.{key}"
    if not isinstance(one, dict) or len(one) != 1:
        raise ValueError(f"{name} = {one!r}: expected one of {'; '.join(RANGES.values())}")
    only_known(name, one, RANGES)
    (kind, values), = one.items()
    if kind == "choice":
        choices = _values(f"{key}.choice", values)
        return [choices[i] for i in (u * len(choices)).astype(int)]
    low, high = checks.real_array(f"{name}.{kind}", values, (2,), "two numbers [low, high]").tolist()
    if low >= high or (kind == "log" and low <= 0) or (kind == "integer" and not (low.is_integer() and high.is_integer())):
        raise ValueError(f"{name}: {kind} = {values!r}: expected {RANGES[kind]}, low < high")
    if kind == "integer":
        return (int(low) + (u * (high - low + 1)).astype(int)).tolist()
    return (low * (high / low)**u if kind == "log" else low + (high - low) * u).tolist()


def _canonical(value):
    """Equal for values that are equal: 1 and 1.0 are the same number."""
    if isinstance(value, dict):
        return {key: _canonical(one) for key, one in value.items()}
    if isinstance(value, list):
        return [_canonical(one) for one in value]
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _words(text):
    return tuple(np.frombuffer(hashlib.sha256(text.encode()).digest(), dtype="<u4").tolist())
