"""How kernels are compiled: what is left out of the machine code, and what stays."""

import os
import subprocess
import sys

import numba
import numpy as np
import pytest

from ccd.compiling import kernel, large_kernel


@kernel
def entry_of(row, k):
    return row[k]


@kernel
def sum_of_two(row, k):
    return entry_of(row, k) + entry_of(row, k + 1)


@large_kernel
def long_sum(row):
    total = 0.0
    for k in range(len(row)):
        total += row[k]
    return total


@kernel
def sum_of_sums(row, other):
    return long_sum(row) + long_sum(other)


def code(compiled):
    """What LLVM made of the function itself, without the way in from Python."""
    text = next(iter(compiled.inspect_llvm().values()))
    name = next(iter(compiled.overloads.values())).fndesc.llvm_func_name
    return text[text.index(f"@{name}("):].split("\n}", 1)[0]


ROW = np.arange(5.0)


def test_a_kernel_that_kernels_call_can_be_called_from_python():
    assert sum_of_two(ROW, 1) == 3.0
    assert entry_of(ROW, 4) == 4.0
    assert sum_of_two.py_func(ROW, 1) == 3.0


def test_no_index_is_counted_from_the_end():
    usual = numba.njit(entry_of.py_func)
    assert usual(ROW, -1) == entry_of(ROW, 4) == 4.0
    assert "select" in code(usual)
    assert "select" not in code(entry_of.entry)


def test_where_indices_are_checked_one_below_0_is_refused():
    """So that the tests which check every index would see one."""
    script = "from test_ccd_compiling import entry_of, ROW; entry_of(ROW, 4); entry_of(ROW, -1)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True,
                          env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path)), "NUMBA_BOUNDSCHECK": "1"})
    assert done.stderr.strip().splitlines()[-1].startswith("IndexError")


def test_a_large_kernel_stays_apart_and_a_small_one_does_not():
    assert sum_of_sums(ROW, ROW) == 20.0
    assert code(sum_of_sums.entry).count("long_sum") >= 2
    assert sum_of_two(ROW, 0) == 1.0
    assert "entry_of" not in code(sum_of_two.entry)


@pytest.mark.parametrize("wrong", ["row", None])
def test_what_is_no_array_is_refused(wrong):
    with pytest.raises(numba.TypingError):
        sum_of_two(wrong, 0)
