"""A run from its config: start, stages, files; going on after an interruption; the same run again from its file."""

from __future__ import annotations

import hashlib
import json
import signal
import threading
from collections.abc import Iterable
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from ccd.annotations import AnyPath
from edmd.averages import Interval
from edmd.checkpoint import Checkpoint, read_checkpoint
from edmd.compression import checked_packing_fraction, checked_rates
from edmd.config import UNITS, read_config
from edmd.initial import crystal, lattice, random_system
from edmd.journal import put_back
from edmd.observers import Every, Logarithmic, Milestones, View
from edmd.outputs import check_output
from edmd.progress import Log, Progress
from edmd.rules.elastic import Elastic
from edmd.rules.rough import Rough
from edmd.simulation import Simulation
from edmd.system import PER_BODY
from edmd.trajectory import Trajectory, open_run, read_system
from edmd.velocities import thermalized

if TYPE_CHECKING:
    from edmd.config import ConfigSource
    from edmd.observers import Observer


class RunFailed(RuntimeError):
    """A run that could not be done as its config says; what was written until then is kept."""


class RunComplete(ValueError):
    """A run that is to be resumed and has come to its end already: nothing is left to do, and nothing was touched."""


def run(config: ConfigSource, overrides: Iterable[str] = (), output: AnyPath | None = None, overwrite: bool = False,
        observers: Iterable[Observer] = (), progress: bool = False, start_digest: str | None = None) -> Simulation:
    """Do what a config says, and write the file it names. -> the Simulation at its end.

    config: path of a TOML file, a document (dict) or a Config; overrides: "KEY=VALUE", see `config.read_config`.
    output: the H5MD file, instead of that of the config; refused when it exists unless overwrite is true. observers: more of them.
    start_digest: of the start that is expected (`rebuilt`). ValueError, before anything is written, says what cannot be.
    A run that is interrupted (Ctrl-C: KeyboardInterrupt; SIGTERM; a crash; a full disk) is continued by `resume`.
    """
    config = read_config(config, overrides)
    path = check_output(output or config.output.file, overwrite)
    for beside in (checkpoint_path(path), log_path(path)):
        check_output(beside, overwrite=True)
    simulation = Simulation(start(config), config.seed, rule=config.rule)
    _check_stages(simulation, config.stages)
    digest = _digest(simulation.system)
    if start_digest not in (None, digest):
        raise ValueError("the start of the run comes out different here (another platform, another version, or another start file): the "
                         "run cannot be repeated bit for bit; expected the surroundings that `edmd info` tells")
    put_back(path)                  # or somebody writes it
    for beside in (checkpoint_path(path), log_path(path)):
        beside.unlink(missing_ok=True)
    trajectory = Trajectory(path, schedule(config.stages[0].frames or config.output.frames), config.document(), overwrite, digest)
    return _do(simulation, config, trajectory, observers, progress)


def resume(path: AnyPath, observers: Iterable[Observer] = (), progress: bool = False) -> Simulation:
    """Go on with an interrupted run from its last checkpoint; frames after that are written again, the same bit for bit. -> the Simulation
    at its end. RunComplete, a ValueError, when the run had ended before: its last state is `read_system(path)`. ValueError when it is still
    going on or left no checkpoint. observers: more of them, started now."""
    config, _ = rebuilt(path)
    with open_run(path) as file:
        if file["edmd"].attrs["complete"]:
            raise RunComplete(f"path = {str(path)!r}: the run is complete; there is nothing to resume")
    if not checkpoint_path(path).exists():
        raise ValueError(f"path = {str(path)!r}: no checkpoint {str(checkpoint_path(path))!r}; repeat the run with edmd run --from")
    simulation, stage, memories = read_checkpoint(checkpoint_path(path))
    trajectory = Trajectory(path, schedule(config.stages[stage].frames or config.output.frames), overwrite=True)
    return _do(simulation, config, trajectory, observers, progress, stage, memories)


def rebuilt(path):
    """The Config that a file was written by, and the digest of its start. ValueError when it was not written by a run of a config."""
    with open_run(path) as file:
        own = dict(file["edmd"].attrs)
    if "start" not in own:
        raise ValueError(f"path = {str(path)!r}: not written by `edmd run`; its parameters are {own['parameters']}")
    return read_config(json.loads(own["parameters"])), own["start"]


