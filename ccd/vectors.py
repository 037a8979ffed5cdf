"""3-vectors as tuples of three floats. Inside kernels these compile to plain registers; a 3-element array costs a hundred times more."""

from ccd.compiling import kernel
from ccd.lanes import sqrt


@kernel
def add(a, b):
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@kernel
def subtract(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@kernel
def scale(factor, a):
    return (factor * a[0], factor * a[1], factor * a[2])


@kernel
def add_scaled(a, factor, b):
    """a + factor * b"""
    return (a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2])


@kernel
def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@kernel
def norm(a):
    return sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


@kernel
def root_and_inverse(square):
    """The square root and one over it: the division does not wait for the root."""
    root = sqrt(square)
    return root, root * (1.0 / square)


@kernel
def load(row, start):
    """Three consecutive entries of a one-dimensional array."""
    return (row[start], row[start + 1], row[start + 2])


@kernel
def store(row, start, a):
    row[start] = a[0]
    row[start + 1] = a[1]
    row[start + 2] = a[2]
