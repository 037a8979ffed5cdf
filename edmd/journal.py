"""A file that a killed process, or a full disk, leaves as it was when it was last whole.

HDF5 flushes in many writes, and between the first and the last of them a file is not whole: new frames are announced before their place in
the file is. So what is overwritten is first kept in a journal beside the file, and whoever opens the file next puts it back.
"""

import fcntl
import os
import struct
import zlib
from pathlib import Path

RECORD = struct.Struct("<QQQI")     # where, how much, length of the file when it was whole, checksum of what follows


class BeingWritten(ValueError):
    """Another process writes this file."""


class JournaledFile:
    """The file object that h5py writes to. `commit` says that it is whole; `close` puts back what was there at the last commit."""

    def __init__(self, path, mode):
        """mode: "x" for a new file, "w" to replace one, "r+" to go on with one (put back to where it was whole)."""
        self._path, self._at, self.failure = Path(path), 0, None
        self._journal = _locked(path)
        try:
            if mode == "r+":
                _put_back(path, self._journal)
            self._file = os.open(path, os.O_RDWR | {"x": os.O_CREAT | os.O_EXCL, "w": os.O_CREAT | os.O_TRUNC, "r+": 0}[mode], 0o666)
        except OSError:
            self._end_journal()
            raise
        os.ftruncate(self._journal, 0)
        self._whole = os.fstat(self._file).st_size

    def commit(self):
        """The file is whole now."""
        if self.failure is not None:
            raise self.failure
        os.ftruncate(self._journal, 0)
        os.lseek(self._journal, 0, os.SEEK_SET)
        self._whole = os.fstat(self._file).st_size

    def close(self):
        _put_back(self._path, self._journal)
        os.close(self._file)
        self._end_journal()

    def _end_journal(self):
        journal_path(self._path).unlink(missing_ok=True)
        os.close(self._journal)

    # what h5py asks of a file

    def seek(self, offset, whence=os.SEEK_SET):
        self._at = offset + {os.SEEK_SET: 0, os.SEEK_CUR: self._at, os.SEEK_END: os.fstat(self._file).st_size}[whence]
        return self._at

    def tell(self):
        return self._at

    def read(self, size):
        data = os.pread(self._file, size, self._at)
        self._at += len(data)
        return data

    def readinto(self, buffer):
        data = self.read(len(buffer))
        buffer[:len(data)] = data
        return len(data)

    def write(self, data):
        self._change(self._at, self._at + len(data), lambda: _write_all(self._file, data, self._at))
        self._at += len(data)
        return len(data)

    def truncate(self, size):
        self._change(size, self._whole, lambda: os.ftruncate(self._file, size))
        return size

    def flush(self):
        """What is written is with the operating system already."""

    def _change(self, start, end, change):
        """Keep what was whole between start and end, then change it. After a failure nothing is written any more, so that HDF5 can end."""
        if self.failure is not None:
            return
        try:
            end = min(end, self._whole)
            if start < end:
                kept = os.pread(self._file, end - start, start)
                _write_all(self._journal, RECORD.pack(start, len(kept), self._whole, zlib.crc32(kept)) + kept)
            change()
        except OSError as problem:
            self.failure = problem


def put_back(path):
    """Bring a file that no process writes any more to where it was last whole. BeingWritten when one does; a whole file is left alone."""
    if journal_path(path).exists() and Path(path).exists():
        journal = _locked(path)
        try:
            _put_back(path, journal)
            journal_path(path).unlink(missing_ok=True)
        finally:
            os.close(journal)


def journal_path(path):
    return Path(f"{path}.journal")


def _locked(path):
    journal = os.open(journal_path(path), os.O_RDWR | os.O_CREAT, 0o666)
    try:
        fcntl.flock(journal, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(journal)
        raise BeingWritten(f"path = {str(path)!r}: is being written by another process") from None
    except OSError:                 # a network disk without locks
        pass
    return journal


def _put_back(path, journal):
    kept = os.pread(journal, os.fstat(journal).st_size, 0)
    records, at = [], 0
    while at + RECORD.size <= len(kept):
        start, length, whole, checksum = RECORD.unpack_from(kept, at)
        data = kept[at + RECORD.size:at + RECORD.size + length]
        if len(data) < length or zlib.crc32(data) != checksum:
            break                   # killed while keeping it: what it kept was not changed
        records.append((start, data))
        at += RECORD.size + length
    if records:
        file = os.open(path, os.O_RDWR)
        for start, data in reversed(records):
            _write_all(file, data, start)
        os.ftruncate(file, whole)
        os.close(file)
        os.ftruncate(journal, 0)


def _write_all(file, data, at=None):
    view = memoryview(data).cast("B")
    while view:
        written = os.write(file, view) if at is None else os.pwrite(file, view, at)
        view, at = view[written:], None if at is None else at + written
