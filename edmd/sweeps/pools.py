"""Where the runs of a sweep are done: processes on this machine, a Dask cluster, SLURM. Each is an executor that is handed tasks."""

import asyncio
import json
import os
import signal
import subprocess
import sys
import threading
import time
import uuid
from concurrent.futures import CancelledError, ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import NamedTuple

from edmd.sweeps import child
from edmd.sweeps.results import FULL, RESULT

ROOT = Path(__file__).resolve().parents[2]
STATUS = {child.DONE: "done", child.REFUSED: "refused", child.DISK_FULL: "disk full", child.INTERRUPTED: "interrupted"}
ONE_THREAD = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
OUTPUT = "output.txt"
CONNECT_SECONDS = 30
END_SECONDS = 60                # for the last checkpoints of runs that are told to end
WALLTIME = "01:00:00"


class Outcome(NamedTuple):
    """How an attempt at a run ended: done, failed, refused (it would fail again), disk full, interrupted; the problem in words; wall
    time; what is in its result file."""

    status: str
    problem: str
    seconds: float
    record: str | None = None


class ClusterLost(RuntimeError):
    """A cluster that cannot be reached, any more or at all."""


class Children:
    """The processes under way, so that they can be told to end."""

    def __init__(self):
        self._lock, self._running, self._ending = threading.Lock(), set(), False

    def __len__(self):
        return len(self._running)

    def add(self, process):
        with self._lock:
            self._running.add(process)
            if self._ending:
                process.stdin.close()

    def remove(self, process):
        with self._lock:
            self._running.discard(process)

    def end(self):
        """Each ends at its next moment, after a last checkpoint."""
        with self._lock:
            self._ending = True
            for process in self._running:
                process.stdin.close()

    def kill(self):
        with self._lock:
            for process in self._running:
                process.kill()


def attempt(task, children=None):
    """Do a run, in a process of its own, where this is called: a thread of the sweep, or a worker of a cluster. -> Outcome."""
    began = time.monotonic()
    directory = Path(task["directory"])
    path = [str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]
    environment = {name: "1" for name in ONE_THREAD} | os.environ | {"PYTHONPATH": os.pathsep.join(path)}
    try:
        directory.mkdir(parents=True, exist_ok=True)
        with open(directory / OUTPUT, "ab") as output:
            process = subprocess.Popen([sys.executable, "-c", "import sys; from edmd.sweeps.child import main; sys.exit(main())"],
                                       stdin=subprocess.PIPE, stdout=output, stderr=subprocess.STDOUT, start_new_session=True,
                                       env=environment, cwd=task["cwd"] if os.path.isdir(task["cwd"]) else None)
        if children is not None:
            children.add(process)
        try:
            process.stdin.write(json.dumps(task).encode() + b"\n")
            process.stdin.flush()
        except (BrokenPipeError, ValueError):           # it ended at once, or was told to
            pass
        status = process.wait()
        if children is not None:
            children.remove(process)
        if status == child.DONE:
            return Outcome("done", "", time.monotonic() - began, (directory / RESULT).read_text())
        words = f"killed by signal {-status}" if status < 0 else _last_line(directory / OUTPUT)
    except OSError as problem:
        status, words = child.DISK_FULL if problem.errno in FULL else child.FAILED, str(problem)
    return Outcome(STATUS.get(status, "failed"), words, time.monotonic() - began)


def check_pool(scheduler, slurm):
    """ValueError when no pool has this name, or what it needs is not installed."""
    if scheduler == "local":
        return
    if not isinstance(scheduler, str) or not (scheduler == "slurm" or "://" in scheduler):
        raise ValueError(f"scheduler = {scheduler!r}: expected \"local\", \"slurm\", or the address of a Dask scheduler, such as "
                         "tcp://host:8786")
    _needed("dask_jobqueue" if scheduler == "slurm" else "distributed")
    if slurm is not None and not isinstance(slurm, dict):
        raise ValueError(f"slurm = {slurm!r}: expected a table of options of dask_jobqueue.SLURMCluster")
    if scheduler == "slurm":
        _lifetime((slurm or {}).get("walltime", WALLTIME))


@contextmanager
def pool(scheduler, workers, slurm, tell):
    """The executor that `scheduler` names."""
    if scheduler == "local":
        yield ThisMachine(workers or cores())
        return
    with ExitStack() as stack:
        if scheduler == "slurm":
            cluster = stack.enter_context(slurm_cluster(slurm))
            cluster.adapt(minimum_jobs=0, maximum_jobs=workers or 1)
            scheduler = cluster.scheduler_address
        distributed = _needed("distributed")
        tell(f"connects to the cluster at {scheduler}")
        try:
            client = stack.enter_context(distributed.Client(scheduler, timeout=CONNECT_SECONDS, set_as_default=False))
        except (OSError, TimeoutError, ValueError) as problem:
            raise ClusterLost(f"scheduler = {scheduler!r}: no cluster answers there ({problem}); expected the address of a Dask scheduler, "
                              "such as tcp://host:8786") from None
        yield Cluster(client, scheduler, tell)


