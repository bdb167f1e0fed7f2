"""`damperlab doctor` tests whether the program works on this machine."""

import platform
import shutil
import time
import uuid
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Annotated

import typer

from damperlab.service.cli.failures import FAILED
from damperlab.service.cli.options import AsJson, DataDir, Scheduler, StoreAddress
from damperlab.service.cli.output import print_json, print_table, working
from damperlab.service.cli.store import settings_of
from damperlab.studies.vocabulary import DEFAULTS
from damperlab.worker.cores import core_count

if TYPE_CHECKING:
    from damperlab.service.settings import Settings

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
    """The result of one test.

    Parameters
    ----------
    name : str
        Name of the tested item.
    ok : bool
        Whether the item works.
    found : str
        Result of the test in words.
    """

    name: str
    ok: bool
    found: str


def doctor(
    data_dir: DataDir = None,
    place: StoreAddress = None,
    scheduler: Scheduler = None,
    cluster: Annotated[
        bool, typer.Option(help="Also start, or connect to, a Dask cluster; this takes some seconds.")
    ] = True,
    as_json: AsJson = False,
) -> None:
    """Check this machine: versions, cores, kernels, store, cluster."""
    tries: dict[str, Callable[[], str]] = {
        "versions": _versions,
        "cores": _cores,
        "closed form": _closed_form,
        "kernels": _kernels,
        "store": lambda: _store(settings_of(data_dir, store=place)),
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
    except Exception as error:  # any exception means that the test failed
        return Check(name, False, f"{type(error).__name__}: {error}")


def _versions() -> str:
    from damperlab.worker.provenance import provenance

    found = provenance()
    return ", ".join(f"{name} {found[name]}" for name in SHOWN_VERSIONS)


def _cores() -> str:
    return f"{core_count()} usable, {platform.machine()}"


def _closed_form() -> str:
    """Compute the response at resonance without a damper, and compare it with the closed form √(1 + 4ζ²)/(2ζ)."""
    from math import sqrt

    from damperlab.worker.point import Design
    from damperlab.worker.simulate import simulate

    found = float(simulate(Design(DEFAULTS["damping_ratio"], 1.0)).metrics["amplitude_ratio"])
    exact = sqrt(1 + (2 * DEFAULTS["damping_ratio"]) ** 2) / (2 * DEFAULTS["damping_ratio"])
    if not abs(found / exact - 1) < CLOSED_FORM_TOLERANCE:
        raise ArithmeticError(
            f"X/Z of the bare structure at resonance is {found!r}, in closed form {exact!r}"
        )
    return f"X/Z of the bare structure at resonance is {found:.10g}, as it must be"


def _kernels() -> str:
    """Compile or load the kernel with friction and a particle, and check the energy balance of a run."""
    from damperlab.worker.jit import CACHE_FOLDER, shipped_folder
    from damperlab.worker.point import Design
    from damperlab.worker.simulate import simulate
    from damperlab.worker.solver.particle import Particle

    began = time.perf_counter()
    particle = Particle(clearance_ratio=5.0, restitution=0.47, mass_ratio=0.1)
    metrics = simulate(Design(DEFAULTS["damping_ratio"], 1.0, 0.3, particle), cycles=CYCLES).metrics
    residual = float(metrics["energy_residual"])
    if not residual < ENERGY_TOLERANCE:
        raise ArithmeticError(
            f"after {CYCLES} cycles the energy is out of balance by {residual:.3g} of the work done"
        )
    files = sum(1 for _ in CACHE_FOLDER.rglob("*.nbc"))
    shipped = sum(1 for _ in shipped_folder().glob("*.nbc"))
    took = time.perf_counter() - began
    return (
        f"ready in {took:.1f} s, energy balanced to {residual:.1g}; {shipped} kernel files in the package, "
        f"{files} in {CACHE_FOLDER}"
    )


def _store(settings: "Settings") -> str:
    """Open the store, and write, read and remove a file at the location of the cubes."""
    store = settings.open_store()
    try:
        store.page(1)
        trial = f"doctor-{uuid.uuid4().hex}.partial"
        began = time.perf_counter()
        try:
            store.shelf.put(trial, trial.encode())
            if store.shelf.get(trial) != trial.encode():
                raise OSError(f"{store.shelf.address} gives back bytes that differ from those written")
        finally:
            store.shelf.remove(trial)
        took = time.perf_counter() - began
        used, quota = store.usage(), store.quota
        trouble = store.trouble()
    finally:
        store.close()
    if trouble is not None:
        raise OSError(trouble)
    free = shutil.disk_usage(settings.data_dir).free
    return (
        f"catalogue {store.catalogue.name}, {free / 1e9:.1f} GB free; cubes in {store.shelf.address}, "
        f"written, read and removed there in {1e3 * took:.0f} ms; studies take "
        f"{used.bytes / 1e9:.3g} GB{_of(quota.bytes, 1e9, 'GB')} (before compression) "
        f"and {used.points} points{_of(quota.points, 1, '')}"
    )


def _of(limit: int | None, unit: float, name: str) -> str:
    return "" if limit is None else f" of {limit / unit:.6g} {name} allowed".replace("  ", " ")


def _cluster(scheduler: str | None) -> str:
    from damperlab.worker.cluster.cluster import connect

    began = time.perf_counter()
    with connect(scheduler=scheduler) as client:
        threads = sum(client.nthreads().values())
    return f"{threads} worker threads, up and checked in {time.perf_counter() - began:.1f} s"
