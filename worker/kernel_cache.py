"""Where compiled kernels are kept: in the package itself, read only, and in the user's cache.

A kernel's file is found by what its bits depend on (`identity`) and by its name and types; not by where its sources lie or
when they were written. So a kernel made elsewhere for the same identity is loaded, and an edited one is never met again.

A stored kernel is a pickle, which can do anything when it is loaded: it is read only from folders into which nobody but the
user, or whoever installed the package, can write.
"""

import hashlib
import inspect
import os
import pickle
import stat
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from tempfile import NamedTemporaryFile, gettempdir, mkdtemp
from typing import Any

import llvmlite
import numba
import numpy as np
from numba.core.compiler import CompileResult
from numba.core.runtime import rtsys
from numba.core.serialize import dumps

from damperlab.worker.compiler.target import PROCESSOR, TRIPLE

_HERE = Path(__file__).parent
_SOURCES = ("jit.py", "kernel_cache.py", "rk4.py", "accuracy/march.py")
_SOURCE_FOLDERS = ("compiler", "physics", "solver", "steady")


@cache
def source_hash() -> str:
    """Hash of every kernel source, 16 hex digits: the identity of the solver.

    Returns
    -------
    str
        The same on every machine that holds the same sources, whatever its line endings.
    """
    digest = hashlib.sha256()
    sources = [_HERE / name for name in _SOURCES]
    for folder in _SOURCE_FOLDERS:
        sources.extend((_HERE / folder).rglob("*.py"))
    for source in sorted(sources):
        digest.update(source.relative_to(_HERE).as_posix().encode())
        digest.update(source.read_bytes().replace(b"\r\n", b"\n"))
    return digest.hexdigest()[:16]


@cache
def identity() -> dict[str, str]:
    """All that the bits of a kernel's results depend on, and that its file must agree with to be loaded.

    Returns
    -------
    dict of str
        `sources` (`source_hash`), `target` (processor and platform that kernels are compiled for), the versions of
        `numba`, `llvmlite` and `numpy`, `python` (whose objects kernels take and give), and `bounds` where indices are
        checked (NUMBA_BOUNDSCHECK=1).
    """
    return {
        "sources": source_hash(),
        "target": f"{PROCESSOR} {TRIPLE}",
        "numba": numba.__version__,
        "llvmlite": llvmlite.__version__,
        "numpy": np.__version__,
        "python": sys.implementation.cache_tag,
        "bounds": "checked" if numba.config.BOUNDSCHECK else "trusted",
    }


def folder_name() -> str:
    """Name of the folder of the kernels of this identity."""
    rest = hashlib.sha256(repr(sorted(identity().items())).encode()).hexdigest()[:8]
    return f"kernels-{source_hash()}-{rest}"


def shipped_folder() -> Path:
    """Folder inside the package for kernels that are installed with it; it need not exist."""
    return _HERE / "kernels" / folder_name()


def is_private(folder: Path) -> bool:
    """Whether nobody but this user and the superuser can put files there, or replace it or a folder above it."""
    if not hasattr(os, "getuid"):  # not a POSIX system: the user's folders are the user's
        return True
    trusted = (0, os.getuid())
    try:
        places = [place.stat() for place in (folder.resolve(), *folder.resolve().parents)]
    except OSError:
        return False
    if places[0].st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        return False
    # in a sticky folder, such as /tmp, others cannot rename what is not theirs
    open_modes = (place.st_mode & (stat.S_IWGRP | stat.S_IWOTH) for place in places)
    return all(
        place.st_uid in trusted and (not writable or place.st_mode & stat.S_ISVTX)
        for place, writable in zip(places, open_modes, strict=True)
    )


def is_as_safe_as_the_package(folder: Path) -> bool:
    """Whether only those can write there who can change the package's sources too."""
    try:
        inside, package = folder.stat(), _HERE.stat()
    except OSError:
        return False
    loose = stat.S_IWGRP | stat.S_IWOTH
    return inside.st_uid in (0, package.st_uid) and not inside.st_mode & loose & ~package.st_mode


def cache_folder() -> Path:
    """Folder of the kernels compiled here: under DAMPERLAB_CACHE_DIR, the user's cache, or the temporary folder.

    Returns
    -------
    Path
        The first of these that can be written by this user and by no other; else a new temporary one, for this
        process alone. It exists on return.
    """
    wanted = os.environ.get("DAMPERLAB_CACHE_DIR")
    home = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    candidates = [Path(wanted)] if wanted else [Path(home).expanduser() / "damperlab"]
    candidates.append(Path(gettempdir()) / f"damperlab-{os.getuid() if hasattr(os, 'getuid') else 'user'}")
    for candidate in candidates:
        folder = candidate / folder_name()
        try:
            folder.parent.mkdir(parents=True, exist_ok=True)
            folder.mkdir(mode=0o700, exist_ok=True)
        except OSError:
            continue
        if os.access(folder, os.W_OK) and is_private(folder):
            return folder
    return Path(mkdtemp(prefix="damperlab-"))


CACHE_FOLDER = cache_folder()


class KernelCache:
    """Kernels of one function on disk, as numba's dispatcher asks for them.

    Parameters
    ----------
    function : callable
        The plain form of the kernel.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        self._name = f"{function.__module__.rpartition('worker.')[2]}.{function.__qualname__}"
        source = Path(inspect.getfile(function)).resolve()
        # of the sources of a kernel outside the package the identity knows nothing
        if not source.is_relative_to(_HERE.resolve()) and source.exists():
            self._name += f".{hashlib.sha256(source.read_bytes()).hexdigest()[:8]}"

    @property
    def cache_path(self) -> str:
        """Folder that new kernels are written to."""
        return str(CACHE_FOLDER)

    def load_overload(self, signature: Any, context: Any) -> Any:
        """Kernel for the types of a call; None where none is stored.

        Machine code needs no more of numba than what allocates arrays. All else that it compiles with, `context.refresh`,
        loads for 0.4 s, and is asked for where something is compiled.
        """
        for folder, safe in ((shipped_folder(), is_as_safe_as_the_package), (CACHE_FOLDER, is_private)):
            path = folder / self._file(signature)
            if path.exists() and safe(folder):
                stored = pickle.loads(path.read_bytes())
                if stored["identity"] == identity() and stored["signature"] == str(signature):
                    rtsys.initialize(context)
                    return CompileResult._rebuild(context, *stored["kernel"])
        return None

    def save_overload(self, signature: Any, compiled: Any) -> None:
        """Keep a kernel, in one step, so that no other process meets half of it."""
        stored = {"identity": identity(), "signature": str(signature), "kernel": compiled._reduce()}
        path = CACHE_FOLDER / self._file(signature)
        try:
            with NamedTemporaryFile(dir=CACHE_FOLDER, prefix=".", delete=False) as file:
                file.write(dumps(stored))
            Path(file.name).replace(path)
        except OSError:  # a full disk: the kernel serves this process all the same
            Path(file.name).unlink(missing_ok=True)

    def _file(self, signature: Any) -> str:
        return f"{self._name}-{hashlib.sha256(str(signature).encode()).hexdigest()[:16]}.nbc"
