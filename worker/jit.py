"""The one jit policy and the one kernel cache of the project.

numba's own disk cache looks only at the file of the function it compiled: a change in a callee in another file leaves a
stale kernel behind. So the cache folder carries a hash of all kernel sources, and a kernel is compiled once per machine.
"""

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from tempfile import gettempdir
from typing import Any, TypeVar

import numba
from numba.extending import overload

F = TypeVar("F", bound=Callable[..., Any])

_KERNEL_FOLDERS = ("physics", "solver", "steady")


def source_hash() -> str:
    """Hash of every kernel source, 16 hex digits: the identity of the solver.

    Returns
    -------
    str
        The same on every machine that holds the same sources, whatever its line endings.
    """
    here = Path(__file__).parent
    digest = hashlib.sha256()
    sources = [here / "jit.py", here / "rk4.py"]
    for folder in _KERNEL_FOLDERS:
        sources.extend((here / folder).rglob("*.py"))
    for source in sorted(sources):
        if source.exists():
            digest.update(source.relative_to(here).as_posix().encode())
            digest.update(source.read_bytes().replace(b"\r\n", b"\n"))
    return digest.hexdigest()[:16]


def cache_folder() -> Path:
    """Folder of the compiled kernels: under DAMPERLAB_CACHE_DIR, the user's cache, or the temporary folder.

    Returns
    -------
    Path
        The first of these that can be written; it exists on return.
    """
    wanted = os.environ.get("DAMPERLAB_CACHE_DIR")
    home = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    candidates = [Path(wanted)] if wanted else [Path(home).expanduser() / "damperlab"]
    candidates.append(Path(gettempdir()) / f"damperlab-{os.getuid() if hasattr(os, 'getuid') else 'user'}")
    for candidate in candidates:
        folder = candidate / f"kernels-{source_hash()}"
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(folder, os.W_OK):
            return folder
    return candidates[-1]


CACHE_FOLDER = cache_folder()
numba.config.CACHE_DIR = str(CACHE_FOLDER)  # read when a kernel is decorated, so it must be set before any is


def kernel(function: F) -> F:
    """Compile on first call, keep on disk, release the GIL.

    Of fastmath only `contract` (a product and a sum rounded once): sums are never re-ordered, so a point has the same
    bits in whatever block, process and order it is computed. Division by zero gives inf and NaN as in C, because a
    numerical failure is data, not an exception.
    """
    jitted: F = numba.njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})(function)
    return jitted


_INLINED = {
    "cache": True,
    "nogil": True,
    "error_model": "numpy",
    "fastmath": {"contract"},
    "forceinline": True,
}


def inlined(function: F) -> F:
    """Like `kernel`, but always made part of what calls it.

    For the small laws inside the march: left to itself the compiler calls some of them, and then hands their states
    through memory. Measured on a metered march: a quarter of its run time.
    """
    jitted: F = numba.njit(**_INLINED)(function)
    return jitted


def by_type(function: Any) -> Any:
    """Decorate what chooses, by the types of its arguments, the form in which kernels call a Python function; inlined."""
    return overload(function, jit_options={"forceinline": True})
