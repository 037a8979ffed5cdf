"""Bad input in words: each check returns the value as the library wants it, or raises ValueError that names the argument."""

from __future__ import annotations

import operator

import numpy as np
from numpy.typing import NDArray

from ccd.annotations import Any, Floats, Span

Shape = tuple[int | None, ...]
UNIT = 1e-15
SHORT = 12                   # elements of an array that a message shows in full
SINGULAR = 1e-14             # ratio of singular values, some 50 roundings



def real_array(name: str, value: Any, shape: Shape, what: str) -> Floats:
    """A C-contiguous float64 copy of the wanted shape (None: any length), all finite."""
    try:
        array = np.array(value, dtype=np.float64, order="C")
    except (TypeError, ValueError):
        raise ValueError(f"{name} = {value!r}: expected {what}") from None
    if array.ndim != len(shape) or any(want is not None and have != want for have, want in zip(array.shape, shape)):
        raise ValueError(f"{name} has shape {array.shape}: expected {what}")
    _everywhere(name, value, array, np.isfinite(array), "finite numbers")
    return array


def _everywhere(name: str, value: Any, array: Floats, fine: NDArray[np.bool_], what: str) -> None:
    """ValueError for the first element of an array that is not fine; a short array is shown as it was given."""
    if fine.all():
        return
    if array.size <= SHORT:
        raise ValueError(f"{name} = {value!r}: expected {what}")
    where = tuple(np.argwhere(~fine)[0].tolist())
    raise ValueError(f"{name}[{', '.join(map(str, where))}] = {array[where]}: expected {what}")


def semi_axes(name: str, value: Any, shape: Shape = (3,), what: str = "three positive lengths") -> Floats:
    array = real_array(name, value, shape, what)
    _everywhere(name, value, array, array > 0, "positive semi-axes")
    return array


def principal_moments(name: str, value: Any, shape: Shape = (3,), what: str = "three positive moments of inertia") -> Floats:
    array = real_array(name, value, shape, what)
    _everywhere(name, value, array, array > 0, "positive moments of inertia")
    return array


def unit_quaternions(name: str, value: Any, shape: Shape = (4,), what: str = "a quaternion (w, x, y, z)") -> Floats:
    """Quaternions made unit; zero ones are refused."""
    array = real_array(name, value, shape, what)
    length = np.sqrt((array * array).sum(axis=-1, keepdims=True))
    if not (length > 1e-150).all():
        raise ValueError(f"{name} = {value!r}: a quaternion must not be zero")
    return np.where(abs(length - 1) < UNIT, array, array / length)          # what is unit already keeps its bits


def real_number(name: str, value: Any, what: str = "a number", above: float = -np.inf, at_least: float = -np.inf, below: float = np.inf,
                at_most: float = np.inf) -> float:
    """A finite float; `above` and `below` are open bounds, `at_least` and `at_most` are closed."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise ValueError(f"{name} = {value!r}: expected {what}") from None
    if not (np.isfinite(number) and number > above and at_least <= number <= at_most and number < below):
        raise ValueError(f"{name} = {value!r}: expected {what}")
    return number


def time_span(name: str, value: Any) -> Span:
    """(start, end) with start < end."""
    start, end = real_array(name, value, (2,), "two finite times (start, end)").tolist()
    if not start < end:
        raise ValueError(f"{name} = {value!r}: expected start < end")
    return start, end


def cell_vectors(name: str, value: Any) -> Floats:
    """A periodic cell (3, 3): rows that span a volume."""
    cell = real_array(name, value, (3, 3), "three cell vectors as rows (3, 3)")
    if not abs(np.linalg.det(cell)) > 0:
        raise ValueError(f"{name} = {cell.tolist()}: expected three vectors that span a volume")
    return cell


def linear_map(name: str, value: Any, shape: Shape = (3, 3), what: str = "a matrix (3, 3)") -> Floats:
    """Matrices (3, 3) that float64 can tell from singular ones."""
    matrices = real_array(name, value, shape, what)
    sizes = np.linalg.svd(matrices, compute_uv=False).reshape(-1, 3)
    flat = np.flatnonzero(~(sizes[:, -1] > SINGULAR * sizes[:, 0]))
    if len(flat):
        wrong = matrices.reshape(-1, 3, 3)[flat[0]].tolist()
        raise ValueError(f"{name} = {wrong}: singular (singular values {sizes[flat[0]].tolist()}), expected an invertible matrix")
    return matrices


def natural_number(name: str, value: Any) -> int:
    """An integer from 0 on, such as a seed."""
    try:
        number = operator.index(value)
    except TypeError:
        number = -1
    if number < 0:
        raise ValueError(f"{name} = {value!r}: expected a whole number from 0 on")
    return number
