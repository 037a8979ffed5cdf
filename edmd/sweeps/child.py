"""One run of a sweep, in a process and a directory of its own. The task comes through standard input; when that is closed, whoever wanted
the run has gone, and it ends at the next moment where all is in order."""

import importlib
import importlib.util
import json
import numbers
import os
import signal
import sys
import threading
import traceback
from pathlib import Path

from edmd.sweeps.results import FULL, RESULT, locked, write_result

DONE, FAILED, REFUSED, DISK_FULL, INTERRUPTED = 0, 1, 2, 3, 130
loading = False                 # a script is being read for its function


def main():
    line = sys.stdin.buffer.readline()
    if not line:
        return INTERRUPTED
    task = json.loads(line)
    threading.Thread(target=_end_with_input, daemon=True).start()
    directory = Path(task["directory"])
    try:
        with locked(directory / "lock", wait=True):
            if not (directory / RESULT).exists():
                result = _follow(task["config"], directory) if "config" in task else _numbers(_call(task, directory))
                write_result(directory, task["parameters"], task["seed"], result)
    except KeyboardInterrupt:
        return INTERRUPTED
    except Exception as problem:
        traceback.print_exc()
        print(*([] if "config" in task else [f"{type(problem).__name__}:"]), *str(problem).split(), flush=True)        # the words told
        causes = [problem, problem.__cause__]
        if any(isinstance(one, OSError) and one.errno in FULL for one in causes):
            return DISK_FULL
        certain = "config" in task and any(isinstance(one, ValueError) for one in causes)        # the same again, bit for bit
        return REFUSED if certain else FAILED
    return DONE


def _end_with_input():
    while os.read(sys.stdin.fileno(), 1):
        pass
    os.kill(os.getpid(), signal.SIGTERM)


def _follow(document, directory):
    """A run of a config, from its checkpoint where there is one. -> the numbers at its end."""
    from edmd.config import config_text, read_config
    from edmd.runs import checkpoint_path, resume, run

    path, config = directory / "run.h5md", read_config(document)
    (directory / "config.toml").write_text(config_text(document))
    simulation = None
    if path.exists() and checkpoint_path(path).exists():
        print("goes on from its checkpoint", flush=True)
        try:
            simulation = resume(path)
        except ValueError as problem:
            print(f"starts anew: {problem}", flush=True)
    if simulation is None:
        simulation = run(config, output=path, overwrite=True)
    last = config.stages[-1]
    means = simulation.means if last.kind == "run" else simulation.last_means
    result = {"packing_fraction": simulation.packing_fraction, "reduced_pressure": means.reduced_pressure}
    if getattr(last, "until_pressure", None) is not None:
        from edmd.packing import closed_gap, contacts_in

        contacts = contacts_in(simulation.system, closed_gap(last.until_pressure))
        result |= {"contact_number": contacts.mean, "rattlers": int(contacts.rattlers.sum())}
    result |= {"nematic_order": simulation.nematic_order, **means._asdict(), "time": simulation.time, "collisions": simulation.collisions}
    return _numbers(result)


def _call(task, directory):
    """What the function returns."""
    global loading
    sys.path.insert(0, task["path"])
    loading = True
    if task["module"]:
        module = importlib.import_module(task["module"])
    else:
        spec = importlib.util.spec_from_file_location(Path(task["file"]).stem, task["file"])
        module = sys.modules[spec.name] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    loading = False
    own = {"seed": task["seed"], "directory": directory}
    return getattr(module, task["function"])(**task["parameters"], **{name: own[name] for name in task["given"]})


def _numbers(result):
    if not isinstance(result, dict) or not result:
        raise TypeError(f"the function returned {result!r}: expected a dict of numbers")
    plain = {}
    for name, value in result.items():
        value = value.item() if getattr(value, "shape", None) == () else value
        if not isinstance(name, str) or not isinstance(value, numbers.Real):
            raise TypeError(f"the function returned {name!r}: {value!r}; expected a dict of numbers")
        plain[name] = value if isinstance(value, int) else float(value)
    return plain