def start(config):
    """The System with which a config starts."""
    system, spin = config.system, _spin(config.rule)
    if system.kind == "file":
        made = read_system(system.file, system.frame)
        return made if system.temperature is None else thermalized(made, config.seed, system.temperature, spin)
    if system.kind == "crystal":
        made = crystal(system.n, system.semi_axes, system.start_fraction, config.seed)
        return made if spin == "drawn" else thermalized(made, config.seed, spin=spin)
    if system.kind == "lattice":
        made = lattice(system.lattice, system.semi_axes, system.packing_fraction, system.cells, config.seed, system.stretched,
                       system.masses, system.inertia)
    else:
        made = random_system(system.n, system.semi_axes, system.packing_fraction, config.seed, system.masses, system.inertia)
    return made if system.temperature == 1.0 and spin == "drawn" else thermalized(made, config.seed, system.temperature, spin)


def _spin(rule):
    """What `thermalized` does with the spin of bodies of revolution and of spheres under this rule."""
    return "counted" if isinstance(rule, Rough) else "drawn" if isinstance(rule, Elastic) else "none"


def schedule(frames):
    """When frames are written: what `frames` in a config stands for."""
    return (Logarithmic if "per_decade" in frames else Every if set(frames) & set(UNITS) else Milestones)(**frames)


def checkpoint_path(path):
    """The checkpoint beside a file."""
    return Path(str(path).removesuffix(".h5md") + ".checkpoint.npz")


def log_path(path):
    """The log for machines beside a file."""
    return Path(str(path).removesuffix(".h5md") + ".log.jsonl")


def _do(simulation, config, trajectory, observers, progress, first=0, memories=None):
    """The stages from the first one on, where the memories say what its observers knew."""
    simulation.stall_path = str(trajectory.path).removesuffix(".h5md") + ".stalled.npz"
    log = [Log(log_path(trajectory.path))] if config.output.log else []
    kept = [trajectory, *log]
    checkpoint = Checkpoint(checkpoint_path(trajectory.path), config.output.checkpoint, simulation, kept, first)
    try:
        with trajectory, signals_to(checkpoint.stop):
            if memories is None:
                trajectory.start(View(simulation, Interval()))          # a checkpoint needs the file that it belongs to
            for observer, memory in zip(kept, memories or ()):
                observer.restore(memory)
            for number, stage in enumerate(config.stages[first:], first):
                if simulation.course is None:
                    checkpoint.before(number)
                for one in log:
                    one.stage = number
                shown = [Progress(label=f"stage {number} ({stage.kind})")] if progress else []
                try:
                    do_stage(simulation, stage, [*kept, *shown, *observers, checkpoint])
                except ValueError as problem:
                    raise RunFailed(f"stage.{number}: {problem}") from problem
                finally:
                    for bar in shown:
                        bar.close()
                if number + 1 < len(config.stages):
                    trajectory.when = schedule(config.stages[number + 1].frames or config.output.frames)
    except OSError as problem:
        again = (f"{trajectory.path} is kept as it was last whole, and edmd resume {trajectory.path} goes on from the last checkpoint"
                 if checkpoint.path.exists() else "nothing was done yet: start it anew, with --overwrite")
        raise RunFailed(f"{problem}; {again}") from problem
    finally:
        for one in log:
            one.close()
    checkpoint.path.unlink(missing_ok=True)
    return simulation


def do_stage(simulation, stage, observers=()):
    """One stage of a config, or the rest of it when the simulation was saved in its course."""
    if simulation.course is not None:
        simulation.resume(observers)
    elif stage.kind == "run":
        simulation.run(stage.time, stage.collisions, stage.collisions_per_particle, observers)
    else:
        simulation.compress(stage.rate, stage.until_pressure, stage.until_packing_fraction, observers)


def _check_stages(simulation, stages):
    """ValueError for what can be known before the first event: stages that lead nowhere."""
    fraction = simulation.packing_fraction
    for number, stage in enumerate(stages):
        name = f"stage.{number}"
        if simulation.energy == 0 and (stage.kind == "compress" or stage.time is None):
            raise ValueError(f"{name}: the bodies are at rest and never collide; expected system.temperature, or stages of kind \"run\" "
                             "with a time")
        if stage.kind == "run":
            continue
        goal = stage.until_packing_fraction
        if None not in (goal, fraction):
            try:
                checked_packing_fraction(goal, fraction, checked_rates("rate", stage.rate)[0][1])
            except ValueError as problem:
                raise ValueError(f"{name}.{problem}") from None
        fraction = goal


def _digest(system):
    """SHA-256 of a System: equal when it is the same bit for bit."""
    digest = hashlib.sha256(system.box.tobytes())
    for name in PER_BODY:
        digest.update(getattr(system, name).tobytes())
    return digest.hexdigest()


@contextmanager
def signals_to(stop):
    """Ctrl-C and SIGTERM end a run at the next moment where all is in order; a second one at once. Only the main thread hears signals."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def handle(number, frame):
        signal.signal(number, before[number])
        stop()

    before = {number: signal.signal(number, handle) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
