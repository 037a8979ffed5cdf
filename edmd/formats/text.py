"""Numbers as text, and picking a frame: what the formats share."""

import numpy as np

TILTS = ([1, 2, 2], [0, 0, 1])          # where xy, xz and yz stand in the rows of a cell


def table(*columns):
    """One line a body from columns (n,) or (n, k); every float in the fewest digits that read back as the same float64."""
    flat = [column for array in map(np.asarray, columns) for column in array.reshape(len(array), -1).T]
    return "\n".join(map(" ".join, zip(*(map(str, column.tolist()) for column in flat)))) + "\n"


def words(values):
    """Numbers on one line."""
    return " ".join(map(str, np.ravel(values).tolist()))


def frame_index(frame, frames, path):
    """The index from 0 of a frame that may count from the end; ValueError when the file has no such frame."""
    if frames == 0:
        raise ValueError(f"path = {str(path)!r}: no frame in it")
    if not -frames <= frame < frames:
        raise ValueError(f"frame = {frame}: expected one from {-frames} to {frames - 1}")
    return frame % frames
