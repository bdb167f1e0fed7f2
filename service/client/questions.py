"""Questions to a study of a service: maps, curves, rankings and comparisons, each answered with a Dataset."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeVar

from damperlab.service.client.asked import Asked, explained, ids
from damperlab.studies.answers.shown import shown_axes
from damperlab.studies.field import Range
from damperlab.studies.questions import (
    MOST_DESIGNS,
    Design,
    Followed,
    Fragile,
    Judging,
    Plane,
    Ranking,
    Second,
    Selection,
    Subtracted,
    Tuning,
    Varied,
)
from damperlab.studies.vocabulary import Criterion, Excitation, Objective, Reduction

if TYPE_CHECKING:
    import xarray as xr

    from damperlab.service.client.answers import (
        Designs,
        Fragility,
        FrequencyResponse,
        Importance,
        ResonanceMap,
        TmdComparison,
        WorkPrecision,
    )

D = TypeVar("D", bound="xr.Dataset")


class Questions(Asked):
    """What a study is asked; a running one, too, with what is there.

    Where the study is given in SI units an answer holds its ratios in units too, as `amplitude_m` and `clearance_m`.
    """

    @cached_property
    def _definition(self) -> Mapping[str, Any]:
        definition: Mapping[str, Any] = self._ask("GET")["definition"]
        return definition

    def _in_units(self, answer: D) -> D:
        from damperlab.studies.answers.quantities import with_quantities

        return with_quantities(answer, self._definition)

    @explained(Plane, Selection, Subtracted)
    def resonance_map(
        self,
        x: str | None = None,
        y: str | None = None,
        metric: str | None = None,
        over: str | None = None,
        reduce: Reduction | None = None,
        interpolate: bool = False,
        minus: Asked | str | None = None,
        **at: float | str,
    ) -> "ResonanceMap":
        """Show one metric over two dimensions.

        The dimensions are those along which the study varies, clearance and friction first, if not given. Unless the
        frequency is given, or the record of a ground-motion suite, the largest value over all of them is shown.

        With ``minus``, a second study with the same axes, ``other`` holds its values and ``difference`` those of the first
        less those of the second; ``plot`` draws all three.

        Returns
        -------
        ResonanceMap
            See `damperlab.studies.answers.resonance_map` and `damperlab.studies.answers.map_difference`.
        """
        from damperlab.service.client.answers import read_map

        x, y = shown_axes(self._sizes, x, y, {*at, over})
        plane, selection = Plane(x, y, over, reduce), Selection(metric, at, interpolate)
        second = Subtracted(None if minus is None else ids(minus)[0])
        return self._in_units(read_map(self._question("resonance-map", plane, selection, second)))

    @explained(Followed, Second)
    def frequency_response(
        self,
        metric: str | None = None,
        interpolate: bool = False,
        with_: Asked | str | None = None,
        **at: float,
    ) -> "FrequencyResponse":
        """Follow one design along the frequency ratio.

        With a second study on the same frequencies, as the way down of a hysteresis, ``other`` holds its values,
        ``differs`` and the attribute ``apart`` where the two are different responses.

        Returns
        -------
        FrequencyResponse
            See `damperlab.studies.answers.frequency_response` and `damperlab.studies.answers.compared_response`.
        """
        from damperlab.service.client.answers import read_response

        second = Second(None if with_ is None else ids(with_)[0])
        selection = Followed(metric, at, interpolate)
        return self._in_units(read_response(self._question("frequency-response", selection, second)))

    @explained(Judging, Ranking)
    def optimal_designs(
        self,
        objective: Objective | None = None,
        band: Range | None = None,
        top: int | None = None,
        exclude_locked: bool = False,
        max_impact_speed: float | None = None,
        pareto: Sequence[str] | None = None,
        with_: Iterable[Asked | str] = (),
        metric: str | None = None,
        records: Sequence[str] | None = None,
        **ranges: Range,
    ) -> "Designs":
        """Rank designs over the frequencies of the study, the best first; dampers of a ground-motion suite by their worst case.

        Ten designs are listed by default, of a Pareto front all.

        Returns
        -------
        Designs
            See `optimal_designs`, `pareto`, `merged` and `suite` of `damperlab.studies.answers`.
        """
        from damperlab.service.client.answers import read_designs

        judging = Judging(objective, band, exclude_locked, max_impact_speed, ranges)
        ranking = Ranking(
            Ranking.top if pareto is None else MOST_DESIGNS,
            None if pareto is None else tuple(pareto),
            ids(with_),
            metric,
            None if records is None else tuple(records),
        )
        if top is not None:
            ranking = replace(ranking, top=top)
        return self._in_units(read_designs(self._question("optimal-designs", judging, ranking)))

    @explained(Tuning, Design)
    def tmd_comparison(
        self,
        criterion: Criterion = Tuning.criterion,
        mass_ratio: float | None = None,
        detuning: float = Tuning.detuning,
        damping_detuning: float = Tuning.damping_detuning,
        excitation: Excitation | None = Tuning.excitation,
        tmd_mass_ratio: float | None = None,
        **at: float,
    ) -> "TmdComparison":
        """Compare one design with a tuned mass damper.

        Returns
        -------
        TmdComparison
            See `damperlab.studies.answers.tmd_comparison`; the peaks and their ratio are attributes.
        """
        from damperlab.service.client.answers import read_tmd

        tuning = Tuning(criterion, mass_ratio, detuning, damping_detuning, excitation, tmd_mass_ratio)
        return self._in_units(read_tmd(self._question("tmd-comparison", tuning, Design(at))))

    @explained(Varied)
    def importance(self, metric: str | None = None, **ranges: Range) -> "Importance":
        """Share out the variance of a result over the grid: what each parameter explains alone, and what combinations do.

        Returns
        -------
        Importance
            See `damperlab.studies.answers.importance`.
        """
        from damperlab.service.client.answers import read_importance

        return read_importance(self._question("importance", Varied(metric, ranges)))

    @explained(Fragile)
    def fragility(
        self,
        threshold: float,
        metric: str | None = None,
        quantile: float = Fragile.quantile,
        **at: float | str,
    ) -> "Fragility":
        """Fit how likely a damper of a ground-motion suite exceeds a limit, as its records are scaled up.

        Returns
        -------
        Fragility
            See `damperlab.studies.answers.fragility`.
        """
        from damperlab.service.client.answers import read_fragility

        return read_fragility(self._question("fragility", Fragile(threshold, metric, quantile, at)))

    def work_precision(self) -> "WorkPrecision":
        """Sort the points by run time, and say how exact those of each time are.

        Returns
        -------
        WorkPrecision
            See `damperlab.studies.answers.work_precision`.
        """
        from damperlab.service.client.answers import read_precision

        return read_precision(self._question("work-precision"))
