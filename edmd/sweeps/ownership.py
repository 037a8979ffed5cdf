"""Whose a directory is: the sweep that made it, and the same sweep extended; no other one writes there."""

import json
import tempfile
from pathlib import Path

from edmd.config import as_toml
from edmd.sweeps.design import flat, named
from edmd.sweeps.results import LOCK, read_json, write_whole

FORMAT = 1
MANIFEST = "sweep.json"


def check_directory(directory):
    """ValueError, and nothing is touched, when this is no place for a sweep; else it is made, where there is none."""
    directory = Path(directory)
    name = f"directory = {str(directory)!r}"
    if directory.exists() and not directory.is_dir():
        raise ValueError(f"{name}: is a file; expected a directory, which is made where there is none")
    if directory.exists() and not (directory / MANIFEST).exists() and {path.name for path in directory.iterdir()} - {LOCK}:
        raise ValueError(f"{name}: holds files that are no sweep's; expected a new or empty directory")
    try:
        directory.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=directory):
            pass
    except OSError as problem:
        raise ValueError(f"{name}: cannot be written: {problem.strerror}") from None


def claim(directory, identity, seed, runs):
    """Make the directory that of this sweep, or see that it is. ValueError, and nothing is touched, when it is another one's."""
    manifest = Path(directory) / MANIFEST
    new = {"format": FORMAT, **identity, "seed": seed,
           "runs": {run.name: {"parameters": run.parameters, "replica": run.replica, "seed": run.seed} for run in runs}}
    new = json.loads(json.dumps(new))
    if manifest.exists():
        _check_same(directory, read_json(manifest), new)
    write_whole(manifest, json.dumps(new, indent=1).encode())


def _check_same(directory, old, new):
    name = f"directory = {str(directory)!r}"
    if not isinstance(old, dict) or not {"format", "seed", "runs"} <= old.keys():
        raise ValueError(f"{name}: its {MANIFEST} is not what a sweep wrote; expected a new or empty directory")
    if old["format"] > FORMAT:
        raise ValueError(f"{name}: its {MANIFEST} has format {old['format']}, newer than this version of edmd knows ({FORMAT})")
    before, now = ({key: flat(one.get(key)) for key in ("config", "function", "seed")} for one in (old, new))
    for part in before:
        for key in sorted(before[part].keys() | now[part].keys()):
            was, is_now = (as_toml(one[part][key]) if key in one[part] else "not given" for one in (before, now))
            if was != is_now:
                what = part if key == "" else f"{part}: {key}"
                raise ValueError(f"{name}: belongs to another sweep ({what} was {was} there and is {is_now} now); expected another "
                                 "directory, or the same sweep")
    dropped = [run for run in old["runs"] if run not in new["runs"]]
    if dropped:
        raise ValueError(f"{name}: belongs to another sweep, {len(dropped)} of whose {len(old['runs'])} runs this design has not, such as "
                         f"{named(old['runs'][dropped[0]]['parameters'])} (replica {old['runs'][dropped[0]]['replica']}); expected a "
                         "design that contains them all, or another directory")
