"""What a run is: the one schema of `edmd run` files, their checks in words, and the text with every default that a person starts from.

A config is TOML: a seed, a [system], a [rule] of collisions, one [[stage]] after another, an [output]. Each is a dataclass, below or in
edmd/rules; the annotation of a field holds its type, what it means, and the check of its value.
"""

import copy
import json
import tomllib
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, fields
from difflib import get_close_matches
from math import inf
from typing import Annotated, Any, get_type_hints

from ccd import checks
from ccd.annotations import AnyPath
from edmd.compression import JAMMED, PRESSURE, checked_rates
from edmd.initial import LATTICES
from edmd.observers import Every, Logarithmic, Milestones
from edmd.rules.kinds import RULES
from edmd.rules.rule import Rule

Check = Callable[[str, Any], Any]


def _number(what, above=-inf, at_least=-inf, below=inf, at_most=inf) -> Check:
    def check(name, value):
        if not isinstance(value, int | float) or isinstance(value, bool):
            raise ValueError(f"{name} = {as_toml(value)}: expected {what}")
        return checks.real_number(name, value, what, above, at_least, below, at_most)
    return check


def whole_number(what, at_least=0) -> Check:
    def check(name, value):
        if not isinstance(value, int) or isinstance(value, bool) or value < at_least:
            raise ValueError(f"{name} = {as_toml(value)}: expected {what}")
        return value
    return check


def _one_of(*choices) -> Check:
    def check(name, value):
        if not any(value is choice or (value == choice and type(value) is type(choice)) for choice in choices):
            raise ValueError(f"{name} = {as_toml(value)}: expected one of {', '.join(map(as_toml, choices))}{nearest(value, choices)}")
        return value
    return check


def _list_of(check_one, length, what) -> Check:
    def check(name, value):
        if not isinstance(value, list | tuple) or not value or (length and len(value) != length):
            raise ValueError(f"{name} = {as_toml(value)}: expected {what}")
        return tuple(check_one(f"{name}[{i}]", one) for i, one in enumerate(value))
    return check


def text_value(what) -> Check:
    def check(name, value):
        if not isinstance(value, str) or not value:
            raise ValueError(f"{name} = {as_toml(value)}: expected {what}")
        return value
    return check


def _bodies(name, value):
    count = whole_number("a whole number of bodies, or one number a species", 1)
    return _list_of(count, None, "numbers of bodies")(name, value) if isinstance(value, list | tuple) else count(name, value)


def _rows(name, value):
    rows = isinstance(value, list | tuple) and value and isinstance(value[0], list | tuple)
    return (_list_of(_axes, None, "one row of three lengths a species") if rows else _axes)(name, value)


def _rates(name, value):
    if isinstance(value, list | tuple):
        return checked_rates(name, value)
    return checked_rates(name, _number("a growth rate, not zero")(name, value))[0][1]


def _frames(name, value):
    if not isinstance(value, dict):
        raise ValueError(f"{name} = {as_toml(value)}: expected a table such as {{time = 1.0}}")
    kinds = {Logarithmic: (*UNITS, "per_decade"), Milestones: ("packing_fraction", "pressure_factor"), Every: UNITS}
    only_known(name, value, [*kinds[Logarithmic], *kinds[Milestones]])
    kind = Logarithmic if "per_decade" in value else Milestones if set(value) & set(kinds[Milestones]) else Every
    try:
        only_known(name, value, kinds[kind])
        kind(**{key: _number("a number")(key, one) for key, one in value.items()})
    except ValueError as problem:
        raise ValueError(f"{name}: {problem}; expected one of {', '.join(UNITS)} (with per_decade: logarithmic), or packing_fraction and "
                         "pressure_factor (milestones)") from None
    return dict(value)


