"""What a sweep tells while it is at work: a bar on a terminal, plain lines elsewhere, and a log for machines."""

import json
import sys
import time
from datetime import UTC, datetime
from pathlib import Path

LOG = "sweep.log.jsonl"
LINE_SECONDS = 10.0


class Account:
    """Counts the runs that end; a context manager. shown: whether a person wants to see it."""

    def __init__(self, directory, runs, done, shown):
        self._path, self._runs, self._done, self._failed = Path(directory) / LOG, runs, done, 0
        self._began, self._before, self._told = time.monotonic(), done, 0.0
        self._shown, self._bar = shown, None

    def __enter__(self):
        if self._shown and sys.stderr.isatty():
            from tqdm import tqdm

            self._bar = tqdm(total=self._runs, initial=self._done, unit="run", desc="sweep")
        return self

    def __exit__(self, *_):
        if self._bar is not None:
            self._bar.close()

    def say(self, text):
        if self._bar is not None:
            self._bar.write(f"edmd sweep: {text}", file=sys.stderr)
        elif self._shown:
            print(f"edmd sweep: {text}", file=sys.stderr, flush=True)

    def attempted(self, task, number, outcome, again):
        """An attempt at a run has ended; again: it is to be tried once more."""
        line = {"at": datetime.now(UTC).isoformat(timespec="milliseconds"), "run": Path(task["directory"]).name, "attempt": number,
                "status": outcome.status, "seconds": round(outcome.seconds, 3), "problem": outcome.problem}
        with open(self._path, "a") as file:
            file.write(json.dumps(line) + "\n")
        if outcome.status == "done":
            self._done += 1
            if self._bar is not None:
                self._bar.update()
            elif time.monotonic() - self._told > LINE_SECONDS or self._done == self._runs:
                self._told = time.monotonic()
                left = (self._told - self._began) / (self._done - self._before) * (self._runs - self._done - self._failed)
                self.say(f"{self._done} of {self._runs} runs done" + (f", about {left:.0f} s left" if left > 0 else ""))
        else:
            self._failed += not again
            self.say(f"run {line['run']}: attempt {number} {outcome.status}: {outcome.problem}{'; tried again' if again else ''}")
