"""Which bodies are near each other, under the periodic images of any cell? In double precision, by SciPy's k-d tree."""

import numpy as np
from scipy.spatial import KDTree


def near_pairs(positions, cell, cutoff):
    """Every pair of bodies, or of a body and an image, that is at most `cutoff` apart: each pair once.

    `positions` (n, 3), anywhere; `cell` (3, 3), its rows the cell vectors, of any shape; `cutoff` a length, larger than the
    cell too: then a pair stands there for each of its images, and a body is paired with its own. Returns (first (m,),
    second (m,), separation (m, 3)): the separation leads from the first body to the image of the second.
    """
    reciprocal = np.linalg.inv(cell)
    fractions = positions @ reciprocal % 1.0
    inside = fractions @ cell
    reach = cutoff * np.linalg.norm(reciprocal, axis=0)  # of a cutoff, in fractions of the width between opposite faces
    steps = [np.arange(-n, n + 1) for n in np.ceil(reach).astype(int)]
    shifts = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 3)
    around = fractions + shifts[:, None]
    shift, body = np.nonzero(np.all((around >= -reach) & (around <= 1 + reach), axis=2))
    images = inside[body] + shifts[shift] @ cell
    found = KDTree(inside).sparse_distance_matrix(KDTree(images), cutoff, output_type="ndarray")
    first, image = found["i"], found["j"]
    forward = shift[image] > len(shifts) // 2  # of two opposite shifts one is in the second half; the middle is no shift
    once = (first < body[image]) | ((first == body[image]) & forward)
    first, image = first[once], image[once]
    return first, body[image], images[image] - inside[first]


def checked_frame(positions, cell):
    """`positions` and `cell` as float64 arrays; ValueError unless they are (n, 3) and three vectors that span a volume."""
    positions, cell = np.asarray(positions, dtype=float), np.asarray(cell, dtype=float)
    if positions.ndim != 2 or positions.shape[1] != 3:
        raise ValueError(f"positions: shape {positions.shape}; one row of three a body is needed, (n, 3)")
    if cell.shape != (3, 3) or not abs(np.linalg.det(cell)) > 0:
        raise ValueError(f"cell: {cell.tolist()}; three rows that span a volume are needed")
    return positions, cell
