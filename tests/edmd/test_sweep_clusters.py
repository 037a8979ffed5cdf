"""A sweep on a Dask cluster, and through SLURM: the same table, whatever is killed on the way."""

import json
import os
import signal
import subprocess
import sys
import threading
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

import dask
import psutil
import pytest
import swept
from test_sweeps import CONFIG, HERE, command, logged, same_tables, under_way
from waiting import wait_for

import edmd
from edmd.sweeps.campaign import SweepStopped

pytestmark = pytest.mark.usefixtures("no_summary")

HERE = HERE | {"PYTHONPATH": os.pathsep.join([HERE["PYTHONPATH"], str(Path(swept.__file__).parent)])}
DASK = [sys.executable, "-m", "dask"]
GRID = {"width": [1, 2, 3, 4, 5, 6]}


@contextmanager
def started(*commands):
    """Processes that are ended, with all that they started, at the end."""
    processes = [subprocess.Popen([*DASK, *each], env=HERE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) for each in commands]
    try:
        yield processes
    finally:
        for process in processes:
            with_children = [*psutil.Process(process.pid).children(recursive=True), process] if process.poll() is None else []
            for one in with_children:
                one.kill()
            process.wait()


class Running(NamedTuple):
    """The address of a cluster, its scheduler, and what started its workers."""

    address: str
    scheduler: subprocess.Popen
    workers: subprocess.Popen


@contextmanager
def begun(folder):
    """A scheduler and two workers under their nannies."""
    file = folder / "scheduler.json"
    with started(["scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(file)],
                 ["worker", "--scheduler-file", str(file), "--nthreads", "1", "--nworkers", "2", "--no-dashboard",
                  "--local-directory", str(folder)]) as processes:
        wait_for(file.exists)
        yield Running(json.loads(file.read_text())["address"], *processes)


@pytest.fixture(scope="module")
def clusters(tmp_path_factory):
    """() -> the cluster that is there, which takes longer to start than a test takes; a new one if a test has killed it."""
    with ExitStack() as stack:
        running = []

        def one():
            if not running or running[-1].scheduler.poll() is not None:
                running.append(stack.enter_context(begun(tmp_path_factory.mktemp("cluster"))))
            return running[-1]

        yield one


@pytest.fixture
def cluster(clusters):
    return clusters()


@pytest.fixture(scope="module")
def at_once(tmp_path_factory):
    """The directory of the sweep on this machine."""
    directory = tmp_path_factory.mktemp("sweep") / "local"
    edmd.sweep(swept.slow, GRID, directory, workers=6)
    return directory


def in_the_middle(directory, act):
    """Do something to the processes of runs that are under way, when two others are done; -> the thread, and what it did."""
    done = []

    def under_way():
        over = {path.parent for path in directory.glob("runs/*/result.json")}
        found = []
        for path in directory.glob("runs/*/pid") if len(over) >= 2 else ():
            if path.parent not in over and (pid := path.read_text()):
                with suppress(psutil.NoSuchProcess):
                    found.append(psutil.Process(int(pid)))
        return found

    def watch():
        done.append(act(wait_for(under_way)))

    thread = threading.Thread(target=watch)
    thread.start()
    return thread, done


def test_interrupted(cluster, tmp_path):
    """Ctrl-C: the two runs under way on the cluster end after a last checkpoint, and the third is not begun."""
    directory, file = tmp_path / "sweep", tmp_path / "sweep.toml"
    file.write_text(CONFIG.format(directory=directory).replace("[0.02, 0.05]", "[0.0005, 0.0006, 0.0007]"))   # slow: two at a time
    process = command(str(file), "--scheduler", cluster.address)
    wait_for(lambda: len(under_way(directory)) == 2)
    children = [child for _, child in under_way(directory)]
    process.send_signal(signal.SIGINT)
    told = process.communicate()[1]
    assert process.returncode == 130
    assert not any(child.is_running() for child in children)
    assert "2 runs under way on 2 workers were ended" in told
    assert "interrupted; 0 of 3 runs are done, and the same command does the rest" in told
    assert "Traceback" not in told
    assert [len(list(directory.glob(f"runs/*/{name}"))) for name in ("run.checkpoint.npz", "run.h5md", "result.json")] == [2, 2, 0]
    assert len(list(directory.glob("runs/*"))) == 2


def test_a_worker_is_killed_and_then_the_scheduler(cluster, at_once, tmp_path):
    directory = tmp_path / "killed"

    def kill_a_worker(processes):
        """The Dask worker under whose hands a run is; not the run, which must end by itself."""
        worker = processes[0].parent()
        worker.kill()
        return worker.pid

    thread, done = in_the_middle(directory, kill_a_worker)
    edmd.sweep(swept.slow, GRID, directory, cluster.address)
    thread.join()
    assert done[0] not in (cluster.workers.pid, cluster.scheduler.pid, os.getpid())
    assert same_tables(at_once, directory)

    thread, _ = in_the_middle(tmp_path / "lost", lambda processes: cluster.scheduler.kill())
    with pytest.raises(SweepStopped, match=r"the cluster went away; [1-5] of 6 runs are done, and the same command does the rest"):
        edmd.sweep(swept.slow, GRID, tmp_path / "lost", cluster.address)
    thread.join()
    edmd.sweep(swept.slow, GRID, tmp_path / "lost")
    assert same_tables(at_once, tmp_path / "lost")


def test_no_cluster_at_this_address(tmp_path, monkeypatch):
    monkeypatch.setattr("edmd.sweeps.pools.CONNECT_SECONDS", 0.5)
    with pytest.raises(SweepStopped, match=r"no cluster answers there.*0 of 6 runs are done"):
        edmd.sweep(swept.slow, GRID, tmp_path / "sweep", "tcp://127.0.0.1:9")


SBATCH = """#!/bin/bash
# SLURM as dask-jobqueue sees it: a job is a script that runs in the background, in a session of its own.
script=JOBS.$$
cp "${@: -1}" $script
setsid bash $script > /dev/null 2>&1 < /dev/null &
echo $! >> JOBS
echo "Submitted batch job $!"
"""


def test_slurm(at_once, tmp_path, monkeypatch):
    """The commands of SLURM are replaced, its jobs are real processes; the job is killed in the middle, and another one submitted."""
    folder, directory = tmp_path / "bin", tmp_path / "sweep"
    folder.mkdir()
    for name, text in (("sbatch", SBATCH.replace("JOBS", str(tmp_path / "jobs"))), ("scancel", '#!/bin/bash\nkill -- "-$1"\n')):
        (folder / name).write_text(text)
        (folder / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{folder}:{os.environ['PATH']}")
    monkeypatch.setenv("PYTHONPATH", HERE["PYTHONPATH"])

    def kill_a_job(processes):
        os.killpg(int((tmp_path / "jobs").read_text().split()[0]), 9)

    thread, _ = in_the_middle(directory, kill_a_job)
    with dask.config.set({"distributed.deploy.lost-worker-timeout": "1s"}):
        edmd.sweep(swept.slow, GRID, directory, "slurm", workers=1, slurm={
            "walltime": "00:10:00", "memory": "1GB", "interface": "lo", "local_directory": str(tmp_path), "log_directory": str(tmp_path)})
    thread.join()
    assert same_tables(at_once, directory)
    assert len((tmp_path / "jobs").read_text().split()) >= 2
    assert {line["status"] for line in logged(directory)} <= {"done", "failed"}
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler            # dask_jobqueue would take it
