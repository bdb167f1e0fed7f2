"""One ranking over a study and its follow-ups."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from damperlab.studies.answers.band import default_objective
from damperlab.studies.answers.design_question import DESIGN
from damperlab.studies.answers.faults import QueryFault
from damperlab.studies.answers.optimal_designs import optimal_designs
from damperlab.studies.faults import Fault, counted


def merged_designs(
    cubes: Mapping[str, xr.Dataset],
    objective: str | None = None,
    band: tuple[float, float] | None = None,
    top: int = 10,
    exclude_locked: bool = False,
    max_impact_speed: float | None = None,
    ranges: Mapping[str, tuple[float, float]] | None = None,
) -> xr.Dataset:
    """Rank the designs of several studies together, each judged at the frequencies of its own study.

    Parameters
    ----------
    cubes : mapping of Dataset
        By the study's id; the first is the study that was refined. A follow-up that holds no design in
        `ranges` adds nothing.
    objective, band, top, exclude_locked, max_impact_speed, ranges
        As in `optimal_designs`, resolved for the first study.

    Returns
    -------
    Dataset
        As of `optimal_designs`, with `study`, the id each design was found in; a design that several studies
        hold stands once. Flatness and left-out counts are those of the first study.

    Raises
    ------
    QueryFault
        As `optimal_designs` on the first study, or where another one was judged at other frequencies.
    """
    ids = list(cubes)
    objective = objective or default_objective(cubes[ids[0]], band)
    rest = (objective, band, top, exclude_locked, max_impact_speed)
    answers = {ids[0]: optimal_designs(cubes[ids[0]], *rest, ranges)}
    first = answers[ids[0]]
    for name in ids[1:]:
        try:
            answers[name] = optimal_designs(cubes[name], *rest, ranges)
        except QueryFault as error:
            if error.fault.field in set(ranges or {}).intersection(DESIGN):
                continue
            raise
        same = ("band", "frequencies")
        if [answers[name].attrs[key] for key in same] != [first.attrs[key] for key in same]:
            low, high = answers[name].attrs["band"]
            found = f"{name}, judged at {counted(answers[name].attrs['frequencies'], 'frequency ratio')} {low:g} to {high:g}"
            advice = "name follow-ups of this study, refined with the same objective and band"
            raise QueryFault(Fault("with", found, "studies at the same frequencies", advice))
    parts = [
        answer.assign(study=("rank", np.full(answer.sizes["rank"], name))) for name, answer in answers.items()
    ]
    joined = xr.concat(parts, "rank", combine_attrs="override", join="outer")
    order = np.argsort(joined["value"].values, kind="stable")
    seen: set[tuple[float, ...]] = set()
    kept = []
    for place in order.tolist():
        design = tuple(float(joined[name].values[place]) for name in DESIGN)
        if design not in seen:
            seen.add(design)
            kept.append(place)
    answer = joined.isel(rank=kept[:top]).assign_coords(rank=np.arange(1, min(top, len(kept)) + 1))
    answer["study"].attrs["long_name"] = "study that holds the design"
    answer.attrs["studies"] = ids
    answer.attrs["note"] = f"{first.attrs['note']} Merged with {counted(len(ids) - 1, 'follow-up')}."
    return answer
