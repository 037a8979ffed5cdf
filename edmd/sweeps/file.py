"""A sweep from its TOML file: the schema of `edmd sweep` files, and the design that they hold."""

from dataclasses import dataclass, field
from typing import Annotated

from edmd.config import as_toml, checked_section, key_and_value, put, read_toml, text_value, whole_number
from edmd.sweeps.design import combined, points_of, random_points


def _table(name, value):
    if not isinstance(value, dict):
        raise ValueError(f"{name} = {as_toml(value)}: expected a table")
    return value


def _tables(name, value):
    if not isinstance(value, list) or not all(isinstance(one, dict) for one in value):
        raise ValueError(f"{name} = {as_toml(value)}: expected tables, [[{name}]]")
    return value


_positive = whole_number("a positive whole number", 1)
_natural = whole_number("a whole number from 0 on")
_name = text_value("a name")


@dataclass(frozen=True)
class SweepFile:
    """A sweep as its file says it (docs/sweeps.md)."""

    config: Annotated[str | None, "file of `edmd run` with what all runs share", _name] = None
    run: Annotated[dict | None, "the same, in place", _table] = None
    directory: Annotated[str, "of this sweep alone", _name] = "sweep"
    seed: Annotated[int, "from which all others derive", _natural] = 0
    replicas: Annotated[int, "runs at every point, each with a seed of its own", _positive] = 1
    retries: Annotated[int, "how often a run that failed is tried again", _natural] = 2
    scheduler: Annotated[str, "local, slurm, or the address of a Dask scheduler", _name] = "local"
    workers: Annotated[int | None, "processes, or SLURM jobs, at once", _positive] = None
    slurm: Annotated[dict | None, "options of dask_jobqueue.SLURMCluster", _table] = None
    grid: Annotated[dict, "lists of values, of which every combination is done", _table] = field(default_factory=dict)
    point: Annotated[list, "points, one after the other", _tables] = field(default_factory=list)
    random: Annotated[dict | None, "draws, and a range for each parameter", _table] = None
    plot: Annotated[dict | None, "x, a parameter, and y, results", _table] = None

    one_of = ("config", "run")

    def design(self):
        """Its points: each of [[point]] with every one of [grid] and every one that is drawn."""
        drawn = []
        if self.random is not None:
            ranges = {key: value for key, value in self.random.items() if key != "draws"}
            drawn = random_points(_leaves("random", ranges, _is_range), _positive("random.draws", self.random.get("draws")), self.seed)
        listed = points_of([_leaves(f"point.{i}", point) for i, point in enumerate(self.point)])
        return combined(listed, points_of(_leaves("grid", self.grid)), drawn)


def read_sweep(path, overrides=()):
    """The SweepFile at a path, with overrides such as "replicas=5". ValueError says what is wrong, and what would be accepted."""
    document = read_toml(path, "sweep", "docs/sweeps.md shows some")
    for override in overrides:
        put(document, *key_and_value(override))
    return checked_section("", document, SweepFile)


def _leaves(name, table, is_leaf=lambda value: False):
    """The values of nested tables under their keys joined by dots: in TOML, stage.0.rate without quotation marks is nested."""
    found = {}

    def walk(path, value):
        if not isinstance(value, dict) or not value or is_leaf(value):
            if path in found:
                raise ValueError(f"{name}.{path}: is named twice")
            found[path] = value
            return
        for key, one in value.items():
            walk(f"{path}.{key}" if path else key, one)

    for key, one in table.items():
        walk(key, one)
    return found


def _is_range(value):
    return not all(isinstance(one, dict) for one in value.values())
