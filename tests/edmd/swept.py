"""Functions that the tests sweep, each in a process of its own, which imports them from here."""

import os
import signal
import time


def area(width, height=2.0, seed=0):
    return {"area": width * height, "noise": seed % 1000 / 1000}


def counted(width, seed, directory):
    """Leaves a trace of every time that it is called."""
    with open(directory.parent / "calls.txt", "a") as calls:
        calls.write(f"{width}\n")
    return area(width, seed=seed)


def slow(width, seed, directory):
    """Takes its time, and says who it is."""
    (directory / "pid").write_text(str(os.getpid()))
    time.sleep(0.4)
    return area(width, seed=seed)


def killed(width, seed, directory):
    """Is killed twice before it comes to an end, at every width above 1."""
    before = len(list(directory.glob("try*")))
    if width > 1 and before < 2:
        (directory / f"try{before}").touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return area(width, seed=seed)


def fails(width, seed):
    if width == 2:
        raise RuntimeError("no width of two")
    return area(width, seed=seed)


def answers(width):
    return {"text": "long"} if width == 1 else [width]
