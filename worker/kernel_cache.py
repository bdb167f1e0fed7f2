"""Location of compiled kernels: in the package itself, read only, and in the user's cache.

A kernel's file is found by the kernel's name and types and by everything that determines its bits (`identity`), not by
the location or date of its sources. So a kernel compiled elsewhere for the same identity is loaded, and an edited one
is never loaded again.

If other sources have changed, a kernel whose own functions (`fingerprint`) are unchanged is taken over.

A file begins with a line of JSON: the identity of the kernel, and the hash of its bytes, so that a damaged file is
ignored.

The rest is a pickle, which can run any code when it is loaded. It is read only from folders that nobody but the
user, or the installer of the package, can write.
"""

import hashlib
import inspect
import json
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
from numba import types
from numba.core.compiler import CompileResult
from numba.core.runtime import rtsys
from numba.core.serialize import dumps

from damperlab.studies.store.sources import hash_of
from damperlab.worker.compiler.numba_read import ALONE
from damperlab.worker.compiler.target import PROCESSOR, TRIPLE
from damperlab.worker.fingerprint import UNKNOWN, fingerprint, name_of

_HERE = Path(__file__).parent
_COMPILER = ("worker/compiler", "worker/jit.py")
_KERNELS = ("physics", "solver", "steady", "rk4.py", "accuracy/march.py")
_SOURCES = (*_COMPILER, *(f"worker/{name}" for name in _KERNELS), "studies/variables.py")
"""Sources of the kernels: the compiler, the kernels themselves, and the numbers of classes and statuses."""
_OPTIONS = (
    "BOUNDSCHECK",
    "OPT",
    "LOOP_VECTORIZE",
    "SLP_VECTORIZE",
    "ENABLE_AVX",
    "USING_SVML",
    "DEBUGINFO_DEFAULT",
)
"""Settings of numba that change the machine code."""


@cache
def source_hash() -> str:
    """Hash of the code of all kernel sources, 16 hex digits."""
    return hash_of(_HERE.parent, _SOURCES)[:16]


@cache
def identity() -> dict[str, str]:
    """Give everything that determines the bits of a kernel's results; a kernel's file is loaded only if it matches.

    Returns
    -------
    dict of str
        Hashes of the kernels' `sources` (`source_hash`) and of the `compiler`, and `target`, the processor and platform
        of the kernels. The versions of `numba`, `llvmlite` and `numpy`, of `python`, whose objects kernels take and
        return, and numba's `options`.
    """
    return {
        "sources": source_hash(),
        "compiler": hash_of(_HERE.parent, _COMPILER)[:16],
        "target": f"{PROCESSOR} {TRIPLE}" + (", compiled by numba alone" if ALONE else ""),
        "numba": numba.__version__,
        "llvmlite": llvmlite.__version__,
        "numpy": np.__version__,
        "python": sys.implementation.cache_tag,
        "options": " ".join(f"{name}={getattr(numba.config, name, None)}" for name in _OPTIONS),
    }


@cache
def folder_name() -> str:
    """Name of the folder of the kernels of this identity: its sources, and a hash of everything else."""
    rest = sorted(pair for pair in identity().items() if pair[0] != "sources")
    return f"kernels-{source_hash()}-{hashlib.sha256(repr(rest).encode()).hexdigest()[:8]}"


def shipped_folder() -> Path:
    """Folder inside the package for kernels that are installed with it; it need not exist."""
    return _HERE / "kernels" / folder_name()


def is_private(folder: Path) -> bool:
    """Whether only this user and the superuser can write files there, or replace it or a folder above it."""
    if not hasattr(os, "getuid"):  # not a POSIX system: the user's folders belong to the user
        return True
    trusted = (0, os.getuid())
    try:
        places = [place.stat() for place in (folder.resolve(), *folder.resolve().parents)]
    except OSError:
        return False
    if places[0].st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        return False
    # in a sticky folder, for example /tmp, others cannot rename files of another user
    open_modes = (place.st_mode & (stat.S_IWGRP | stat.S_IWOTH) for place in places)
    return all(
        place.st_uid in trusted and (not writable or place.st_mode & stat.S_ISVTX)
        for place, writable in zip(places, open_modes, strict=True)
    )


