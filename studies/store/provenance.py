"""Provenance of a study: solver, machine, user and time."""

import getpass
import json
import os
import platform
from collections.abc import Mapping
from contextvars import ContextVar
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TypeVar

SUBMITTED_BY = "submitted_by"
"""Key of the owner in a study's provenance."""
REFINES = "refines"
"""Key in the provenance of a refinement study; the value is the id of the study whose best design is refined."""
DESIGNS = "designs"
"""Key in the provenance of a study that a design search requested; the value is the digest of the specification."""
ASKED_BY_PROGRAMS = (REFINES, DESIGNS)
"""Keys in the provenance of studies that the program submitted itself. Such a study has one of these keys."""

PRIVATE = ("host", "user", SUBMITTED_BY)
"""Keys of the provenance that are not written to published files."""

submitter: ContextVar[str | None] = ContextVar("submitter", default=None)
"""Owner of the studies that are submitted in this context; None if no access key is used."""

Value = TypeVar("Value")

_PACKAGES = (
    "numpy",
    "numba",
    "llvmlite",
    "dask",
    "distributed",
    "xarray",
    "zarr",
    "numcodecs",
    "sqlalchemy",
)


def signed(provenance: Mapping[str, Value]) -> dict[str, Value | str]:
    """Return a study's provenance with the owner added, if the owner is known."""
    owner = submitter.get()
    return dict(provenance) if owner is None else {**provenance, SUBMITTED_BY: owner}


def published(provenance: str) -> str:
    """Remove the names of the host, the user and the access key's owner from a provenance in JSON."""
    return json.dumps({name: value for name, value in json.loads(provenance).items() if name not in PRIVATE})


def asked_by(provenance: Mapping[str, str]) -> dict[str, str | None]:
    """Return a study's owner and purpose as values of the catalogue's columns; None if unknown."""
    purpose = next((each for each in ASKED_BY_PROGRAMS if each in provenance), None)
    return {
        "submitted_by": provenance.get(SUBMITTED_BY),
        "purpose": purpose,
        "purpose_of": provenance[purpose] if purpose else None,
    }


def provenance() -> dict[str, str]:
    """Collect everything needed to repeat a study: versions, machine, cores, user and time.

    Returns
    -------
    dict of str
        `solver_version` is the version of damperlab. The version of any other package has the package's name
        as its key. The last bits of a sine may depend on `processor` and `libc`. Seeds are part of the
        study's definition.
    """
    found = {"solver_version": version_of("damperlab"), "python": platform.python_version()}
    found |= {name: version_of(name) for name in _PACKAGES}
    found["machine"] = f"{platform.system()} {platform.machine()}"
    found["processor"] = _processor()
    found["libc"] = " ".join(part for part in platform.libc_ver() if part) or "unknown"
    found["host"] = platform.node()
    found["cores"] = str(os.cpu_count() or "unknown")
    found["user"] = _user()
    found["time"] = datetime.now(UTC).isoformat(timespec="seconds")
    return found


@cache
def version_of(package: str) -> str:
    """Return the version of a package, or "not installed"."""
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


@cache
def _processor() -> str:
    # on Linux the name of the processor is in a file that `platform` does not read
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(names, "") or platform.processor() or "unknown"


def _user() -> str:
    try:
        return getpass.getuser()
    except (KeyError, OSError):
        # a process in a container may have a user id without a name
        return f"uid {os.getuid()}"