class ThisMachine:
    """Threads that wait for processes: a process that is killed takes nothing with it."""

    def __init__(self, workers):
        self._threads, self._children = ThreadPoolExecutor(workers), Children()
        self.workers = workers

    def submit(self, task):
        return self._threads.submit(attempt, task, self._children)

    def outcome(self, future):
        return future.result()

    def end(self):
        """End what is under way, in order; a second Ctrl-C at once."""
        self._threads.shutdown(wait=False, cancel_futures=True)
        self._children.end()
        try:
            self._threads.shutdown(wait=True)
        except KeyboardInterrupt:
            self._children.kill()
            raise


UNDER_WAY: dict[str, Children] = {}             # in a worker of a cluster: the processes of each sweep


def attempt_there(sweep, task):
    """`attempt`, on a worker of a cluster."""
    return attempt(task, UNDER_WAY.setdefault(sweep, Children()))


async def end_there(sweep):
    """On a worker of a cluster: have the runs of a sweep end, and wait for them. -> how many there were."""
    children = UNDER_WAY.setdefault(sweep, Children())
    number, until = len(children), time.monotonic() + END_SECONDS
    children.end()
    while len(children) and time.monotonic() < until:
        await asyncio.sleep(0.05)
    return number


class Cluster:
    """A Dask cluster. When the sweep itself is killed, runs that are under way end there: who wants them again finds their results."""

    def __init__(self, client, address, tell):
        self._client, self._address, self._tell = client, address, tell
        self._executor, self._futures = client.get_executor(pure=False), []
        self._sweep = uuid.uuid4().hex

    @property
    def workers(self):
        try:
            return len(self._client.ncores())
        except OSError as problem:
            raise self._lost() from problem

    def submit(self, task):
        self._futures.append(self._executor.submit(attempt_there, self._sweep, task))
        return self._futures[-1]

    def outcome(self, future):
        try:
            return Outcome(*future.result())
        except CancelledError:
            raise self._lost() from None
        except Exception as problem:            # a worker that died again and again, or has no edmd
            return Outcome("failed", f"{type(problem).__name__}: {problem}".splitlines()[0], 0.0)

    def end(self):
        """Take back what waits, and end what is under way, in order; a second Ctrl-C does not wait for it."""
        waited = any(not future.done() for future in self._futures)
        self._executor.shutdown(wait=False)
        if waited:
            self._tell("takes back what waits on the cluster, and ends the runs under way there")
            try:
                ended = self._client.run(end_there, self._sweep, on_error="ignore")
            except (OSError, TimeoutError):             # it has gone, and took them with it
                return
            self._tell(f"{sum(ended.values())} runs under way on {len(ended)} workers were ended")

    def _lost(self):
        return ClusterLost(f"scheduler = {self._address!r}: the cluster went away")


def slurm_cluster(options):
    """A dask_jobqueue.SLURMCluster, whose workers end in good time before their jobs do."""
    jobqueue = _needed("dask_jobqueue")
    options = {"cores": 1, "processes": 1, "memory": "2GB", "walltime": WALLTIME} | options
    lifetime, margin = _lifetime(options["walltime"])
    options.setdefault("worker_extra_args", ["--lifetime", f"{lifetime}s", "--lifetime-stagger", f"{margin // 3}s"])
    try:
        return jobqueue.SLURMCluster(**options)
    except TypeError as problem:
        raise ValueError(f"slurm: {problem}; expected options of dask_jobqueue.SLURMCluster, such as queue, account, cores, memory, "
                         "walltime") from None


def cores():
    """The cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _lifetime(walltime):
    """Seconds after which a worker makes room for the next one, and those that are left of a walltime of [days-]hours:minutes:seconds."""
    days, _, clock = str(walltime).rpartition("-")
    parts = clock.split(":")
    if not all(part.isdigit() for part in [*parts, days or "0"]) or len(parts) != 3:
        raise ValueError(f"slurm.walltime = {walltime!r}: expected [days-]hours:minutes:seconds")
    hours, minutes, seconds = map(int, parts)
    whole = ((int(days or 0) * 24 + hours) * 60 + minutes) * 60 + seconds
    margin = min(whole // 10, 300)
    return whole - margin, margin


def _needed(name):
    """A module of the extra `sweep`. dask_jobqueue takes Ctrl-C for itself when it is imported: that is put back."""
    handler = signal.getsignal(signal.SIGINT)
    try:
        module = __import__(name)
        if signal.getsignal(signal.SIGINT) is not handler:
            signal.signal(signal.SIGINT, handler)
        return module
    except ImportError:
        raise ValueError(f"scheduler: {name.replace('_', '-')} is not installed; expected it from pip install 'edmd[sweep]' (this machine "
                         "alone needs nothing)") from None


def _last_line(path):
    """The last thing that a run said, which is why it failed."""
    lines = path.read_text(errors="replace").strip().splitlines()
    return lines[-1] if lines else "it said nothing"
