"""Methods that submit follow-up studies of a study, for example around the best design."""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from damperlab.service.client.asked import Asked, explained, parameters, values_of
from damperlab.service.client.results import Refinement
from damperlab.studies.field import Range
from damperlab.studies.questions import Boundary, FollowUps, Judging, Search, Step
from damperlab.studies.vocabulary import Objective

if TYPE_CHECKING:
    from damperlab.service.client.study import Study


class Searches(Asked, ABC):
    """Methods that submit follow-up studies of a study."""

    @abstractmethod
    def _handle(self, document: Mapping[str, Any]) -> "Study":
        """Return the study that a record of the service describes."""

    @explained(Search, Judging, FollowUps)
    def refine(
        self,
        tolerance: float = Search.tolerance,
        objective: Objective | None = None,
        band: Range | None = None,
        exclude_locked: bool = False,
        max_impact_speed: float | None = None,
        with_: Iterable[Asked | str] = (),
        dry_run: bool = False,
        value_tolerance: float = Search.value_tolerance,
        budget: int = Search.budget,
        **ranges: Range,
    ) -> Refinement:
        """Submit follow-up studies where a better design may lie.

        If the best design is known accurately enough, nothing is submitted.

        Returns
        -------
        Refinement
            State of the search. Wait for the submitted studies, ``follow_ups``; then call this method again,
            with the studies as ``with_``.
        """
        return self._search("/refine", (Search, Judging, FollowUps), locals())

    @explained(Boundary, Step, FollowUps)
    def refine_boundary(
        self,
        along: str,
        tolerance: float = Step.tolerance,
        with_: Iterable[Asked | str] = (),
        dry_run: bool = False,
        **at: float,
    ) -> Refinement:
        """Submit a follow-up study around a change of the response class.

        If the value at which the class changes is known accurately enough, nothing is submitted.

        Returns
        -------
        Refinement
            State of the search. Wait for the submitted studies, ``follow_ups``; then call this method again,
            with the studies as ``with_``.
        """
        return self._search("/refine-boundary", (Boundary, Step, FollowUps), locals())

    @explained(Judging, FollowUps)
    def particle_friction(
        self,
        objective: Objective | None = None,
        band: Range | None = None,
        exclude_locked: bool = False,
        max_impact_speed: float | None = None,
        with_: Iterable[Asked | str] = (),
        dry_run: bool = False,
        **ranges: Range,
    ) -> Refinement:
        """Submit studies in which friction acts on the particle of the best damper.

        Returns
        -------
        Refinement
            State of the search. Wait for the submitted studies, ``follow_ups``, then pass them to `optimal_designs` as
            ``with_``.
        """
        return self._search("/particle-friction", (Judging, FollowUps), locals())

    def _search(self, path: str, asks: Iterable[type], given: Mapping[str, Any]) -> Refinement:
        answer = self._ask("POST", path, params=parameters(*values_of(asks, given)))
        names = ("known", "found", "steps", "points", "fine_points", "note")
        studies = tuple(self._handle(each) for each in answer.get("follow_ups", ()))
        more = {
            "spent": answer["spent"],
            "follow_ups": studies,
            "follow_up": studies[0] if studies else None,
        }
        return Refinement(**{name: answer[name] for name in names}, **more)