def is_as_safe_as_the_package(folder: Path) -> bool:
    """Whether only users with write access to the package's sources can write there."""
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
        The first of these that only this user can write; else a new temporary folder for this process alone. It exists
        on return.
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
    """Kernels of one function on disk, in the interface of numba's dispatcher.

    Parameters
    ----------
    function : callable
        The plain form of the kernel.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        self._name = f"{function.__module__.rpartition('worker.')[2]}.{function.__qualname__}"
        source = Path(inspect.getfile(function)).resolve()
        # the identity does not cover sources of a kernel outside the package
        if not source.is_relative_to(_HERE.resolve()) and source.exists():
            self._name += f".{hashlib.sha256(source.read_bytes()).hexdigest()[:8]}"

    @property
    def cache_path(self) -> str:
        """Folder for new kernels."""
        return str(CACHE_FOLDER)

    def load_overload(self, signature: Any, context: Any) -> Any:
        """Kernel for the types of a call; None if none is stored.

        Machine code needs only numba's allocation of arrays. `context.refresh` loads the rest of the compiler, which
        takes 0.4 s, so it is called only to compile.
        """
        file = self._file(signature)
        found = (
            _read(shipped_folder(), file, is_as_safe_as_the_package)
            or _read(CACHE_FOLDER, file, is_private)
            or _taken_over(file)
        )
        if (
            found is None
            or found[0]["identity"] != identity()
            or found[0]["signature"] != _spelled(signature)
        ):
            return None
        rtsys.initialize(context)
        return CompileResult._rebuild(context, *pickle.loads(found[1]))

    def save_overload(self, signature: Any, compiled: Any) -> None:
        """Store a kernel."""
        parts = sorted(map(name_of, compiled.library.functions))
        kernel = dumps(compiled._reduce())
        head = {
            "identity": identity(),
            "signature": _spelled(signature),
            "parts": {name: fingerprint(name) for name in parts},
            "sha256": hashlib.sha256(kernel).hexdigest(),
        }
        _keep(CACHE_FOLDER / self._file(signature), (head, kernel))

    def _file(self, signature: Any) -> str:
        return f"{self._name}-{hashlib.sha256(_spelled(signature).encode()).hexdigest()[:16]}.nbc"


def _spelled(kind: Any) -> str:
    """Write types with the names of their fields. numba leaves them out, although a kernel finds a field by its
    position.
    """
    if isinstance(kind, types.BaseNamedTuple):
        named = kind.instance_class
        fields = (f"{name}: {_spelled(each)}" for name, each in zip(kind.fields, kind, strict=True))
        return f"{named.__module__}.{named.__qualname__}({', '.join(fields)})"
    if isinstance(kind, (tuple, types.BaseTuple)):
        return f"({', '.join(map(_spelled, kind))})"
    return str(kind)


_Stored = tuple[dict[str, Any], bytes]
"""The description of a kernel, and its pickle."""


def _read(folder: Path, file: str, safe: Callable[[Path], bool]) -> _Stored | None:
    """Read a kernel's file; None if it is missing, damaged, or writable by others."""
    path = folder / file
    if not path.exists() or not safe(folder):
        return None
    first, _, kernel = path.read_bytes().partition(b"\n")
    try:
        head = json.loads(first)
        whole = head["sha256"] == hashlib.sha256(kernel).hexdigest()
    except (ValueError, TypeError, KeyError):
        return None
    return (head, kernel) if whole else None


def _taken_over(file: str) -> _Stored | None:
    """Take over a kernel compiled from other sources if its own functions are unchanged, and store it for these
    sources too.
    """
    for folder in CACHE_FOLDER.parent.glob(f"kernels-*-{folder_name().rpartition('-')[2]}"):
        found = _read(folder, file, is_private) if folder != CACHE_FOLDER else None
        if found and all(part == fingerprint(name) != UNKNOWN for name, part in found[0]["parts"].items()):
            mine = {**found[0], "identity": identity()}, found[1]
            _keep(CACHE_FOLDER / file, mine)
            return mine
    return None


def _keep(path: Path, stored: _Stored) -> None:
    """Write a kernel's file in one step, so that no other process reads an incomplete one."""
    head, kernel = stored
    try:
        with NamedTemporaryFile(dir=path.parent, prefix=".", delete=False) as file:
            file.write(json.dumps(head).encode() + b"\n" + kernel)
        Path(file.name).replace(path)
    except OSError:  # a full disk: the kernel still serves this process
        Path(file.name).unlink(missing_ok=True)