UNITS = ("time", "collisions", "collisions_per_particle")
_axes = _list_of(_number("a positive length", above=0), 3, "three positive lengths")
_positive = _number("a positive number", above=0)
_fraction = _number("a number between 0 and 1", above=0, below=1)
_switch = _one_of(True, False)
_Axes = Annotated[tuple, "semi-axes at the start", _axes]
_Fraction = Annotated[float, "share of the cell that the bodies fill", _fraction]
_Masses = Annotated[float, "mass of a body", _positive]
_Inertia = Annotated[str, 'moments of inertia: "solid" (uniform density) or "sphere" (of the sphere of equal volume)',
                     _one_of("solid", "sphere")]
_Temperature = Annotated[float, "kT of the velocities, which the seed draws", _positive]
_Frames = Annotated[dict | None, "frames of this stage, as in [output], which holds where none are given", _frames]


@dataclass(frozen=True)
class Lattice:
    """a crystal of parallel bodies, built by ASE"""

    kind = "lattice"
    lattice: Annotated[str, ", ".join(LATTICES), _one_of(*LATTICES)] = "fcc"
    cells: Annotated[tuple, "unit cells in each direction", _list_of(whole_number("a positive whole number", 1), 3, "three whole numbers")
                     ] = (4, 4, 4)
    semi_axes: _Axes = (1.25, 1.0, 0.8)
    packing_fraction: _Fraction = 0.3
    stretched: Annotated[bool, "map the lattice of touching spheres with the shape, so that it holds more", _switch] = False
    masses: _Masses = 1.0
    inertia: _Inertia = "solid"
    temperature: _Temperature = 1.0


@dataclass(frozen=True)
class Crystal:
    """parallel bodies on an fcc lattice, surplus sites empty: what `edmd pack` melts"""

    kind = "crystal"
    n: Annotated[int, "number of bodies", whole_number("a whole number of bodies", 1)] = 256
    semi_axes: _Axes = (1.25, 1.0, 0.8)
    start_fraction: Annotated[float | None, "share of the cell that the bodies fill (default: 0.3, or less for shapes that do not fit)",
                              _fraction] = None


@dataclass(frozen=True)
class Random:
    """bodies at random, without overlap"""

    kind = "random"
    n: Annotated[int | tuple, "number of bodies; [n1, n2, ...]: of every species of a mixture", _bodies] = 256
    semi_axes: Annotated[tuple, "three lengths; [[a, b, c], ...]: one row a species", _rows] = (1.25, 1.0, 0.8)
    packing_fraction: _Fraction = 0.3
    masses: _Masses = 1.0
    inertia: _Inertia = "solid"
    temperature: _Temperature = 1.0


@dataclass(frozen=True)
class File:
    """a frame of another run"""

    kind = "file"
    file: Annotated[str, "H5MD file written by edmd", text_value("the name of a file")] = "start.h5md"
    frame: Annotated[int, "which frame; negative counts from the end", whole_number("a whole number", -inf)] = -1
    temperature: Annotated[float | None, "draw velocities anew, at this kT (default: those of the frame)", _positive] = None


@dataclass(frozen=True)
class Run:
    """go on at constant volume and energy; exactly one of time, collisions, collisions_per_particle"""

    kind = "run"
    time: Annotated[float | None, "length in time", _positive] = None
    collisions: Annotated[float | None, "length in collisions", _positive] = None
    collisions_per_particle: Annotated[float | None, "length in collisions per particle: 2 collisions / n", _positive] = None
    frames: _Frames = None

    one_of = UNITS


@dataclass(frozen=True)
class Compress:
    """let all semi-axes grow (or shrink) at kT = 1; exactly one of until_packing_fraction, until_pressure"""

    kind = "compress"
    rate: Annotated[float | tuple, "the semi-axes grow as 1 + rate t; negative: they shrink; [[0, 1e-2], [100, 1e-3]]: 1e-3 from a reduced "
                                   "pressure of 100 on", _rates] = 1e-2
    until_packing_fraction: Annotated[float | None, "end there, exactly", _fraction] = None
    until_pressure: Annotated[float | None, "end at this reduced pressure P V / (n kT), at most 1e12; 1e8: jammed",
                              _number(PRESSURE, above=1, at_most=JAMMED)] = None
    frames: _Frames = None

    one_of = ("until_packing_fraction", "until_pressure")


