"""The results of runs on disk: each there whole or not at all, and no two processes at work on the same one."""

import errno
import fcntl
import json
from contextlib import contextmanager
from pathlib import Path

from edmd.outputs import written_whole

LOCK, RUNS, RESULT = "sweep.lock", "runs", "result.json"
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


def result_of(directory, run):
    """The result of a run, a dict of numbers, or None while there is none."""
    path = Path(directory) / RUNS / run.name / RESULT
    if not path.exists():
        return None
    record = read_json(path)
    if record.get("parameters") != run.parameters or record.get("seed") != run.seed:
        raise ValueError(f"path = {str(path)!r}: the result of another run, with {record.get('parameters')} and seed {record.get('seed')}; "
                         f"expected {run.parameters} and seed {run.seed}, alone in its directory: delete it to do this run again")
    return record["result"]


def write_result(directory, parameters, seed, result):
    """Written when a run is done; its being there says so."""
    write_whole(Path(directory) / RESULT, json.dumps({"parameters": parameters, "seed": seed, "result": result}, indent=1).encode())


def write_whole(path, data):
    with written_whole(path) as partial:
        partial.write_bytes(data)


@contextmanager
def locked(path, wait):
    """Hold a lock while at work. When another process holds it: wait, or ValueError. Ends with the process, however that ends."""
    with open(path, "a") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
        except BlockingIOError:
            raise ValueError(f"directory = {str(path.parent)!r}: another sweep is at work there; expected it to end first") from None
        except OSError:                 # a network disk without locks
            pass
        yield


def read_json(path):
    try:
        return json.loads(path.read_bytes())
    except ValueError:
        raise ValueError(f"path = {str(path)!r}: not what a sweep wrote; expected JSON") from None
