"""Identity of the solver: its sources and compiler, so that results of another solver are recognised."""

import hashlib
import platform
from collections.abc import Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from damperlab.studies.store.sources import hash_of

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
"""Every source file that can change a bit of a block's values, for a given definition of the study."""

COMPILERS: tuple[str, ...] = ("numba", "llvmlite", "numpy")


@cache
def solver() -> str:
    """Identity of the solver, 16 hex digits: its sources, and the versions of Python, numba, llvmlite and numpy.

    It is read from files and from the packages' metadata: nothing is imported, so a reader of results needs no
    compiler. Comments and docstrings do not count.

    Returns
    -------
    str
        The same on every machine with the same sources and packages, whatever its line endings.
    """
    python = "python " + ".".join(platform.python_version_tuple()[:2])
    parts = (hash_of(Path(__file__).parents[2], SOURCES), python, *_compilers())
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:16]


def is_outdated(recorded: Mapping[str, str]) -> bool:
    """Whether results with this provenance belong to another solver than today's; results without an identity count as
    such.
    """
    return recorded.get("solver") != solver()


def identity_of(provenance: Mapping[str, str]) -> str:
    """Hash what determines the bits of a point: the solver, the target for which it is compiled, and the C library.

    Returns
    -------
    str
        16 hex digits; empty if the provenance does not state the solver or the target.
    """
    parts = [provenance.get(name, "") for name in ("solver", "target", "libc")]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:16] if all(parts[:2]) else ""


def _compilers() -> list[str]:
    found = []
    for name in COMPILERS:
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            found.append(f"{name} not installed")
    return found
