"""Identity of the computing code, so that a cube contains results of a single solver, whichever workers computed it."""

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
"""Functions of the C library that kernels and closed forms use."""
_ARGUMENTS = tuple(8.0 * ((k * (math.sqrt(5.0) - 1.0) / 2.0) % 1.0) for k in range(1, 1001))
"""Arguments of these functions, spread evenly over 0 to 8. The values of two versions of the C library differ at 1 to
10 of these 1,000 arguments.
"""


class WrongCode(RuntimeError):
    """Code that differs from the study's, so that its results would belong to another version."""


@cache
def code_hash() -> str:
    """Hash of every Python source of `worker` and `studies`; it must be equal for a coordinator and its workers.

    Unlike the kernels' own hash, it covers plan, cost, store and tasks too. If two sides divided or stored blocks
    differently, they would damage a cube, as two solvers would.

    Returns
    -------
    str
        64 hex digits; the same on every machine with the same sources, whatever its line endings.
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
    """Version of the distribution, for display; the hash decides.

    Returns
    -------
    str
        As in the package's metadata, or "uninstalled" if the sources run without being installed.
    """
    try:
        return version(DISTRIBUTION)
    except PackageNotFoundError:
        return "uninstalled"


def identity() -> dict[str, str]:
    """The identity that a worker reports.

    Returns
    -------
    dict of str
        `version`, `sources` (the hash) and `host`.
    """
    return {"version": code_version(), "sources": code_hash(), "host": socket.gethostname()}


@cache
def target() -> str:
    """Target of the kernels, and the versions of the C library's functions in use.

    Kernels of one target have the same machine code on every processor, and the part of a result that numpy computes
    has the same bits everywhere (`damperlab.studies.portable`). Exponentials and sines come from the C library.

    Returns
    -------
    str
        As in "x86-64-v3 x86_64-unknown-linux-gnu, libm 0123abcd".
    """
    # imported here, because it imports the compiler
    from damperlab.worker.kernel_cache import identity as identity_of_kernels

    return f"{identity_of_kernels()['target']}, libm {libm()}"


@cache
def libm() -> str:
    """Hash of values of the C library's functions, 8 hex digits.

    A C library has several versions of a function, whose last bits differ, and selects one for the processor:
    glibc's are the same on all processors with AVX2 and FMA. The name and version of the library do not show the
    selection.
    """
    digest = hashlib.sha256()
    for function in _FUNCTIONS:
        digest.update(np.array([function(x) for x in _ARGUMENTS]).astype("<f8").tobytes())
    return digest.hexdigest()[:8]


@cache
def computing() -> dict[str, str]:
    """Everything that determines the bits of a result in this process, with descriptions.

    Returns
    -------
    dict of str
        `identity` is equal for two processes whose results are equal to the last bit: `solver` (its sources and its
        compilers), `target` and `libc`. The other values describe the same for display.
    """
    from damperlab.worker.kernel_cache import source_hash

    facts = {**environment(), "kernels": source_hash(), "solver": solver(), "target": target()}
    versions = ("solver_version", "python", "numpy", "numba", "llvmlite")
    kept = (*versions, "machine", "processor", "libc", "kernels", "solver", "target")
    return {name: facts[name] for name in kept} | {"identity": identity_of(facts)}


def provenance() -> dict[str, str]:
    """Everything that a reader of a cube needs to compute it again.

    Returns
    -------
    dict of str
        The result of `damperlab.studies.store.provenance`, `sources` (a hash of all code that computes and stores),
        and `computing` of this process.
    """
    return {**environment(), "sources": code_hash(), **computing()}


def one_identity(answers: Mapping[str, Mapping[str, str]]) -> Mapping[str, str]:
    """Give the common `computing` of all workers of a cluster.

    Parameters
    ----------
    answers : mapping
        `computing()` of every worker, by its address; at least one.

    Raises
    ------
    WrongCode
        If two would not give the same bits: a cube belongs to one solver on one kind of processor.
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
    """Refuse to compute for a study whose cube was started by another solver, or on another kind of processor.

    Parameters
    ----------
    expected : str
        The study's identity.

    Raises
    ------
    WrongCode
        The message names this host and its solver.
    """
    if expected != computing()["identity"]:
        raise WrongCode(
            f"the worker on {socket.gethostname()} would not give the same bits as the study's other blocks: it has "
            f"{_words(computing())}, identity {computing()['identity']}, but the study has {expected}; use "
            "workers of one kind for a study"
        )


def _words(facts: Mapping[str, str]) -> str:
    """Describe the solver, for display."""
    return (
        f"{DISTRIBUTION} {facts.get('solver_version', 'unknown')} with solver {facts.get('solver', 'unknown')} "
        f"on {facts.get('target', 'an unknown processor')}, libc {facts.get('libc', 'unknown')}"
    )


def require_solver(study_id: str, recorded: Mapping[str, str]) -> None:
    """Refuse to recompute blocks of another solver, before they are invalidated.

    Parameters
    ----------
    study_id : str
        The study.
    recorded : mapping of str
        Its provenance.

    Raises
    ------
    WrongCode
        With the solver of the cube, the one here, and the remedy.
    """
    if is_outdated(recorded):
        raise _begun_otherwise(study_id, recorded, computing())


def require_begun_alike(study_id: str, recorded: Mapping[str, str], now: Mapping[str, str]) -> None:
    """Refuse to continue a cube that another solver, or another kind of processor, started.

    Parameters
    ----------
    study_id : str
        The study.
    recorded, now : mapping of str
        Its provenance, and `computing()` of the available workers.

    Raises
    ------
    WrongCode
        With the solver of the cube, the one here, and the remedy.
    """
    if recorded.get("identity") != now["identity"]:
        raise _begun_otherwise(study_id, recorded, now)


def _begun_otherwise(study_id: str, recorded: Mapping[str, str], now: Mapping[str, str]) -> WrongCode:
    return WrongCode(
        f"the study was started by {_words(recorded)}, but this is {_words(now)}: finish it with the "
        f"former, or compute a new version with `damperlab recompute {study_id}`"
    )


def require_code(expected: str) -> None:
    """Refuse to compute for a coordinator whose sources differ.

    Parameters
    ----------
    expected : str
        The coordinator's `code_hash()`.

    Raises
    ------
    WrongCode
        The message names this host, its sources and the expected ones.
    """
    if expected != code_hash():
        raise WrongCode(
            f"the worker on {socket.gethostname()} holds {DISTRIBUTION} {code_version()} with sources "
            f"{code_hash()[:12]}, but the study is run by sources {expected[:12]}: "
            f"install the same version on both and restart the worker"
        )
