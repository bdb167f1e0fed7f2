"""Identity of the solver: a hash of the solver's sources and of the versions of its compiler."""

import hashlib
import platform
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path

from damperlab.studies.store.provenance import version_of

SOURCES: tuple[str, ...] = (
    "studies/amplitudes.py",
    "studies/axes.py",
    "studies/cavity.py",
    "studies/choices.py",
    "studies/consistency.py",
    "studies/contact.py",
    "studies/definition.py",
    "studies/ground/motion.py",
    "studies/ground/quantities.py",
    "studies/ground/source.py",
    "studies/ground/suite.py",
    "studies/ground/suite_reading.py",
    "studies/ground/variables.py",
    "studies/physical.py",
    "studies/plan.py",
    "studies/portable.py",
    "studies/presets.py",
    "studies/quantity.py",
    "studies/spacing.py",
    "studies/static_displacement.py",
    "studies/variables.py",
    "studies/vocabulary.py",
    "worker/block.py",
    "worker/compiler",
    "worker/ground",
    "worker/jit.py",
    "worker/kernel_arguments.py",
    "worker/physics",
    "worker/rk4.py",
    "worker/solver",
    "worker/steady",
    "worker/worker_process/tasks.py",
)
"""Source files and folders that determine the values of a block for a given study."""

COMPILERS: tuple[str, ...] = ("numba", "llvmlite", "numpy")

_QUOTES = '"' * 3


@cache
def solver() -> str:
    """Return a hash of the solver's sources, and of the versions of Python, numba, llvmlite and numpy.

    Comments and docstrings do not change the hash. No package is imported, so a reader of results needs no compiler.

    Returns
    -------
    str
        16 hex digits, the same on every machine with the same sources and packages. Line endings have no effect.
    """
    python = "python " + ".".join(platform.python_version_tuple()[:2])
    compilers = (f"{name} {version_of(name)}" for name in COMPILERS)
    parts = (hash_of(Path(__file__).parents[2], SOURCES), python, *compilers)
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:16]


def is_outdated(recorded: Mapping[str, str]) -> bool:
    """Whether the provenance of results names a solver other than today's, or no solver."""
    return recorded.get("solver") != solver()


def identity_of(provenance: Mapping[str, str]) -> str:
    """Return a hash of the solver, the compilation target and the C library, which determine the bits of the results.

    Returns
    -------
    str
        16 hex digits; empty if the provenance does not state the solver or the target.
    """
    parts = [provenance.get(name, "") for name in ("solver", "target", "libc")]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:16] if all(parts[:2]) else ""


def hash_of(root: Path, names: Iterable[str]) -> str:
    """Return the SHA-256 hash of the code in source files.

    Parameters
    ----------
    root : Path
        Folder of the package.
    names : iterable of str
        Paths of files and folders, relative to `root`. All sources in a folder are included.

    Returns
    -------
    str
        64 hex digits. Line endings have no effect.
    """
    digest = hashlib.sha256()
    for name in names:
        place = root / name
        for source in sorted(place.rglob("*.py")) if place.is_dir() else [place]:
            text = "\n".join(computing_lines(source.read_text(encoding="utf-8")))
            digest.update(f"{source.relative_to(root).as_posix()}\n{len(text)}\n{text}".encode())
    return digest.hexdigest()


def computing_lines(text: str) -> Iterator[str]:
    """Yield the lines of code in a source. Comments, blank lines and all docstrings, also of constants, are left out.

    A line that begins with three quotes starts a docstring. A comment after code is kept if the line has a double
    quote, because the # may then be part of a string.
    """
    prose = string = False
    for line in text.splitlines():
        bare = line.strip()
        if prose:
            prose = _QUOTES not in bare
        elif not string and bare.startswith((_QUOTES, "r" + _QUOTES)):
            prose = bare.count(_QUOTES) == 1
        elif string or (bare and not bare.startswith("#")):
            string ^= bare.count(_QUOTES) % 2 == 1
            yield line if string or '"' in line else line.partition("  #")[0].rstrip()
