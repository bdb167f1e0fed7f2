"""A survey computed: every design under every record at every scale, on all cores."""

import itertools
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from studies.ground.survey import AXES, Survey
from studies.variables import Status
from worker.cluster import core_count
from worker.ground.comparison import spread
from worker.ground.design import Damper, Structure
from worker.ground.response import GroundResponse, ground_response, made_ready

UNITS: dict[str, str] = {
    "scale": "1",
    "natural_frequency_hz": "Hz",
    "damping_ratio": "1",
    "restitution": "1",
    "particle_mass_kg": "kg",
    "clearance_m": "m",
    "friction_force_n": "N",
}
_BY_SUFFIX = (("_m_s2", "m s-2"), ("_m_s", "m s-1"), ("_m", "m"), ("_j", "J"), ("_s", "s"))
_SPREAD = ("peak_relative_displacement_lowest_m", "peak_relative_displacement_highest_m", "growth")

Progress = Callable[[int, int], None]


def run_survey(survey: Survey, progress: Progress | None = None, threads: int | None = None) -> xr.Dataset:
    """Compute a survey.

    Parameters
    ----------
    survey : Survey
        What is asked.
    progress : callable, optional
        Told points done and points in all, now and then.
    threads : int, optional
        Threads; one a core by default. The kernels hold no lock, and every point has the same bits whatever the number.

    Returns
    -------
    Dataset
        Dimensions `record` and `AXES`, all present; every value of `GroundResponse` with its unit; with perturbed starts
        lowest and highest peak and the growth of the perturbation.
    """
    names = [*GroundResponse.__dataclass_fields__, *(_SPREAD if survey.starts else ())]
    flat = {name: np.full(survey.points, np.nan) for name in names}
    done = 0
    # one task for each record and structure: what its runs share is made once
    with ThreadPoolExecutor(threads or core_count()) as pool:
        for place, rows in pool.map(lambda task: _row(survey, *task), _tasks(survey)):
            for name in names:
                flat[name].reshape(survey.shape)[place] = rows[name]
            done += rows[names[0]].size
            if progress is not None:
                progress(done, survey.points)
    dims = ("record", *AXES)
    data = {}
    for name, column in flat.items():
        values = column.astype(np.int64) if name in ("impacts", "status") else column
        data[name] = xr.Variable(
            dims, values.reshape(survey.shape), {"units": _unit(name), "long_name": _words(name)}
        )
    coordinates: dict[str, object] = {"record": list(survey.records)}
    for axis, values in survey.axes.items():
        coordinates[axis] = xr.Variable((axis,), values, {"units": UNITS[axis]})
    attributes = {
        "name": survey.name,
        "records": "; ".join(f"{key}: {motion.source}" for key, motion in survey.records.items()),
        **survey.numbers,
    }
    return xr.Dataset(data, coordinates, attributes)


Place = tuple[int, slice, int, int]


def _tasks(survey: Survey) -> Iterator[tuple[int, int, int]]:
    return itertools.product(
        range(len(survey.records)),
        range(len(survey.axes["natural_frequency_hz"])),
        range(len(survey.axes["damping_ratio"])),
    )


def _row(
    survey: Survey, record: int, frequency: int, damping: int
) -> tuple[Place, dict[str, NDArray[np.float64]]]:
    """All scales and dampers of one record and one structure."""
    motion = list(survey.records.values())[record]
    axes = survey.axes
    structure = Structure(
        survey.numbers["mass_kg"],
        float(axes["natural_frequency_hz"][frequency]),
        float(axes["damping_ratio"][damping]),
    )
    tail = survey.numbers["tail_s"]
    ready = made_ready(structure, motion, 1.0, tail)
    varied = [
        axes[name] for name in ("scale", "restitution", "particle_mass_kg", "clearance_m", "friction_force_n")
    ]
    shape = tuple(len(values) for values in varied)
    found: dict[str, list[float]] = {}
    for scale, restitution, mass, clearance, force in itertools.product(*(v.tolist() for v in varied)):
        damper = Damper(force, mass, clearance, restitution)
        response = ground_response(structure, damper, motion, scale, tail, None, ready)
        values: dict[str, float] = dict(response.values())
        if survey.starts:
            over = spread(
                structure, damper, motion, response, scale, tail, survey.starts,
                survey.numbers["perturbation_m"], survey.seed,
            )  # fmt: skip
            peak = over["peak_relative_displacement_m"]
            values |= dict(zip(_SPREAD, (peak["lowest"], peak["highest"], over["growth"]), strict=True))
        for name, value in values.items():
            found.setdefault(name, []).append(value)
    rows = {name: np.array(column, dtype=float).reshape(shape) for name, column in found.items()}
    return (record, slice(None), frequency, damping), rows


def _unit(name: str) -> str:
    if name in ("impacts", "status", "growth"):
        return "1"
    return next((unit for suffix, unit in _BY_SUFFIX if name.endswith(suffix)), "1")


def _words(name: str) -> str:
    for suffix, _ in _BY_SUFFIX:
        name = name.removesuffix(suffix)
    return name.replace("_", " ")


def best_designs(
    answer: xr.Dataset, metric: str = "peak_relative_displacement_m", top: int = 10
) -> xr.Dataset:
    """Rank the dampers of a survey by their worst case over its records, scales and structures.

    Parameters
    ----------
    answer : Dataset
        Of `run_survey`.
    metric : str
        A value of `GroundResponse`.
    top : int
        How many.

    Returns
    -------
    Dataset
        Dimension `rank`: `restitution`, `particle_mass_kg`, `clearance_m`, `friction_force_n` and `worst`. A point that
        failed rules its damper out.
    """
    good = answer[metric].where(answer["status"] == Status.CONVERGED, np.inf)
    worst = good.max(("record", "scale", "natural_frequency_hz", "damping_ratio"))
    stacked = worst.stack(point=worst.dims)
    order = np.argsort(stacked.values, kind="stable")[:top]
    chosen = stacked.isel(point=order)
    columns = {str(name): ("rank", chosen[name].values) for name in worst.dims}
    return xr.Dataset({**columns, "worst": ("rank", chosen.values, answer[metric].attrs)})
