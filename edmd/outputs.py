"""Files that are written: whether one can be, before anything is computed, and that it is there whole or not at all."""

import os
import tempfile
from contextlib import contextmanager
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


@contextmanager
def written_whole(path):
    """A path beside this one to write to, which takes its place at the end: killed or with a full disk, the file is whole or not there."""
    partial = path.with_name(f"{path.name}.{os.getpid()}.partial")
    try:
        yield partial
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)
