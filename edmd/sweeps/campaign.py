"""A sweep from end to end: what is missing is done, tried again where it failed, and everything that is there becomes one table."""

from __future__ import annotations

import queue
import warnings
from pathlib import Path
from typing import NamedTuple

from ccd import checks
from ccd.annotations import Any, AnyPath, Array
from edmd.runs import signals_to
from edmd.sweeps import child
from edmd.sweeps.account import Account
from edmd.sweeps.design import named, plan, points_of
from edmd.sweeps.figure import draw_summary
from edmd.sweeps.ownership import check_directory, claim
from edmd.sweeps.pools import OUTPUT, ClusterLost, check_pool, pool
from edmd.sweeps.results import LOCK, RESULT, RUNS, locked, result_of, write_whole
from edmd.sweeps.subject import subject_of
from edmd.sweeps.table import flat_parameters, table_of, write_table

IDLE_SECONDS = 60.0             # without news, before the sweep says that it waits for a cluster without workers


class SweepStopped(RuntimeError):
    """A sweep that could not go on; what was done until then is kept, and the same call does the rest."""


def sweep(function_or_config: Any, grid: Any, directory: AnyPath, scheduler: str | None = None, workers: int | None = None,
          slurm: dict[str, Any] | None = None, seed: int = 0, replicas: int = 1, retries: int = 2, plot: dict[str, Any] | None = None,
          progress: bool = False) -> dict[str, Array]:
    """Do a run at every point of a design, each in a process, a directory and with a seed of its own; called again, what is missing.

    function_or_config: what `edmd.run` takes (path, document or Config), whose keys are then the parameters, or a function at the top of a
        module or script that takes the parameters, and `seed` and `directory` (a Path) if it names them, and returns a dict of numbers.
    grid: {parameter: values}, every combination; or a list of points {parameter: value}, such as `random_points` draws. Parameters of a
        config are keys joined by dots: "stage.0.rate".
    directory: of this sweep alone. It may be extended: more values, points, replicas; runs that are there keep their names and seeds.
    scheduler: "local" (default): processes on this machine; the address of a Dask scheduler, "tcp://host:8786"; "slurm", through
        dask-jobqueue with the options `slurm` of its SLURMCluster.
    workers: processes at once (default: all cores), or SLURM jobs at once (default 1); a Dask cluster has its own.
    seed, replicas: every point is done `replicas` times, with seeds that derive from `seed`, the point and the replica.
    retries: how often a run that was killed or failed is tried again, from its checkpoint where it has one.
    plot: {"x": parameter, "y": [results]} of the summary plot (default: the first that vary).
    progress: tell on standard error how it goes.

    -> the table, a dict of numpy arrays, one entry a run: run, replica, seed, status ("done", "failed"), parameters, results. It is written
    to table.csv (and table.parquet where pyarrow is installed), the plot to summary.png. Runs that failed are told in a RuntimeWarning.
    ValueError, before anything is written, says what cannot be. SweepStopped: the disk is full, the cluster has gone; nothing is lost.
    """
    swept = carry_out(function_or_config, grid, directory, scheduler, workers, slurm, seed, replicas, retries, plot, progress)
    if swept.failed:
        warnings.warn(failures_in_words(swept), RuntimeWarning, stacklevel=2)
    return swept.table


class Swept(NamedTuple):
    """What a sweep has come to: its table, the files that show it, the problems of the runs that failed {name: words}."""

    table: dict
    files: list
    failed: dict


def failures_in_words(swept):
    name, problem = next(iter(swept.failed.items()))
    return f"{len(swept.failed)} of {len(swept.table['run'])} runs failed, such as {name}: {problem}; {OUTPUT} in its directory says more"


