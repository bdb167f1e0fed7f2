"""Work-precision diagram: error against run time for the points of a study."""

from typing import TYPE_CHECKING

import numpy as np

from damperlab.studies.answers.selection import completeness, count, require_stored
from damperlab.studies.store.export.slabs import slabs
from damperlab.studies.variables import Status

if TYPE_CHECKING:
    import xarray as xr

TIME_BINS = 4
ERROR_BINS = 8
"""Number of bins per decade of the relative error."""
TIME_DECADES = (-9, 5)
"""Decades of the run time [s], from 1 ns to about a day. Other run times fall into the first or the last bin."""
ERROR_DECADES = (-18, 2)
QUANTILES = (0.1, 0.5, 0.9)


def work_precision(cube: "xr.Dataset") -> "xr.Dataset":
    """Sort the points of a study by run time, and return the distribution of errors for each run time.

    The cube is read slab by slab into a histogram of run time and relative error, so the required memory does not
    depend on the size of the cube.

    Returns
    -------
    Dataset
        Dimension `run_time`: centres of the non-empty bins of run time [s], four bins per decade. `number` is
        the number of points in a bin, and `max_cycles_share` is the share of these points that reached the cycle limit.
        `error_low`, `error_median` and `error_high` are the relative errors of the amplitude ratio that 10, 50 and 90
        per cent of the points do not exceed. Errors are resolved to eight bins per decade; 0 means an error below
        1e-18. Attributes: `complete`, `points`, `points_failed`, `seconds` (run time of all points), `note`.

    Raises
    ------
    QueryFault
        If the study stores no run times, errors or amplitudes.
    """
    require_stored(cube, "study", "run_time", "amplitude_error", "amplitude_ratio", otherwise="")
    times = TIME_BINS * (TIME_DECADES[1] - TIME_DECADES[0])
    # bin 0 holds errors below the first decade
    errors = ERROR_BINS * (ERROR_DECADES[1] - ERROR_DECADES[0]) + 1
    histogram = np.zeros((times, errors), np.int64)
    limited = np.zeros(times, np.int64)
    counts = np.zeros(3, np.int64)
    seconds = 0.0
    array = cube["status"]
    for slab in slabs(array.shape, array.encoding.get("chunks", array.shape)):
        index = dict(zip(array.dims, slab, strict=True))
        status = array.isel(index).values.ravel()
        counts += count(status)
        good = (status >= Status.CONVERGED) & (status <= Status.MAX_CYCLES)
        time, error, amplitude = (
            cube[name].isel(index).values.ravel()[good].astype(float)
            for name in ("run_time", "amplitude_error", "amplitude_ratio")
        )
        seconds += float(np.nansum(time))
        with np.errstate(divide="ignore", invalid="ignore"):
            row = np.floor((np.log10(time) - TIME_DECADES[0]) * TIME_BINS)
            column = np.floor((np.log10(error / amplitude) - ERROR_DECADES[0]) * ERROR_BINS) + 1
        known = ~(np.isnan(row) | np.isnan(column))
        row = np.clip(row[known], 0, times - 1).astype(int)
        column = np.clip(column[known], 0, errors - 1).astype(int)
        np.add.at(histogram, (row, column), 1)
        np.add.at(limited, row, status[good][known] == Status.MAX_CYCLES)
    return _answer(histogram, limited, {**completeness(counts), "seconds": seconds})


def _answer(histogram: np.ndarray, limited: np.ndarray, attributes: dict[str, object]) -> "xr.Dataset":
    import xarray as xr

    held = np.flatnonzero(histogram.any(axis=1))
    number = histogram[held].sum(axis=1)
    upper = 10.0 ** (ERROR_DECADES[0] + np.arange(histogram.shape[1]) / ERROR_BINS)
    upper[0] = 0.0
    running = histogram[held].cumsum(axis=1)
    relative = {"units": "1"}
    variables: dict[str, tuple[str, np.ndarray, dict[str, str]]] = {
        "number": ("run_time", number, {"units": "1", "long_name": "points of about this run time"})
    }
    for name, share in zip(("error_low", "error_median", "error_high"), QUANTILES, strict=True):
        place = (running >= share * number[:, None]).argmax(axis=1)
        long_name = f"relative error of the amplitude ratio that {share:.0%} of the points do not exceed"
        variables[name] = ("run_time", upper[place], {**relative, "long_name": long_name})
    variables["max_cycles_share"] = (
        "run_time",
        limited[held] / np.maximum(number, 1),
        {**relative, "long_name": "share of the points that reached the cycle limit"},
    )
    centres = 10.0 ** (TIME_DECADES[0] + (held + 0.5) / TIME_BINS)
    time = ("run_time", centres, {"units": "s", "long_name": "run time of a point"})
    total = int(number.sum())
    note = f"{total:,} points in {held.size} bins of run time." if total else "No point is computed yet."
    return xr.Dataset(variables, {"run_time": time}, {**attributes, "note": note})
