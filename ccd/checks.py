"""Bad input in words: each check returns the value as the library wants it, or raises ValueError that names the argument."""

import operator

import numpy as np

UNIT = 1e-15
SHORT = 12                   # elements of an array that a message shows in full
SINGULAR = 1e-14             # ratio of singular values, some 50 roundings



def real_array(name, value, shape, what):
    """A C-contiguous float64 copy of the wanted shape (None: any length), all finite."""
    try:
        array = np.array(value, dtype=np.float64, order="C")
    except (TypeError, ValueError):
        raise ValueError(f"{name} = {value!r}: expected {what}") from None
    if array.ndim != len(shape) or any(want is not None and have != want for have, want in zip(array.shape, shape)):
        raise ValueError(f"{name} has shape {array.shape}: expected {what}")
    _everywhere(name, value, array, np.isfinite(array), "finite numbers")
    return array


def _everywhere(name, value, array, fine, what):
    """ValueError for the first element of an array that is not fine; a short array is shown as it was given."""
    if fine.all():
        return
    if array.size <= SHORT:
        raise ValueError(f"{name} = {value!r}: expected {what}")
    where = tuple(np.argwhere(~fine)[0].tolist())
    raise ValueError(f"{name}[{', '.join(map(str, where))}] = {array[where]}: expected {what}")


def semi_axes(name, value, shape=(3,), what="three positive lengths"):
    array = real_array(name, value, shape, what)
    _everywhere(name, value, array, array > 0, "positive semi-axes")
    return array


def principal_moments(name, value, shape=(3,), what="three positive moments of inertia"):
    array = real_array(name, value, shape, what)
    _everywhere(name, value, array, array > 0, "positive moments of inertia")
    return array


def unit_quaternions(name, value, shape=(4,), what="a quaternion (w, x, y, z)"):
    """Quaternions made unit; zero ones are refused."""
    array = real_array(name, value, shape, what)
    length = np.sqrt((array * array).sum(axis=-1, keepdims=True))
    if not (length > 1e-150).all():
        raise ValueError(f"{name} = {value!r}: a quaternion must not be zero")
    return np.where(abs(length - 1) < UNIT, array, array / length)          # what is unit already keeps its bits


def real_number(name, value, what="a number", above=-np.inf, at_least=-np.inf, below=np.inf, at_most=np.inf):
    """A finite float; `above` and `below` are open bounds, `at_least` and `at_most` are closed."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise ValueError(f"{name} = {value!r}: expected {what}") from None
    if not (np.isfinite(number) and number > above and at_least <= number <= at_most and number < below):
        raise ValueError(f"{name} = {value!r}: expected {what}")
    return number


def time_span(name, value):
    """(start, end) with start < end."""
    start, end = real_array(name, value, (2,), "two finite times (start, end)").tolist()
    if not start < end:
        raise ValueError(f"{name} = {value!r}: expected start < end")
    return start, end


def cell_vectors(name, value):
    """A periodic cell (3, 3): rows that span a volume."""
    cell = real_array(name, value, (3, 3), "three cell vectors as rows (3, 3)")
    if not abs(np.linalg.det(cell)) > 0:
        raise ValueError(f"{name} = {cell.tolist()}: expected three vectors that span a volume")
    return cell


def linear_map(name, value, shape=(3, 3), what="a matrix (3, 3)"):
    """Matrices (3, 3) that float64 can tell from singular ones."""
    matrices = real_array(name, value, shape, what)
    sizes = np.linalg.svd(matrices, compute_uv=False).reshape(-1, 3)
    flat = np.flatnonzero(~(sizes[:, -1] > SINGULAR * sizes[:, 0]))
    if len(flat):
        wrong = matrices.reshape(-1, 3, 3)[flat[0]].tolist()
        raise ValueError(f"{name} = {wrong}: singular (singular values {sizes[flat[0]].tolist()}), expected an invertible matrix")
    return matrices


def natural_number(name, value):
    """An integer from 0 on, such as a seed."""
    try:
        number = operator.index(value)
    except TypeError:
        number = -1
    if number < 0:
        raise ValueError(f"{name} = {value!r}: expected a whole number from 0 on")
    return number