@dataclass(frozen=True)
class Output:
    """what is written, and how often"""

    file: Annotated[str, "H5MD file of the run", text_value("the name of a file")] = "run.h5md"
    frames: Annotated[dict, "a frame every so much; or {time = 0.01, per_decade = 10}, {packing_fraction = 0.01, pressure_factor = 2.0}",
                      _frames
                      ] = field(default_factory=lambda: {"collisions_per_particle": 10.0})
    checkpoint: Annotated[float, "seconds of wall time between two checkpoints", _positive] = 60.0
    log: Annotated[bool, "write NAME.log.jsonl beside the file, one JSON line at most every second", _switch] = True


@dataclass(frozen=True)
class Config:
    """A whole run, checked."""

    seed: int
    system: Lattice | Crystal | Random | File
    stages: tuple
    output: Output
    rule: Rule

    def document(self):
        """The config as TOML or JSON hold it, with every default in its place."""
        return {"seed": self.seed, "system": _document(self.system), "rule": self.rule.document(),
                "stage": [_document(stage) for stage in self.stages], "output": _document(self.output)}


SYSTEMS = {kind.kind: kind for kind in (Lattice, Crystal, Random, File)}
STAGES = {kind.kind: kind for kind in (Run, Compress)}
_seed = whole_number("a whole number from 0 on")
SECTIONS = ("seed", "system", "rule", "stage", "output")
DEFAULT = {"stage": [{"kind": "run", "collisions_per_particle": 100.0}, {"kind": "compress", "until_packing_fraction": 0.5},
                     {"kind": "run", "collisions_per_particle": 100.0}]}


ConfigSource = AnyPath | dict[str, Any] | Config


def read_config(source: ConfigSource, overrides: Iterable[str] = ()) -> Config:
    """The Config of a TOML file (its path), of a document (a dict as `tomllib` gives it) or of a Config, with overrides such as
    "system.n=500" or "stage.0.rate=1e-3" (stages count from 0). ValueError says what is wrong, and what would be accepted."""
    document = document_of(source)
    for override in overrides:
        put(document, *key_and_value(override))
    return _checked(document)


def document_of(source):
    """What `read_config` takes as a document of its own, not checked yet."""
    if isinstance(source, Config):
        return source.document()
    return copy.deepcopy(source) if isinstance(source, dict) else read_toml(source)


def put(document, path, value):
    """Set a value in a document at a path of keys joined by dots; numbers count in lists, from 0."""
    keys, place = path.split("."), document
    for i, key in enumerate(keys):
        if isinstance(place, list):
            if not key.isdigit() or int(key) >= len(place):
                raise ValueError(f"{path}={as_toml(value)}: expected a number from 0 to {len(place) - 1} in place of {key!r}")
            key = int(key)
        elif not isinstance(place, dict):
            raise ValueError(f"{path}={as_toml(value)}: {'.'.join(keys[:i])} is a value and has no {key!r}")
        if i == len(keys) - 1:
            place[key] = value
        else:
            place = place[key] if isinstance(place, list) else place.setdefault(key, {})


def config_text(document: ConfigSource = DEFAULT, others: bool = True) -> str:
    """A config as TOML that can be run, with every key, its value and what it means; comments: what is off, and `others`, other kinds."""
    config = read_config(document)
    parts = [f"{f'seed = {config.seed}':<41} # of everything that is drawn at random"]
    parts.append("\n".join(["[system]", *_kind_lines(config.system)]))
    if others:
        parts += _alternatives("system", SYSTEMS, config.system)
    parts.append("\n".join(["[rule]", *_kind_lines(config.rule)]))
    if others:
        parts += _alternatives("rule", RULES, config.rule)
    parts += ["\n".join(["[[stage]]", *_kind_lines(stage)]) for stage in config.stages]
    parts.append("\n".join(["[output]", *_lines(config.output)]))
    return "\n\n".join(parts) + "\n"


