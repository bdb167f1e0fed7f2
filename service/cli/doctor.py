"""The command doctor: what works on this machine, each thing tried for real."""

import platform
import shutil
import tempfile
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated

import typer

from service.cli.failures import FAILED
from service.cli.options import AsJson, DataDir, Scheduler
from service.cli.output import print_json, print_table, working
from service.cli.store import data_folder

LINEAR_DAMPING_RATIO = 0.0038
CLOSED_FORM_TOLERANCE = 1e-9


@dataclass(frozen=True)
class Check:
    """One thing that was tried.

    Parameters
    ----------
    name : str
        What.
    ok : bool
        Whether it works.
    found : str
        What was found.
    """

    name: str
    ok: bool
    found: str


def doctor(
    data_dir: DataDir = None,
    scheduler: Scheduler = None,
    cluster: Annotated[
        bool, typer.Option(help="Also start (or reach) a Dask cluster; takes some seconds.")
    ] = True,
    as_json: AsJson = False,
) -> None:
    """Try what the program needs on this machine: versions, cores, kernels, store, cluster."""
    tries: dict[str, Callable[[], str]] = {
        "versions": _versions,
        "cores": _cores,
        "kernel cache": _kernel_cache,
        "solver": _solver,
        "store": lambda: _store(data_folder(data_dir)),
    }
    if cluster:
        tries["cluster"] = lambda: _cluster(scheduler)
    checks = []
    for name, attempt in tries.items():
        with working(f"Trying: {name}"):
            checks.append(_check(name, attempt))
    ok = all(check.ok for check in checks)
    if as_json:
        print_json({"ok": ok, "checks": [asdict(check) for check in checks]})
    else:
        print_table(("what", "works", "found"), ((c.name, "yes" if c.ok else "NO", c.found) for c in checks))
    if not ok:
        raise typer.Exit(FAILED)


def _check(name: str, attempt: Callable[[], str]) -> Check:
    try:
        return Check(name, True, attempt())
    except Exception as error:  # whatever it is, it is the finding
        return Check(name, False, f"{type(error).__name__}: {error}")


def _versions() -> str:
    from worker.provenance import provenance

    return ", ".join(f"{name} {text[:12]}" for name, text in provenance().items())


def _cores() -> str:
    from worker.cluster import core_count

    return f"{core_count()} usable, {platform.machine()}"


def _kernel_cache() -> str:
    from worker.jit import cache_folder

    folder = cache_folder()
    with tempfile.TemporaryFile(dir=folder):
        pass
    return f"{folder}, {sum(1 for _ in folder.rglob('*.nbc'))} compiled kernels"


def _solver() -> str:
    """Compare one linear point with its closed form, model equation X/Z at r = 1."""
    from math import sqrt

    from worker.simulate import Design, simulate

    began = time.perf_counter()
    design = Design(
        damping_ratio=LINEAR_DAMPING_RATIO, frequency_ratio=1.0, friction_ratio=0.0, particle=None
    )
    found = float(simulate(design).metrics["amplitude_ratio"])
    exact = sqrt(1 + (2 * LINEAR_DAMPING_RATIO) ** 2) / (2 * LINEAR_DAMPING_RATIO)
    if not abs(found / exact - 1) < CLOSED_FORM_TOLERANCE:
        raise ArithmeticError(
            f"X/Z of the undamped scene at resonance is {found!r}, its closed form {exact!r}"
        )
    return f"X/Z = {found:.10g} at resonance as in closed form, in {time.perf_counter() - began:.1f} s"


def _store(folder: Path) -> str:
    from studies.store.store import Store

    store = Store.open(folder)
    try:
        store.page(1)
    finally:
        store.close()
    free = shutil.disk_usage(folder).free
    return f"{folder}, {free / 1e9:.1f} GB free"


def _cluster(scheduler: str | None) -> str:
    from worker.cluster import connect

    began = time.perf_counter()
    with connect(scheduler=scheduler) as client:
        threads = sum(client.nthreads().values())
    return f"{threads} worker threads, up and checked in {time.perf_counter() - began:.1f} s"
