"""By what, on what, by whom and when a study is computed."""

import getpass
import os
import platform
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version

_PACKAGES = ("numpy", "numba", "dask", "distributed", "xarray", "zarr", "sqlalchemy")


def provenance() -> dict[str, str]:
    """Collect what someone needs to repeat a study: versions, machine, cores, user and time.

    Returns
    -------
    dict of str
        `solver_version` is this project's own version; the package versions go by the packages' names.
    """
    found = {"solver_version": _version("damperlab"), "python": platform.python_version()}
    found |= {name: _version(name) for name in _PACKAGES}
    found["machine"] = f"{platform.system()} {platform.machine()}"
    found["host"] = platform.node()
    found["cores"] = str(os.cpu_count() or "unknown")
    found["user"] = _user()
    found["time"] = datetime.now(UTC).isoformat(timespec="seconds")
    return found


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


def _user() -> str:
    try:
        return getpass.getuser()
    except (KeyError, OSError):
        # a container may run under a number that has no name
        return f"uid {os.getuid()}"
