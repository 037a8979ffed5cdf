"""What type hints say of arguments and results. Shapes and units stand in the docstrings."""

import os
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[Any]                    # of numbers, whichever
Floats = NDArray[np.float64]
AnyPath = str | os.PathLike[str]
Span = tuple[float, float]

__all__ = ["Any", "AnyPath", "Array", "ArrayLike", "Floats", "Span"]
