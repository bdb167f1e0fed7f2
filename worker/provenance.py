"""Which code computes, so that a cube holds the work of one solver, whatever workers it came from."""

import hashlib
import socket
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from damperlab.studies.store.provenance import provenance as environment
from damperlab.worker.jit import source_hash

DISTRIBUTION = "damperlab"


class WrongCode(RuntimeError):
    """Other code than the study's: what it would compute belongs to another version."""


@cache
def code_hash() -> str:
    """Hash of every Python source of `worker` and `studies`: what a coordinator and its workers must share.

    Unlike the kernels' own hash, it covers plan, cost, store and tasks too, for two sides that cut or store
    blocks differently spoil a cube as surely as two solvers do.

    Returns
    -------
    str
        64 hex digits; the same on every machine that holds the same sources, whatever its line endings.
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
    """Version of the distribution, for people; the hash is what decides.

    Returns
    -------
    str
        As in the package's metadata, or "uninstalled" where the sources run without being installed.
    """
    try:
        return version(DISTRIBUTION)
    except PackageNotFoundError:
        return "uninstalled"


def identity() -> dict[str, str]:
    """What a worker answers when it is asked who it is.

    Returns
    -------
    dict of str
        `version`, `sources` (the hash) and `host`.
    """
    return {"version": code_version(), "sources": code_hash(), "host": socket.gethostname()}


def provenance() -> dict[str, str]:
    """Everything that a reader of a cube needs to compute it again.

    Returns
    -------
    dict of str
        What `damperlab.studies.store.provenance` collects, and two hashes: `sources` of all that computes and stores,
        `kernels` of the solver alone.
    """
    return {**environment(), "sources": code_hash(), "kernels": source_hash()}


def require_solver(recorded: dict[str, str]) -> None:
    """Refuse to go on with a cube that another solver began: one cube, one solver.

    Parameters
    ----------
    recorded : dict of str
        The study's provenance; one without `kernels` is taken as it is.

    Raises
    ------
    WrongCode
        Saying what began the cube, what is here and what to do.
    """
    theirs, ours = recorded.get("kernels"), source_hash()
    if theirs is not None and theirs != ours:
        raise WrongCode(
            f"the study was begun by {DISTRIBUTION} {recorded.get('solver_version', 'unknown')} "
            f"with kernels {theirs}, and this is {code_version()} with kernels {ours}: "
            f"finish it with the former, or delete it and start again"
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
        Naming this host, what it holds and what was expected.
    """
    if expected != code_hash():
        raise WrongCode(
            f"the worker on {socket.gethostname()} holds {DISTRIBUTION} {code_version()} with sources "
            f"{code_hash()[:12]}, but the study is run by sources {expected[:12]}: "
            f"install the same version on both and restart the worker"
        )
