"""Response of the recommended damper over the band, under amplitudes within and beyond the specified range."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from typing_extensions import TypedDict

from damperlab.studies.design.found import Found
from damperlab.studies.shapes import Number, Numbers
from damperlab.studies.specification.excitation import Amplitude

if TYPE_CHECKING:
    import xarray as xr

SAME = 1e-9
"""Relative difference within which an amplitude equals an end of the range."""


class OverBand(TypedDict):
    """The response of a damper over the band under one amplitude."""

    amplitude: Number
    amplitude_units: str
    asked: bool
    frequency_ratio: Numbers
    frequency_hz: Numbers | None
    value: Numbers
    ratio: Numbers
    units: str
    worst: Number
    worst_ratio: Number
    worst_frequency_ratio: Number
    worst_frequency_hz: Number


def backbone_document(found: Found) -> list[OverBand]:
    """Return the response of the nominal damper under amplitudes of the binding excitation, the smallest first.

    Returns
    -------
    list of dict
        `amplitude` is the amplitude of the base motion or force, in `amplitude_units`. `asked` is True if the amplitude
        is within the specified range. `frequency_ratio`, `frequency_hz`, the `value` of the measure, and its `ratio` to
        the base amplitude or the static displacement are lists over the band. `worst` is the judged value;
        `worst_ratio` is the largest ratio, at `worst_frequency_ratio` and `worst_frequency_hz`. Frequencies in hertz
        are None without units.
    """
    return [_under(found, each) for each in found.shown]


def _under(found: Found, amplitude: Amplitude) -> OverBand:
    asked, excitation = found.asked, amplitude.excitation
    curve = found.book.curve(found.build, amplitude)
    values = curve.measured
    ratios = values / (curve.base_m * curve.rate**asked.measure.order)
    place = int(values.argmax())
    hertz = asked.structure.natural_frequency_hz if asked.in_units else None
    # an rms over the band has no frequency
    peak = None if asked.measure.mean else float(curve.r[place])
    low, high = excitation.lowest_m * (1.0 - SAME), excitation.highest_m * (1.0 + SAME)
    return {
        "amplitude": asked.level(amplitude) if asked.in_units else amplitude.reference_m,
        "amplitude_units": excitation.motion.unit if asked.in_units else "1",
        "asked": low <= amplitude.reference_m <= high,
        "frequency_ratio": curve.r.tolist(),
        "frequency_hz": None if hertz is None else (hertz * curve.r).tolist(),
        "value": values.tolist(),
        "ratio": ratios.tolist(),
        "units": asked.unit,
        "worst": curve.judged,
        "worst_ratio": None if peak is None else float(ratios[place]),
        "worst_frequency_ratio": peak,
        "worst_frequency_hz": None if peak is None or hertz is None else hertz * peak,
    }


def backbone_dataset(rows: Sequence[Mapping[str, Any]]) -> "xr.Dataset":
    """Return, as a Dataset, the responses in the entry `amplitudes` of an answer.

    Parameters
    ----------
    rows : sequence of mapping
        The entry `amplitudes` of an answer. The value None stands for a failed response.

    Returns
    -------
    Dataset
        `value` and `ratio` have the dimensions `amplitude` and `frequency_ratio`. Every amplitude has
        additional frequencies around its own peak, so values are NaN at frequencies that were not computed
        for an amplitude. `worst`, `worst_ratio`, `worst_frequency_ratio` and `asked` have the dimension
        `amplitude` alone; `asked` is true for amplitudes within the specified range.
    """
    import xarray as xr

    r = sorted({each for row in rows for each in row["frequency_ratio"]})
    grids: dict[str, Any] = {}
    for name in ("value", "ratio"):
        grid = np.full((len(rows), len(r)), np.nan)
        for filled, row in zip(grid, rows, strict=True):
            filled[np.searchsorted(r, row["frequency_ratio"])] = np.array(row[name], dtype=float)
        grids[name] = (("amplitude", "frequency_ratio"), grid)
    for name in ("worst", "worst_ratio", "worst_frequency_ratio"):
        grids[name] = ("amplitude", np.array([row[name] for row in rows], dtype=float))
    grids["asked"] = ("amplitude", np.array([row["asked"] for row in rows], dtype=bool))
    answer = xr.Dataset(grids, {"amplitude": [row["amplitude"] for row in rows], "frequency_ratio": r})
    for row in rows[:1]:
        answer["amplitude"].attrs["units"] = row["amplitude_units"]
        for name in ("value", "worst"):
            answer[name].attrs["units"] = row["units"]
        if row["frequency_hz"] is not None:
            hertz = row["frequency_hz"][-1] / row["frequency_ratio"][-1]
            answer = answer.assign_coords(
                frequency_hz=("frequency_ratio", hertz * np.array(r), {"units": "Hz"})
            )
    return answer