def carry_out(function_or_config, grid, directory, scheduler, workers, slurm, seed, replicas, retries, plot, progress):
    """See `sweep`. -> Swept."""
    if child.loading:
        raise RuntimeError("sweep() was called while a run imports the script of its function; expected the call under "
                           "if __name__ == \"__main__\":")
    scheduler = "local" if scheduler is None else scheduler
    workers = None if workers is None else _positive("workers", workers)
    seed, replicas = checks.natural_number("seed", seed), _positive("replicas", replicas)
    retries = checks.natural_number("retries", retries)
    check_pool(scheduler, slurm)
    subject, runs = subject_of(function_or_config), plan(points_of(grid), replicas, seed)
    parameters = list(dict.fromkeys(name for run in runs for name in flat_parameters(run)))
    plot = _checked_plot(plot, parameters)
    directory = Path(directory).absolute()
    tasks = {run.name: _task(subject, run, directory) for run in runs}
    check_directory(directory)
    with locked(directory / LOCK, wait=False):
        claim(directory, subject.identity, seed, runs)
        results = {run.name: result_of(directory, run) for run in runs}
        todo = [task for name, task in tasks.items() if results[name] is None]
        failed: dict[str, str] = {}
        stopped = None
        with Account(directory, len(runs), len(runs) - len(todo), progress) as account:
            try:
                if todo:
                    _do(todo, retries, failed, account, scheduler, workers, slurm or {})
            except (KeyboardInterrupt, SweepStopped, ClusterLost) as problem:
                stopped = problem
            except OSError as problem:
                stopped = SweepStopped(f"the directory cannot be written: {problem}")
        results = {run.name: result_of(directory, run) for run in runs}
        table = table_of(runs, results, failed)
        try:
            files = write_table(directory, table)
            if stopped is None:
                files += draw_summary(directory, table, parameters, **plot)
        except OSError as problem:
            stopped = stopped or SweepStopped(f"the table could not be written: {problem}")
    if stopped is not None:
        done = sum(result is not None for result in results.values())
        words = f"{done} of {len(runs)} runs are done, and the same command does the rest"
        if isinstance(stopped, KeyboardInterrupt):
            raise KeyboardInterrupt(words) from None
        raise SweepStopped(f"{stopped}; {words}") from stopped
    return Swept(table, files, {run.name: failed[run.name] for run in runs if run.name in failed})


def _do(tasks, retries, failed, account, scheduler, workers, slurm):
    """Do these tasks; failed: filled with the problems of those that could not be done."""
    with signals_to(_interrupt), pool(scheduler, workers, slurm, account.say) as executor:
        try:
            _follow(executor, tasks, retries, failed, account)
        finally:
            executor.end()


def _follow(executor, tasks, retries, failed, account):
    finished: queue.SimpleQueue[Any] = queue.SimpleQueue()
    under_way: dict[Any, Any] = {}
    attempts: dict[Any, int] = {}

    def start(task):
        attempts[task["directory"]] = attempts.get(task["directory"], 0) + 1
        future = executor.submit(task)
        under_way[future] = task
        future.add_done_callback(finished.put)

    for task in tasks:
        start(task)
    while under_way:
        try:
            future = finished.get(timeout=IDLE_SECONDS)
        except queue.Empty:
            if executor.workers == 0:
                account.say("waits: the cluster has no workers now")
            continue
        task, outcome = under_way.pop(future), executor.outcome(future)
        number = attempts[task["directory"]]
        again = outcome.status in ("failed", "interrupted") and number <= retries
        account.attempted(task, number, outcome, again)
        if outcome.status == "disk full":
            raise SweepStopped(f"the disk is full: {outcome.problem}")
        if outcome.status == "done":
            _keep(task, outcome)
        elif again:
            start(task)
        else:
            failed[Path(task["directory"]).name] = outcome.problem


def _keep(task, outcome):
    """The result of a worker whose disk is not this one, or comes late."""
    path = Path(task["directory"]) / RESULT
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, outcome.record.encode())


def _task(subject, run, directory):
    try:
        own = subject.task(run)
    except ValueError as problem:
        raise ValueError(f"{problem} (at {named(run.parameters)})") from None
    return own | {"directory": str(directory / RUNS / run.name), "parameters": run.parameters, "seed": run.seed, "cwd": str(Path.cwd())}


def _checked_plot(plot, parameters):
    plot = plot or {}
    if not isinstance(plot, dict) or plot.keys() - {"x", "y"}:
        raise ValueError(f"plot = {plot!r}: expected x, a parameter, and y, a list of results")
    y = plot.get("y")
    if y is not None and not (isinstance(y, list | tuple) and y):
        raise ValueError(f"plot.y = {y!r}: expected a list of results")
    x = plot.get("x")
    if x is not None and x not in (*parameters, "replica"):
        raise ValueError(f"plot.x = {x!r}: expected a parameter of the sweep: {', '.join(parameters)}")
    return {"x": x, "y": y}


def _positive(name, value):
    if checks.natural_number(name, value) == 0:
        raise ValueError(f"{name} = 0: expected a positive whole number")
    return int(value)


def _interrupt():
    raise KeyboardInterrupt
