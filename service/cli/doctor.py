"""The command doctor: what works on this machine, each thing tried for real."""

import platform
import shutil
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
ENERGY_TOLERANCE = 1e-9
CYCLES = 20
SHOWN_VERSIONS = (
    "solver_version",
    "python",
    "numpy",
    "numba",
    "dask",
    "distributed",
    "xarray",
    "zarr",
    "sqlalchemy",
)


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
        "closed form": _closed_form,
        "kernels": _kernels,
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

    found = provenance()
    return ", ".join(f"{name} {found[name]}" for name in SHOWN_VERSIONS)


def _cores() -> str:
    from worker.cluster import core_count

    return f"{core_count()} usable, {platform.machine()}"


def _closed_form() -> str:
    """Compare one linear point with the transmissibility at resonance, √(1 + 4ζ²)/(2ζ)."""
    from math import sqrt

    from worker.simulate import Design, simulate

    found = float(simulate(Design(LINEAR_DAMPING_RATIO, 1.0)).metrics["amplitude_ratio"])
    exact = sqrt(1 + (2 * LINEAR_DAMPING_RATIO) ** 2) / (2 * LINEAR_DAMPING_RATIO)
    if not abs(found / exact - 1) < CLOSED_FORM_TOLERANCE:
        raise ArithmeticError(
            f"X/Z of the bare structure at resonance is {found!r}, in closed form {exact!r}"
        )
    return f"X/Z = {found:.10g} of the bare structure at resonance, as it must be"


def _kernels() -> str:
    """Compile or load the hybrid kernel, and check that it keeps the balance of energy."""
    from worker.jit import CACHE_FOLDER
    from worker.simulate import Design, simulate
    from worker.solver.scene import Particle

    began = time.perf_counter()
    particle = Particle(clearance_ratio=5.0, restitution=0.47, mass_ratio=0.1)
    metrics = simulate(Design(LINEAR_DAMPING_RATIO, 1.0, 0.3, particle), cycles=CYCLES).metrics
    residual = float(metrics["energy_residual"])
    if not residual < ENERGY_TOLERANCE:
        raise ArithmeticError(
            f"after {CYCLES} cycles the energy is out of balance by {residual:.3g} of the work done"
        )
    files = sum(1 for _ in CACHE_FOLDER.rglob("*.nbc"))
    took = time.perf_counter() - began
    return f"ready in {took:.1f} s, energy balanced to {residual:.1g}; {files} compiled in {CACHE_FOLDER}"


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
