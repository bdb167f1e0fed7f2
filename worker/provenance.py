"""Identity of the code that computes a cube, which ensures that all blocks come from the same solver."""

import hashlib
import math
import socket
from collections.abc import Callable, Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np

from damperlab.studies.store.provenance import provenance as environment
from damperlab.studies.store.solver import identity_of, is_outdated, solver

DISTRIBUTION = "damperlab"

_FUNCTIONS: tuple[Callable[[float], float], ...] = (
    *(
        math.exp,
        math.expm1,
        math.log,
        math.log1p,
        math.sin,
        math.cos,
        math.tan,
        math.sinh,
        math.cosh,
        math.tanh,
    ),
    lambda x: math.pow(x, 1.0 / 3.0),
    lambda x: float(np.hypot(1.0, x)),
)
"""Functions of the C library that kernels and closed forms call."""
_ARGUMENTS = tuple(8.0 * ((k * (math.sqrt(5.0) - 1.0) / 2.0) % 1.0) for k in range(1, 1001))
"""Arguments for these functions, spread evenly from 0 to 8.

Two versions of the library return different values at 1 to 10 of the 1000 arguments.
"""


class WrongCode(RuntimeError):
    """Raised if the code differs from the code of a study, because new results would not match."""


@cache
def code_hash() -> str:
    """Return the hash of all Python sources in `worker` and `studies`.

    A coordinator and its workers must have equal hashes. The hash covers more than the kernels, because a coordinator
    and a worker that divide or store blocks differently would damage a cube.

    Returns
    -------
    str
        Hash of 64 hex digits, equal for equal sources on all machines. Line endings have no effect.
    """
    root = Path(__file__).parent.parent
    digest = hashlib.sha256()
    for source in sorted((*(root / "worker").rglob("*.py"), *(root / "studies").rglob("*.py"))):
        text = source.read_bytes().replace(b"\r\n", b"\n")
        digest.update(f"{source.relative_to(root).as_posix()}\n{len(text)}\n".encode())
        digest.update(text)
    return digest.hexdigest()


@cache
def code_version() -> str:
    """Return the version of the package for display. To compare code, use `code_hash`.

    Returns
    -------
    str
        Version in the metadata of the package, or "uninstalled" if the package is not installed.
    """
    try:
        return version(DISTRIBUTION)
    except PackageNotFoundError:
        return "uninstalled"


def identity() -> dict[str, str]:
    """Return the `version`, the `sources` (hash) and the `host` that a worker reports."""
    return {"version": code_version(), "sources": code_hash(), "host": socket.gethostname()}


@cache
def target() -> str:
    """Return the target of the kernels, and a hash that identifies the functions of the C library.

    For one target, kernels have the same machine code on every processor, and numpy computes the same bits
    (`damperlab.studies.portable`). However, exponentials and sines come from the C library, and may differ between
    processors.

    Returns
    -------
    str
        Text such as "x86-64-v3 x86_64-unknown-linux-gnu, libm 0123abcd".
    """
    # imported locally, because this module imports the compiler
    from damperlab.worker.kernel_cache import identity as identity_of_kernels

    return f"{identity_of_kernels()['target']}, libm {libm()}"


@cache
def libm() -> str:
    """Return a hash (8 hex digits) of values that functions of the C library compute.

    A C library selects a version of each function for the processor, and the versions differ in the last bits. glibc
    selects the same versions on all processors with AVX2 and FMA. Name and version number of the library do not show
    this selection.
    """
    digest = hashlib.sha256()
    for function in _FUNCTIONS:
        digest.update(np.array([function(x) for x in _ARGUMENTS]).astype("<f8").tobytes())
    return digest.hexdigest()[:8]


@cache
def computing() -> dict[str, str]:
    """Return all values that determine the bits of results in this process, with descriptions.

    Returns
    -------
    dict of str
        `identity` is a hash of `solver` (sources and compilers), `target` and `libc`. Processes with equal identities
        compute equal bits. The other values are for display.
    """
    from damperlab.worker.kernel_cache import source_hash

    facts = {**environment(), "kernels": source_hash(), "solver": solver(), "target": target()}
    versions = ("solver_version", "python", "numpy", "numba", "llvmlite")
    kept = (*versions, "machine", "processor", "libc", "kernels", "solver", "target")
    return {name: facts[name] for name in kept} | {"identity": identity_of(facts)}


