"""Frames spread over processes by MDAnalysis give what they give one after the other, to the last bit."""

import inspect
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack, nullcontext
from functools import cache

import MDAnalysis as mda
import numpy as np
import pytest

import analysis
from analysis.frames import FrameAnalysis

ARGUMENTS = {"StructureFactor": {"k_max": 4.0}, "CubaticOrder": {"all_axes": True}, "RadialDistribution": {"r_max": 2.5},
             "OrientationalPairCorrelation": {"r_max": 2.5}, "CylindricalDistribution": {"r_max": 1.5},
             "FreeVolumes": {"directions": 20}, "SteinhardtOrder": {"neighbors": 1}}
CLASSES = {name: value for name, value in vars(analysis).items() if inspect.isclass(value) and issubclass(value, FrameAnalysis)}


def test_all_are_here():
    assert set(ARGUMENTS) < set(CLASSES) == {
        "BiaxialOrder", "ContactNumbers", "CubaticOrder", "CylindricalDistribution", "FreeVolumes", "MeanSquaredDisplacement",
        "NearContacts", "NematicOrder", "OrientationalCorrelation", "OrientationalPairCorrelation", "RadialDistribution", "SteinhardtOrder",
        "StructureFactor"}


@pytest.fixture(scope="module")
def begun():
    """Fresh processes as the first analysis begins them, which stay for the next one: they take seconds to start."""
    with ExitStack() as stack:
        pool = cache(lambda *arguments: stack.enter_context(ProcessPoolExecutor(*arguments)))
        yield lambda *arguments: nullcontext(pool(*arguments))


BY_DASK = ("NearContacts",)         # in the suite; the others by multiprocessing, all by both behind the marker `validate`


@pytest.mark.parametrize(("name", "backend"), [
    pytest.param(name, backend, marks=() if (backend == "dask") == (name in BY_DASK) else pytest.mark.validate)
    for name in CLASSES for backend in ("multiprocessing", "dask")])
def test_two_processes_give_the_same(moving, begun, monkeypatch, name, backend):
    monkeypatch.setattr("analysis.frames.ProcessPoolExecutor", begun)
    if name == "SteinhardtOrder":
        pytest.importorskip("freud")
    atoms = mda.Universe(moving[0]).select_atoms("species 0 1")
    analysis.ContactNumbers(atoms).run(stop=1)                  # its threads are there when the process forks
    found = [CLASSES[name](atoms, **ARGUMENTS.get(name, {})).run(**options).results
             for options in ({}, {"backend": backend, "n_workers": 2})]
    assert set(found[0]) == set(found[1]) != set()
    rounding = 1e-6 if name == "SteinhardtOrder" else 0.0       # freud's threads add up in float32, in any order
    for key, value in found[0].items():
        np.testing.assert_allclose(found[1][key], value, rtol=rounding, atol=0, err_msg=key)


def test_only_the_frames_asked_for(moving):
    nematic = analysis.NematicOrder(mda.Universe(moving[0]).atoms).run(start=1, stop=5, step=2, backend="multiprocessing", n_workers=2)
    assert nematic.frames.tolist() == [1, 3]
    assert nematic.times.tolist() == [0.25, 1.5]
    assert nematic.results.director.shape == (2, 3)
