"""Many flights at once give what each gives alone, bit for bit: every kind, every length of a batch, odd ones among the others."""

import os
import subprocess
import sys

import dense
import numpy as np
import pytest
from pairs import bodies, joined, meeting, single
from test_ccd_hard_flights import alike, crossing, equal, generic, growing, needle_and_sphere, needles, plates, scaled

import ccd
from ccd import Status
from ccd.flight_blocks import BLOCK

KINDS = [generic, growing, alike, needles, plates, equal, needle_and_sphere, scaled(1e-6), scaled(1e6), crossing]


def alone(a, b, t_max):
    found = [ccd.first_contact(*single(a, k), *single(b, k), (0, t_max)) for k in range(len(a))]
    return np.array([each.time for each in found]), np.array([each.status for each in found])


def compare(a, b, t_max=1.0):
    """-> the statuses, found equal."""
    time, status = ccd.batch.first_contact(bodies(a), bodies(b), t_max)
    expected_time, expected_status = alone(a, b, t_max)
    np.testing.assert_array_equal(status, expected_status)
    np.testing.assert_array_equal(time, expected_time)
    return status


@pytest.mark.parametrize("make", KINDS, ids=lambda make: make.__name__)
def test_every_kind_of_flight(make):
    status = compare(*make(np.random.default_rng(60), 450))
    assert len(set(status.tolist())) > 1


@pytest.mark.parametrize("depth", [1e-5, 1e-9])
def test_grazes(depth):
    a, b = meeting(np.random.default_rng(61), 12, (0.3, 3), growth=0.2)
    flights = [dense.graze(a, b, 1.0, np.full(12, sign * depth), rounds=8)[0] for sign in (1, -1)]
    status = compare(joined(a, a), joined(*flights))
    assert {Status.CONTACT, Status.NO_CONTACT} <= set(status.tolist())


@pytest.mark.parametrize("n", [0, 1, 7, 8, BLOCK - 1, BLOCK, BLOCK + 1, 2 * BLOCK + 9])
def test_a_batch_of_any_length(n):
    a, b = (flights.pick(slice(n)) for flights in generic(np.random.default_rng(62), 2 * BLOCK + 9)[:2])
    assert len(compare(a, b)) == n


def odd_flights():
    """40 pairs: spheres, specks inside a body that float64 cannot tell, concentric, flying apart, at rest, touching, spinning fast."""
    a, b = meeting(np.random.default_rng(63), 40, (0.3, 2))
    a.semi_axes[0:5], b.semi_axes[0:5] = 1, 0.5
    a.semi_axes[5:10], b.semi_axes[5:10] = (1e-40, 2e-40, 1e-40), (1, 2, 1)
    a.center[5:10], b.center[5:10], b.orientation[5:10], a.orientation[5:10] = 0, (0.1, 0.5, 0.3), (1, 0, 0, 0), (1, 0, 0, 0)
    a.center[10:15] = b.center[10:15]
    a.velocity[15:20] = b.velocity[15:20] - (b.center - a.center)[15:20]
    for flights in (a, b):
        flights.velocity[20:25] = flights.angular_velocity[20:25] = 0
        flights.semi_axes[25:30], flights.velocity[25:30] = 1, 0
        flights.angular_velocity[30:35] *= 30
        flights.semi_axes[35:40], flights.angular_velocity[35:40] = (0.2, 0.2, 2), 0
    a.center[25:30], b.center[25:30] = 0, (2, 0, 0)
    return a, b


@pytest.mark.parametrize("seed", range(4))
def test_odd_flights_do_not_disturb_each_other(seed):
    a, b = odd_flights()
    fair_a, fair_b = meeting(np.random.default_rng(64), 100)
    order = np.random.default_rng(seed).permutation(140)
    status = compare(joined(a, fair_a).pick(order), joined(b, fair_b).pick(order))
    assert set(status.tolist()) == set(Status)


def test_a_block_of_odd_flights_only():
    a, b = odd_flights()
    for part in (slice(5, 15), slice(15, 20), slice(25, 30)):
        compare(a.pick(part), b.pick(part))


RUN = """
import sys, numpy as np
from test_ccd_flight_blocks import fair_and_odd
np.save(sys.argv[1], fair_and_odd())
"""


def fair_and_odd():
    """Time and status of 30 fair flights and 40 odd ones."""
    fair, odd = meeting(np.random.default_rng(65), 30, growth=0.2), odd_flights()
    return np.array(ccd.batch.first_contact(*(bodies(joined(*flights)) for flights in zip(fair, odd))))


def found_elsewhere(folder, **environment):
    """The same in a process with other settings of the compiler."""
    path = folder / "found.npy"
    subprocess.run([sys.executable, "-c", RUN, str(path)], check=True,
                   env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))} | environment)
    return np.load(path)


def test_plain_python_gives_the_same_bits(tmp_path):
    np.testing.assert_array_equal(fair_and_odd(), found_elsewhere(tmp_path, NUMBA_DISABLE_JIT="1"))


@pytest.mark.validate
def test_every_index_is_inside_its_array(tmp_path):
    np.testing.assert_array_equal(fair_and_odd(), found_elsewhere(tmp_path, NUMBA_BOUNDSCHECK="1", EDMD_CACHE_DIR=str(tmp_path)))