def provenance() -> dict[str, str]:
    """Return all values that are needed to reproduce a cube.

    Returns
    -------
    dict of str
        Result of `damperlab.studies.store.provenance`, `sources` (a hash of all code that computes and stores), and
        `computing` of this process.
    """
    return {**environment(), "sources": code_hash(), **computing()}


def one_identity(answers: Mapping[str, Mapping[str, str]]) -> Mapping[str, str]:
    """Return the result of `computing` that all workers of a cluster share.

    Parameters
    ----------
    answers : mapping
        Results of `computing`, by the addresses of the workers; at least one.

    Raises
    ------
    WrongCode
        If two workers have different identities.
    """
    first, *others = sorted(answers)
    for other in others:
        if answers[other]["identity"] != answers[first]["identity"]:
            raise WrongCode(
                f"the workers do not compute the same bits: {first} has {_words(answers[first])}, "
                f"{other} has {_words(answers[other])}; use workers of one kind for a study"
            )
    return answers[first]


def require_identity(expected: str) -> None:
    """Refuse to compute if the cube of a study was started by another solver, or on another kind of processor.

    Parameters
    ----------
    expected : str
        Identity of the study.

    Raises
    ------
    WrongCode
        If the identities differ. The message names this host and its solver.
    """
    if expected != computing()["identity"]:
        raise WrongCode(
            f"the worker on {socket.gethostname()} {other_bits(computing(), expected)}; use workers of one kind "
            "for a study"
        )


def other_bits(facts: Mapping[str, str], expected: str) -> str:
    """Say why a worker cannot compute for a study with the identity `expected`.

    The text continues a sentence whose subject is the worker.

    `facts` is the result of `computing` at the worker.
    """
    return (
        f"would not give the same bits as the study's other blocks: it has {_words(facts)}, "
        f"identity {facts['identity']}, but the study has {expected}"
    )


def _words(facts: Mapping[str, str]) -> str:
    """Return a description of the solver for display."""
    return (
        f"{DISTRIBUTION} {facts.get('solver_version', 'unknown')} with solver {facts.get('solver', 'unknown')} "
        f"on {facts.get('target', 'an unknown processor')}, libc {facts.get('libc', 'unknown')}"
    )


def require_solver(study_id: str, recorded: Mapping[str, str]) -> None:
    """Refuse to recompute blocks of a study if another solver has computed its other blocks.

    Parameters
    ----------
    study_id : str
        Id of the study.
    recorded : mapping of str
        Provenance of the study.

    Raises
    ------
    WrongCode
        If the solvers differ. The message names both solvers and the remedy.
    """
    if is_outdated(recorded):
        raise _begun_otherwise(study_id, recorded, computing())


def require_begun_alike(study_id: str, recorded: Mapping[str, str], now: Mapping[str, str]) -> None:
    """Refuse to continue a cube that was started by another solver, or on another kind of processor.

    Parameters
    ----------
    study_id : str
        Id of the study.
    recorded, now : mapping of str
        Provenance of the study, and `computing()` of the workers.

    Raises
    ------
    WrongCode
        If the identities differ. The message names both solvers and the remedy.
    """
    if recorded.get("identity") != now["identity"]:
        raise _begun_otherwise(study_id, recorded, now)


def _begun_otherwise(study_id: str, recorded: Mapping[str, str], now: Mapping[str, str]) -> WrongCode:
    return WrongCode(
        f"the study was started by {_words(recorded)}, but this is {_words(now)}: finish it with the "
        f"former, or compute a new version with `damperlab recompute {study_id}`"
    )


def require_code(expected: str) -> None:
    """Refuse to compute for a coordinator whose source code differs.

    Parameters
    ----------
    expected : str
        `code_hash()` of the coordinator.

    Raises
    ------
    WrongCode
        If the sources differ. The message states the name of this host and the hashes of both sources.
    """
    if expected != code_hash():
        raise WrongCode(
            f"the worker on {socket.gethostname()} holds {DISTRIBUTION} {code_version()} with sources "
            f"{code_hash()[:12]}, but the study is run by sources {expected[:12]}: "
            f"install the same version on both and restart the worker"
        )