def read_toml(path, name="config", shown="edmd run --print-config shows one"):
    """The document in a file. ValueError names the argument, and where such a file is shown."""
    try:
        with open(path, "rb") as file:
            return tomllib.load(file)
    except OSError as problem:
        raise ValueError(f"{name} = {str(path)!r}: {problem.strerror}; expected a TOML file ({shown})") from None
    except ValueError as problem:               # TOML that is none, text that is none
        raise ValueError(f"{name} = {str(path)!r}: not TOML: {problem}") from None


def key_and_value(override):
    """KEY=VALUE, as the command line takes it, as a path of keys and a value."""
    path, equals, text = override.partition("=")
    path = path.strip()
    if not equals or not all(path.split(".")):
        raise ValueError(f"{override!r}: expected KEY=VALUE, such as system.n=500")
    try:
        return path, tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return path, text.strip()               # a word without its quotation marks


def _checked(document):
    only_known("", document, SECTIONS)
    stages = document.get("stage", [])
    if not isinstance(stages, list) or not stages:
        raise ValueError("stage: expected at least one [[stage]], such as kind = \"run\", time = 10.0")
    return Config(_seed("seed", document.get("seed", 0)), _of_kind("system", document.get("system", {}), SYSTEMS, "lattice"),
                  tuple(_of_kind(f"stage.{i}", stage, STAGES, None) for i, stage in enumerate(stages)),
                  checked_section("output", document.get("output", {}), Output),
                  _of_kind("rule", document.get("rule", {}), RULES, "elastic"))


def _of_kind(name, table, kinds, default):
    if not isinstance(table, dict):
        raise ValueError(f"{name} = {as_toml(table)}: expected a table with a kind: {', '.join(map(as_toml, kinds))}")
    kind = _one_of(*kinds)(f"{name}.kind", table.get("kind", default))
    return checked_section(name, {key: value for key, value in table.items() if key != "kind"}, kinds[kind])


def checked_section(name, table, section):
    """A table as the dataclass that holds such a section, whose annotations check its values."""
    if not isinstance(table, dict):
        raise ValueError(f"{name} = {as_toml(table)}: expected a table")
    options, prefix = _options(section), f"{name}." if name else ""
    only_known(name, table, options, section)
    chosen = getattr(section, "one_of", ())
    if chosen and sum(table.get(key) is not None for key in chosen) != 1:
        raise ValueError(f"{name or 'the file'}: expected exactly one of {', '.join(chosen)}")
    optional = {item.name for item in fields(section) if item.default is None}
    return section(**{key: None if value is None and key in optional else options[key].__metadata__[1](f"{prefix}{key}", value)
                      for key, value in table.items()})


def _options(section):
    return get_type_hints(section, include_extras=True)


def only_known(name, table, known, section=None):
    for key in table:
        if key not in known:
            what = f" with kind = {as_toml(section.kind)}" if hasattr(section, "kind") else ""
            raise ValueError(f"{name + '.' if name else ''}{key}: no such key{what}{nearest(key, known)}; expected {', '.join(known)}")


def nearest(word, known):
    close = get_close_matches(str(word), [str(one) for one in known], 1)
    return f" (did you mean {close[0]}?)" if close else ""


def _document(section):
    kind = {"kind": section.kind} if hasattr(section, "kind") else {}
    return kind | {item.name: getattr(section, item.name) for item in fields(section)}


def _alternatives(name, kinds, chosen):
    """The sections of all other kinds, as comments."""
    return ["\n".join(["# " + line for line in [f"or:  [{name}]", *_kind_lines(kind())]]) for kind in kinds.values()
            if not isinstance(chosen, kind)]


def _kind_lines(section):
    return _lines(section, {f"kind = {as_toml(section.kind)}": type(section).__doc__})


def _lines(section, first=()):
    lines = dict(first)
    for key, hint in _options(type(section)).items():
        value = getattr(section, key)
        lines[f"{key} = {as_toml(value)}" if value is not None else f"# {key} = ..."] = hint.__metadata__[0]
    return [f"{line:<41} # {about}" for line, about in lines.items()]


def as_toml(value):
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {as_toml(one)}" for key, one in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(as_toml, value)) + "]"
    return json.dumps(value, default=str)
