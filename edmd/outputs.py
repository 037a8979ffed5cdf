"""Whether a file can be written, before anything is computed."""

import os
import tempfile
from pathlib import Path


def check_output(path, overwrite=False):
    """The path, when a file can be written there; ValueError in words when not."""
    path = Path(path)
    if path.is_dir():
        raise ValueError(f"output = {str(path)!r}: is a folder; expected the name of a file")
    if path.exists() and not overwrite:
        raise ValueError(f"output = {str(path)!r}: exists already; choose another name or overwrite it")
    folder = path.parent
    if not folder.is_dir():
        raise ValueError(f"output = {str(path)!r}: the folder {str(folder)!r} does not exist")
    try:            # permissions do not tell it all: a read-only disk, a folder of the system
        with tempfile.TemporaryFile(dir=folder):
            writable = not path.exists() or os.access(path, os.W_OK)
    except OSError:
        writable = False
    if not writable:
        raise ValueError(f"output = {str(path)!r}: cannot be written there")
    return path
