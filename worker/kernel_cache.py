"""Cache of compiled kernels, in the package and in the user's cache folder, where new kernels are stored.

The path of a kernel's file depends on the name of the kernel, on the types of the arguments, and on
everything that determines the bits of the kernel (`identity`). The location and the date of the sources do
not matter, so a kernel that was compiled elsewhere can be loaded. After a change of other sources, a kernel
is reused if the `fingerprint` of each of its functions is unchanged.

A file begins with a line of JSON with the identity of the kernel and the hash of the other bytes. A file with a wrong
hash is ignored. The rest of the file is a pickle, and loading a pickle can run any code. So a file is loaded
only from a folder to which nobody but the user, or the installer of the package, can write.
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

from damperlab.studies.store.solver import hash_of
from damperlab.worker.compiler.numba_read import ALONE
from damperlab.worker.compiler.target import PROCESSOR, TRIPLE
from damperlab.worker.fingerprint import UNKNOWN, fingerprint, name_of

_HERE = Path(__file__).parent
_COMPILER = ("worker/compiler", "worker/jit.py")
_KERNELS = ("physics", "solver", "steady", "rk4.py", "accuracy/march.py")
_SOURCES = (*_COMPILER, *(f"worker/{name}" for name in _KERNELS), "studies/variables.py")
"""Sources that determine the kernels: the compiler, the solver, and the module with the codes of response class and
status.
"""
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
    """Return the hash of the code in `_SOURCES`, 16 hex digits."""
    return hash_of(_HERE.parent, _SOURCES)[:16]


@cache
def identity() -> dict[str, str]:
    """Return all values that determine the bits of a kernel. A stored kernel is loaded only if its values are equal.

    Returns
    -------
    dict of str
        `sources` and `compiler` are hashes of the sources of kernels (`source_hash`) and of the compiler. `target` is
        the processor and platform for which kernels are compiled. `numba`, `llvmlite`, `numpy` and `python` are
        versions. `options` are the settings of numba.
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
    """Return the name of the folder for kernels of this identity.

    The name contains the hash of the sources, and a hash of the other values of `identity`.
    """
    rest = sorted(pair for pair in identity().items() if pair[0] != "sources")
    return f"kernels-{source_hash()}-{hashlib.sha256(repr(rest).encode()).hexdigest()[:8]}"


def shipped_folder() -> Path:
    """Return the folder for kernels that are installed with the package. The folder need not exist."""
    return _HERE / "kernels" / folder_name()


def is_private(folder: Path) -> bool:
    """Whether only this user and the superuser can write in a folder, or replace the folder or its parents."""
    if not hasattr(os, "getuid"):  # without POSIX permissions, folders are assumed to be private
        return True
    trusted = (0, os.getuid())
    try:
        places = [place.stat() for place in (folder.resolve(), *folder.resolve().parents)]
    except OSError:
        return False
    if places[0].st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        return False
    # in a sticky folder such as /tmp, users cannot rename files of other users
    open_modes = (place.st_mode & (stat.S_IWGRP | stat.S_IWOTH) for place in places)
    return all(
        place.st_uid in trusted and (not writable or place.st_mode & stat.S_ISVTX)
        for place, writable in zip(places, open_modes, strict=True)
    )


def is_as_safe_as_the_package(folder: Path) -> bool:
    """Whether only users with write access to the sources of the package can write in a folder."""
    try:
        inside, package = folder.stat(), _HERE.stat()
    except OSError:
        return False
    loose = stat.S_IWGRP | stat.S_IWOTH
    return inside.st_uid in (0, package.st_uid) and not inside.st_mode & loose & ~package.st_mode


def cache_folder() -> Path:
    """Return the folder for kernels that are compiled on this machine.

    Returns
    -------
    Path
        An existing folder: the first private and writable folder of three candidates. The first candidate is under
        DAMPERLAB_CACHE_DIR or, without this variable, under the cache folder of the user. The second candidate is under
        the temporary folder, and the third is a new temporary folder for this process.
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
    """Disk cache for the kernels of one function, with the interface of numba's caches.

    Parameters
    ----------
    function : callable
        Plain Python function of the kernel.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        self._name = f"{function.__module__.rpartition('worker.')[2]}.{function.__qualname__}"
        source = Path(inspect.getfile(function)).resolve()
        # the identity does not include the source of a kernel outside the package
        if not source.is_relative_to(_HERE.resolve()) and source.exists():
            self._name += f".{hashlib.sha256(source.read_bytes()).hexdigest()[:8]}"

    @property
    def cache_path(self) -> str:
        """Folder in which new kernels are stored."""
        return str(CACHE_FOLDER)

    def load_overload(self, signature: Any, context: Any) -> Any:
        """Return the stored kernel for the types of a call, or None.

        `context.refresh` is not called, because it takes 0.4 s and is needed only before a compilation.
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
    """Return types as text, including the field names, which numba omits."""
    if isinstance(kind, types.BaseNamedTuple):
        named = kind.instance_class
        fields = (f"{name}: {_spelled(each)}" for name, each in zip(kind.fields, kind, strict=True))
        return f"{named.__module__}.{named.__qualname__}({', '.join(fields)})"
    if isinstance(kind, (tuple, types.BaseTuple)):
        return f"({', '.join(map(_spelled, kind))})"
    return str(kind)


_Stored = tuple[dict[str, Any], bytes]
"""Description and pickle of a kernel."""


def _read(folder: Path, file: str, safe: Callable[[Path], bool]) -> _Stored | None:
    """Read the file of a kernel. Return None if the file is missing or damaged, or its folder is not safe."""
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
    """Load a kernel compiled from other sources if its own functions are unchanged.

    The kernel is then stored under the present identity.
    """
    for folder in CACHE_FOLDER.parent.glob(f"kernels-*-{folder_name().rpartition('-')[2]}"):
        found = _read(folder, file, is_private) if folder != CACHE_FOLDER else None
        if found and all(part == fingerprint(name) != UNKNOWN for name, part in found[0]["parts"].items()):
            mine = {**found[0], "identity": identity()}, found[1]
            _keep(CACHE_FOLDER / file, mine)
            return mine
    return None


def _keep(path: Path, stored: _Stored) -> None:
    """Write the file of a kernel in one step, so that no other process reads an incomplete file."""
    head, kernel = stored
    try:
        with NamedTemporaryFile(dir=path.parent, prefix=".", delete=False) as file:
            file.write(json.dumps(head).encode() + b"\n" + kernel)
        Path(file.name).replace(path)
    except OSError:  # on a full disk, only this process can use the kernel
        Path(file.name).unlink(missing_ok=True)
