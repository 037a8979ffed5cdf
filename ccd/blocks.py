"""Arrays of pairs in blocks, one array for each number of a pair: the loops over a block become vector instructions.

Users keep one row a body: rows_a and rows_b are (semi_axes (n, 3), center (n, 3), orientation (n, 4)). A block of pairs is copied into
columns that fit the first-level cache. Pairs that the roots leave undecided are moved together and take the longer road as a block.
"""

from math import nan

import numba
import numpy as np

from ccd.characteristic import UNCERTAIN, aspect_ratio, magnitudes, margin, polynomial, state_by_contact_function, state_by_roots
from ccd.compiling import kernel, parallel_kernel
from ccd.rotation import body_axes, load_quaternion
from ccd.separation import contact_value, nearer_end, newton_step, relative_pencil, relative_pose
from ccd.tolerances import EXACT, PENCIL_STEPS, SHARP
from ccd.vectors import load, subtract

BLOCK = 64                  # pairs; their 20 columns take 10 kB


@kernel
def _fill(rows_a, rows_b, start, size, column):
    """Copy pairs from `start` on: body A into column[0:10], body B into column[10:20]."""
    _fill_body(rows_a, start, size, column, 0)
    _fill_body(rows_b, start, size, column, 10)


@kernel
def _fill_body(rows, start, size, column, at):
    semi_axes, center, orientation = rows
    for k in range(size):
        column[at, k], column[at + 1, k], column[at + 2, k] = load(semi_axes[start + k], 0)
    for k in range(size):
        column[at + 3, k], column[at + 4, k], column[at + 5, k] = load(center[start + k], 0)
    for k in range(size):
        q = load_quaternion(orientation[start + k], 0)
        column[at + 6, k], column[at + 7, k], column[at + 8, k], column[at + 9, k] = q


@kernel
def _relative_pose(column, k):
    axes_a = body_axes((column[6, k], column[7, k], column[8, k], column[9, k]))
    axes_b = body_axes((column[16, k], column[17, k], column[18, k], column[19, k]))
    r = subtract((column[13, k], column[14, k], column[15, k]), (column[3, k], column[4, k], column[5, k]))
    return relative_pose((column[0, k], column[1, k], column[2, k]), axes_a, (column[10, k], column[11, k], column[12, k]), axes_b, r)


@kernel
def _state_by_roots(column, k):
    g, t = _relative_pose(column, k)
    semi_axes_b = (column[10, k], column[11, k], column[12, k])
    det = column[0, k] * column[1, k] * column[2, k] / (semi_axes_b[0] * semi_axes_b[1] * semi_axes_b[2])
    return state_by_roots(polynomial(g, t, det), magnitudes(g, t), margin(aspect_ratio(semi_axes_b)))


@kernel
def _contact_functions(column, size, precision, f):
    """f of the pairs in `column`, which is written over. Step for step what `separation.contact_function` does: the same bits."""
    for k in range(size):
        g, t = _relative_pose(column, k)
        d, n = relative_pencil(g, t)
        concentric = n[2] == 0
        d, n, start, _ = nearer_end(d, n)
        column[0, k], column[1, k], column[2, k], column[3, k] = d
        column[4, k], column[5, k], column[6, k] = n
        column[7, k], column[8, k], column[9, k] = start, 0.0, 1.0
        column[10, k] = 1.0 if concentric else 0.0                  # done
    for _ in range(PENCIL_STEPS):
        done = 0.0
        for k in range(size):
            x, finished = column[7, k], column[10, k] > 0
            low, high, step = newton_step((column[0, k], column[1, k], column[2, k], column[3, k]),
                                          (column[4, k], column[5, k], column[6, k]), column[8, k], column[9, k], x)
            x = x if finished else x + step
            column[7, k], column[8, k], column[9, k] = x, low, high
            column[10, k] = 1.0 if finished | (abs(step) <= precision * min(x, 1 - x)) else 0.0
        for k in range(size):
            done += column[10, k]
        if done == size:
            break
    for k in range(size):
        value = contact_value((column[0, k], column[1, k], column[2, k], column[3, k]),
                              (column[4, k], column[5, k], column[6, k]), column[7, k])
        f[k] = value if column[10, k] > 0 else nan


@parallel_kernel
def states(rows_a, rows_b, state):
    """State of each pair into `state` (n,) int8; UNCERTAIN where float64 cannot hold the pencil parameter."""
    n = len(state)
    for block in numba.prange((n + BLOCK - 1) // BLOCK):
        start = block * BLOCK
        size = min(BLOCK, n - start)
        column, f = np.empty((20, BLOCK)), np.empty(BLOCK)
        found, left = np.empty(BLOCK, dtype=np.int8), np.empty(BLOCK, dtype=np.int64)
        _fill(rows_a, rows_b, start, size, column)
        for k in range(size):
            found[k] = _state_by_roots(column, k)
        uncertain = 0
        for k in range(size):
            state[start + k] = found[k]
            if found[k] == UNCERTAIN:
                left[uncertain] = k
                for i in range(20):
                    column[i, uncertain] = column[i, k]
                uncertain += 1
        if uncertain > 0:
            _contact_functions(column, uncertain, SHARP, f)
            for m in range(uncertain):
                state[start + left[m]] = state_by_contact_function(f[m])


@parallel_kernel
def contact_functions(rows_a, rows_b, f):
    """The contact function of each pair into f (n,); nan where float64 cannot hold the pencil parameter."""
    n = len(f)
    for block in numba.prange((n + BLOCK - 1) // BLOCK):
        start = block * BLOCK
        size = min(BLOCK, n - start)
        column = np.empty((20, BLOCK))
        _fill(rows_a, rows_b, start, size, column)
        _contact_functions(column, size, EXACT, f[start:start + size])
