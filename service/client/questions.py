"""Questions to a study of a service: maps, curves, rankings and comparisons, each answered with a Dataset."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property
from inspect import Parameter, Signature
from typing import TYPE_CHECKING, Any, cast

from damperlab.service.client.asked import Asked, explained, parameters, values_of
from damperlab.service.questions.every import EVERY
from damperlab.service.questions.fragility import FRAGILITY
from damperlab.service.questions.frequency_response import FREQUENCY_RESPONSE
from damperlab.service.questions.optimal_designs import OPTIMAL_DESIGNS
from damperlab.service.questions.question import A, Question
from damperlab.service.questions.resonance_map import RESONANCE_MAP
from damperlab.service.questions.tmd_comparison import TMD_COMPARISON
from damperlab.service.questions.work_precision import WORK_PRECISION
from damperlab.studies.field import Range
from damperlab.studies.kinds import shown_axes
from damperlab.studies.questions import MOST_DESIGNS, Fragile, Ranking, Tuning
from damperlab.studies.vocabulary import Criterion, Excitation, Objective, Reduction

if TYPE_CHECKING:
    from damperlab.service.client.answers import (
        Answer,
        Designs,
        Fragility,
        FrequencyResponse,
        ResonanceMap,
        TmdComparison,
        WorkPrecision,
    )


class Questions(Asked):
    """Methods that evaluate the present results of a study, and return Datasets.

    If the study is given in SI units, the Datasets contain quantities in SI units as well as ratios, for example
    `amplitude_m` and `clearance_m`.
    """

    @cached_property
    def _definition(self) -> Mapping[str, Any]:
        definition: Mapping[str, Any] = self._ask("GET")["definition"]
        return definition

    def _answer(self, question: Question[A], given: Mapping[str, Any]) -> A:
        """Send a question and read its answer. Arguments that are not fields of the question are ignored."""
        from damperlab.service.client.answers import read
        from damperlab.studies.answers.quantities import with_quantities

        document = self._ask("GET", f"/{question.route}", params=parameters(*values_of(question.asks, given)))
        answer = cast("Answer", read(question, document))
        return cast(A, with_quantities(answer, self._definition))

    @explained(*RESONANCE_MAP.asks)
    def resonance_map(
        self,
        x: str | None = None,
        y: str | None = None,
        metric: str | None = None,
        over: str | None = None,
        reduce: Reduction | None = None,
        minus: Asked | str | None = None,
        **at: float | str,
    ) -> "ResonanceMap":
        """Return one metric over two dimensions.

        By default the map spans the dimensions along which the study varies, clearance and friction first. The map
        shows the value at a given frequency or record. If none is given, the map shows the largest value over all
        frequencies or records.

        If ``minus`` names a second study with the same axes, ``other`` holds the values of the second study, and
        ``difference`` holds the first study minus the second. ``plot`` then draws all three maps.

        Returns
        -------
        ResonanceMap
            See `damperlab.studies.answers.resonance_map` and `damperlab.studies.answers.map_difference`.
        """
        x, y = shown_axes(self._sizes, x, y, {*at, over})
        return self._answer(RESONANCE_MAP, locals())

    @explained(*FREQUENCY_RESPONSE.asks)
    def frequency_response(
        self,
        metric: str | None = None,
        with_: Asked | str | None = None,
        **at: float,
    ) -> "FrequencyResponse":
        """Return one metric of one design over the frequency ratio.

        If ``with_`` names a second study at the same frequencies, for example a downward sweep through a hysteresis,
        ``other`` holds the values of the second study. ``differs`` and the attribute ``apart`` mark the frequencies at
        which the two responses differ.

        Returns
        -------
        FrequencyResponse
            See `damperlab.studies.answers.frequency_response` and `damperlab.studies.answers.compared_response`.
        """
        return self._answer(FREQUENCY_RESPONSE, locals())

    @explained(*OPTIMAL_DESIGNS.asks)
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
        """Rank the designs of a study, the best first.

        A design is judged over the frequencies of the study; under a ground-motion suite, a damper is judged by its worst
        case. By default a ranking lists ten designs, and a Pareto front lists all of its designs.

        Returns
        -------
        Designs
            See `optimal_designs`, `pareto`, `merged` and `suite` of `damperlab.studies.answers`.
        """
        if top is None:
            top = Ranking.top if pareto is None else MOST_DESIGNS
        return self._answer(OPTIMAL_DESIGNS, locals())

    @explained(*TMD_COMPARISON.asks)
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
        return self._answer(TMD_COMPARISON, locals())

    @explained(*FRAGILITY.asks)
    def fragility(
        self,
        threshold: float,
        metric: str | None = None,
        quantile: float = Fragile.quantile,
        **at: float | str,
    ) -> "Fragility":
        """Fit the probability that a damper's response exceeds a limit, as a function of the scale of the records.

        The study must be a ground-motion suite.

        Returns
        -------
        Fragility
            See `damperlab.studies.answers.fragility`.
        """
        return self._answer(FRAGILITY, locals())

    def work_precision(self) -> "WorkPrecision":
        """Return the errors of a study's points, as a distribution for each run time.

        Returns
        -------
        WorkPrecision
            See `damperlab.studies.answers.work_precision`.
        """
        return self._answer(WORK_PRECISION, {})


def _untyped(question: Question[Any]) -> Callable[..., Any]:
    """Make an untyped method for a question for which `Questions` defines no method."""
    fields = sorted(
        (each for each in question.fields if "client" in each.doors), key=lambda each: each.is_named
    )
    parameters = [Parameter("self", Parameter.POSITIONAL_OR_KEYWORD)]
    for each in fields:
        kind = Parameter.VAR_KEYWORD if each.is_named else Parameter.KEYWORD_ONLY
        default = Parameter.empty if each.needed or each.is_named else each.default
        parameters.append(Parameter(each.name, kind, default=default))
    signature = Signature(parameters)

    def ask(*given: Any, **named: Any) -> Any:
        bound = signature.bind(*given, **named)
        return bound.arguments.pop("self")._answer(question, bound.arguments)

    ask.__name__, ask.__doc__ = question.method, f"{question.summary}.\n\n"
    ask.__signature__ = signature  # type: ignore[attr-defined]
    return explained(*question.asks)(ask)


for _question in EVERY:
    if _question.method not in vars(Questions):
        setattr(Questions, _question.method, _untyped(_question))
