"""A disk cache of compiled code that is never stale.

numba's own cache notices an edit in the file of the cached function only, not in the files whose kernels it calls. The cache folder
is therefore named after a digest of every source file that a kernel can depend on: an edit opens a new, empty folder.
"""

import functools
import hashlib
import os
import re
import shutil
import tempfile
import time
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numba

try:
    import fcntl
except ImportError:                 # Windows
    fcntl = None  # type: ignore[assignment]

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ("ccd", "edmd", "analysis")
_IMPORT = re.compile(r"^\s*(?:from\s+([\w.]+)\s+)?import\s+(\([^)]*\)|.+)$", re.MULTILINE)
PATIENCE, PAUSE = 600.0, 0.1     # seconds to wait for another process that compiles, and between two looks at whether it has done
FOLDERS_KEPT = 4                 # caches of earlier sources, for people who switch between branches


def kernel_sources(package):
    """Files of a package that hold a kernel, and every file of these packages that they import, directly or not: name -> text."""
    texts = {str(path.relative_to(ROOT))[:-3].replace(os.sep, ".").removesuffix(".__init__"): path.read_bytes()
             for each in PACKAGES for path in (ROOT / each).rglob("*.py")}
    reached = {name for name, text in texts.items()
               if name.startswith(f"{package}.") and re.search(rb"^@(parallel_|large_)?kernel", text, re.M)}
    frontier = list(reached)
    while frontier:
        for module, names in _IMPORT.findall(texts[frontier.pop()].decode()):
            names = re.findall(r"[\w.]+", names)
            new = ({module, *(f"{module}.{name}" for name in names)} if module else set(names)) & texts.keys() - reached
            reached |= new
            frontier += new
    return {name: texts[name] for name in sorted(reached)}


def _writable(folder):
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


@functools.cache
def cache_folder(package):
    """The folder for the compiled code of a package: in $EDMD_CACHE_DIR, else in the user's cache folder, else in the temporary one.

    None, which means no cache, where none can be written, and for code from elsewhere, whose sources are not known here.
    """
    if package not in PACKAGES:
        return None
    digest = hashlib.sha256(f"bounds checked: {numba.config.BOUNDSCHECK}".encode())
    for name, text in kernel_sources(package).items():
        digest.update(name.encode() + b"\0" + text)
    user = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    candidates = [Path(os.environ["EDMD_CACHE_DIR"])] if os.environ.get("EDMD_CACHE_DIR") else []
    candidates += [user / "edmd", Path(tempfile.gettempdir()) / f"edmd-{os.getuid() if hasattr(os, 'getuid') else 'user'}"]
    for base in candidates:
        folder = base / f"{package}-{digest.hexdigest()[:16]}"
        if _writable(folder):
            os.utime(folder)
            _forget_old(base, package, keep=folder)
            return str(folder)
    return None


@contextmanager
def one_at_a_time(package):
    """Let nobody else compile for this cache: who has waited finds compiled what the one before has. Where files have locks."""
    folder = cache_folder(package)
    with ExitStack() as stack:
        if folder and fcntl:
            _wait_for(stack.enter_context(open(os.path.join(folder, "lock"), "w")))
        yield


def _wait_for(file):
    """Lock a file, if it can be before patience ends."""
    for _ in range(round(PATIENCE / PAUSE)):
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return
        except BlockingIOError:
            time.sleep(PAUSE)
        except OSError:                                 # a file system without locks
            return


def _forget_old(base, package, keep):
    def age(folder):
        try:
            return folder.stat().st_mtime
        except OSError:
            return 0.0
    others = sorted((folder for folder in base.glob(f"{package}-*") if folder != keep), key=age)
    for folder in others[:-FOLDERS_KEPT]:
        shutil.rmtree(folder, ignore_errors=True)
