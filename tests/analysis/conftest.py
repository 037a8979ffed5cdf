import sys
from pathlib import Path

import numpy as np
import pytest
from runs import random_quaternions, write_run

sys.path.insert(0, str(Path(__file__).parents[1] / "oracles"))


@pytest.fixture
def moving(tmp_path):
    """Five frames at unequal times in a cell that shears, with all that moves known: (path, arrays)."""
    rng = np.random.default_rng(3)
    n, times = 12, np.array([0.0, 0.25, 0.5, 1.5, 1.75])
    cells = np.array([[[6, 0, 0], [0.1 * k, 6, 0], [0.3, 0.2 * k, 7]] for k in range(5)], dtype=float)
    positions = rng.random((5, n, 3)) @ cells
    orientations = random_quaternions(rng, 5 * n).reshape(5, n, 4)
    semi_axes = np.array([1.0, 0.5, 0.4]) * (1 + 0.1 * times)[:, None, None] * np.ones((n, 1))
    path = write_run(tmp_path / "moving.h5md", positions, orientations, semi_axes, cells, times, species=np.arange(n) % 2)
    return path, {"positions": positions, "orientations": orientations, "semi_axes": semi_axes, "cells": cells, "times": times}
