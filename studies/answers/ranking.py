"""One question for the best designs, whatever the kind of study and whatever is ranked: the same behind every door."""

from collections.abc import Callable, Iterable, Mapping

import xarray as xr

from damperlab.studies.answers.faults import QueryFault
from damperlab.studies.answers.merged import merged_designs
from damperlab.studies.answers.optimal_designs import optimal_designs
from damperlab.studies.answers.pareto import pareto_front
from damperlab.studies.answers.survey import worst_case_designs
from damperlab.studies.faults import Fault, describe
from damperlab.studies.field import given
from damperlab.studies.questions import Judging, Ranking
from damperlab.studies.registry import is_survey

Opened = Callable[[Iterable[str]], Mapping[str, xr.Dataset]]
"""Opens the study and its follow-ups, by id, the study first."""


def ranked_designs(cube: xr.Dataset, judging: Judging, ranking: Ranking, opened: Opened) -> xr.Dataset:
    """Rank the designs of a study, the best first; the dampers of a ground-motion suite by their worst case.

    Parameters
    ----------
    cube : Dataset
        The study's cube.
    judging, ranking : Judging, Ranking
        What is asked.
    opened : callable
        Gives the cubes of the study and of the follow-ups that are ranked with it.

    Returns
    -------
    Dataset
        Of `merged_designs`, `pareto_front`, `optimal_designs` or `worst_case_designs`.

    Raises
    ------
    QueryFault
        As those, and for what the kind of study does not know.
    """
    if is_survey(cube.sizes):
        _refuse(given(judging).keys() - {"ranges"} | given(ranking).keys() & {"pareto", "with_"}, SUITE)
        return worst_case_designs(cube, ranking.metric, ranking.top, ranking.records, judging.ranges)
    _refuse(given(ranking).keys() & {"metric", "records"}, HARMONIC)
    if ranking.pareto is not None and ranking.with_:
        found = describe(",".join(ranking.with_))
        raise QueryFault(Fault("with", found, "nothing where `pareto` is given", "leave one of the two out"))
    if ranking.pareto is not None:
        return pareto_front(cube, ranking.pareto, judging).isel(rank=slice(ranking.top))
    if ranking.with_:
        return merged_designs(opened(ranking.with_), judging, ranking.top)
    return optimal_designs(cube, judging, ranking.top)


SUITE = (
    "what applies to a ground-motion suite: `metric`, `record`, and ranges of its dimensions",
    "leave it out: dampers are ranked by their worst case over records, scales and structures",
)
HARMONIC = (
    "what applies to a harmonic study, such as `objective` and `band`",
    "leave it out: it applies to ground-motion suites only",
)


def _refuse(names: Iterable[str], words: tuple[str, str]) -> None:
    """Refuse what only the other kind of study knows."""
    for name in sorted(names):
        raise QueryFault(Fault(name.rstrip("_"), "a value", *words))
