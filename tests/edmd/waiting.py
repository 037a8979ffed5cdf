"""Tests of several processes wait for what another one does."""

import time


def wait_for(condition, seconds=30):
    """What the condition gives once it is true."""
    until = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < until, "it never came"
        time.sleep(0.01)
    return found
