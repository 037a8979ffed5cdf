"""The same run, compiled, as plain Python and with every index checked, gives the same bits."""

import os
import subprocess
import sys

import numpy as np
import pytest
from cross_section import some_of

import edmd

RUN = """
import sys, numpy as np, edmd
from test_compiled_and_plain import final_state
np.save(sys.argv[2], final_state(eval(sys.argv[1]), eval(sys.argv[3])))
"""

MIXTURE = ((1, 1, 1), (0.8, 0.8, 1.4), (1.25, 1, 0.8))


def grid_of(shapes):
    """64 bodies of several shapes, in turn, on a cubic grid, in motion."""
    rng, n = np.random.default_rng(5), 64
    places, axes = 2.9 * np.array(list(np.ndindex(4, 4, 4))), np.array(shapes)[np.arange(n) % len(shapes)]
    return edmd.System(places, [[1, 0, 0, 0]] * n, axes, 4 * 2.9, rng.normal(size=(n, 3)), rng.normal(size=(n, 3)))


def final_state(axes, rule=None):
    """Where all bodies are after a short run and a little growth, and how they move."""
    start = edmd.lattice("fcc", axes, 0.35, (2, 2, 2), seed=3) if np.ndim(axes) == 1 else grid_of(axes)
    simulation = edmd.Simulation(start, rule=rule)
    simulation.run(collisions=50)
    end = simulation.compress(0.05, until_packing_fraction=simulation.packing_fraction * 1.012).system
    return np.hstack([end.positions, end.orientations, end.velocities, end.angular_velocities])


def final_state_elsewhere(axes, folder, rule="None", **environment):
    """The same in a process with other settings of the compiler."""
    path = folder / "end.npy"
    subprocess.run([sys.executable, "-c", RUN, repr(axes), str(path), rule], check=True,
                   env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))} | environment)
    return np.load(path)


@pytest.mark.parametrize("axes", some_of([(1, 1, 1), (1, 1, 1.5), (1, 1, 0.6), (1.25, 1, 0.8), MIXTURE],
                                         [(1, 1, 1), (1.25, 1, 0.8), MIXTURE]))
def test_plain_python(axes, tmp_path):
    assert np.array_equal(final_state(axes), final_state_elsewhere(axes, tmp_path, NUMBA_DISABLE_JIT="1"))


@pytest.mark.parametrize("rule", ["edmd.Rough(0.9, 0.5, contact_share=0.02)", "edmd.PowerLaw(0.6)"])
def test_plain_python_under_a_rule(rule, tmp_path):
    assert np.array_equal(final_state((1, 1, 1.5), eval(rule)), final_state_elsewhere((1, 1, 1.5), tmp_path, rule, NUMBA_DISABLE_JIT="1"))


@pytest.mark.validate
@pytest.mark.parametrize("axes", [(1, 1, 1), (1, 1, 1.5), (1.25, 1, 0.8)])
def test_every_index_is_inside_its_array(axes, tmp_path):
    """In a cache of its own: numba takes compiled code from a cache whether its indices are checked or not."""
    checked = final_state_elsewhere(axes, tmp_path, NUMBA_BOUNDSCHECK="1", EDMD_CACHE_DIR=str(tmp_path))
    assert np.array_equal(final_state(axes), checked)
