"""Rank the designs of any kind of study by any criterion. All interfaces use this function."""

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING

from damperlab.studies.answers.optimal_designs import merged_designs, optimal_designs
from damperlab.studies.answers.pareto import pareto_front
from damperlab.studies.answers.particle_friction import has_friction_added, with_friction
from damperlab.studies.answers.query_fault import refused
from damperlab.studies.answers.suite import Motions, worst_case_designs
from damperlab.studies.faults import describe
from damperlab.studies.field import given
from damperlab.studies.kinds import HARMONIC, KINDS, Kind, kind_of
from damperlab.studies.questions import Judging, Ranking

if TYPE_CHECKING:
    import xarray as xr

Opened = Callable[[Iterable[str]], "Mapping[str, xr.Dataset]"]
"""Function that returns the cubes of the study and of the given follow-ups. The keys are ids; the study comes first."""


def ranked_designs(
    cube: "xr.Dataset",
    judging: Judging,
    ranking: Ranking,
    opened: Opened,
    motions: Motions | None = None,
) -> "xr.Dataset":
    """Rank the designs of a study, the best first.

    The designs of a ground-motion suite, or of a study over base amplitudes, are ranked by their worst case.

    Parameters
    ----------
    cube : Dataset
        The study's cube.
    judging, ranking : Judging, Ranking
        The criteria, and the further fields of the ranking, such as the follow-ups to include.
    opened : callable
        Function that returns the cubes of the study and of the follow-ups in the ranking.
    motions : callable, optional
        Function that returns the records of a ground-motion suite, by their ids. Without this function, no
        tuned mass damper is computed for a suite.

    Returns
    -------
    Dataset
        The answer of `merged_designs`, `pareto_front`, `optimal_designs` or `worst_case_designs`, with the result of
        `particle_friction.with_friction`.

    Raises
    ------
    QueryFault
        If the ranking function refuses the study, or if a field does not apply to this kind of study.
    """
    kind = kind_of(cube.sizes)
    _check_fields(kind, judging, ranking)
    if ranking.pareto is not None:
        return pareto_front(cube, ranking.pareto, judging, ranking.top)
    cubes = opened(ranking.with_) if ranking.with_ else {}
    rubbing = [each for each in cubes.values() if has_friction_added(each, cube)]
    merged = {name: each for name, each in cubes.items() if not has_friction_added(each, cube)}
    if kind is not HARMONIC:
        if len(merged) > 1:
            told = (
                "{field} may name only studies with friction of the particle, "
                f"because this study is {kind.words}."
            )
            allowed = "studies of the best damper with friction of its particle"
            raise refused("with", describe(",".join(ranking.with_)), allowed, kind.instead, told)
        ranked = worst_case_designs(cube, judging, ranking, motions)
    elif len(merged) > 1:
        ranked = merged_designs(merged, judging, ranking.top)
    else:
        ranked = optimal_designs(cube, judging, ranking.top)
    return with_friction(ranked, cube, judging, rubbing)


def _check_fields(kind: Kind, judging: Judging, ranking: Ranking) -> None:
    """Refuse fields that do not apply to the kind of study, and fields that cannot be combined."""
    for name in sorted((given(judging) | given(ranking)).keys() - kind.ranking):
        found = f"{kind.words}, to which it does not apply"
        others = " or ".join(each.words for each in KINDS if name in each.ranking)
        told = f"{{field}} applies to {others}, but this study is {kind.words}."
        raise refused(name.rstrip("_"), found, others, kind.instead, told)
    if ranking.pareto is not None and ranking.with_:
        raise refused(
            "with",
            describe(",".join(ranking.with_)),
            "no follow-up together with `pareto`",
            "leave one of the two out",
            "`with` and `pareto` cannot be combined.",
        )
