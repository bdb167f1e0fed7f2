"""The quality of a fit, in sentences."""

from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from damperlab.studies.faults import counted, listing
from damperlab.studies.fit.fitted import DOUBTED, Estimate, Fitted, Outcome
from damperlab.studies.fit.history.fitted import FittedHistory
from damperlab.studies.spelling import quantity, spelled

TOO_GOOD = 0.999
"""p-value of the chi-square test above which model and measurement agree better than chance allows."""
CORRELATED = 1.2
"""Correlated residuals are mentioned if they widen the intervals by more than this factor."""
POOR = 0.2
"""Largest scatter about a fit, relative to the amplitudes, that is plausible for a measurement of steady amplitudes."""
NAMED_ROWS = 5
"""Largest number of rows that a sentence names."""


def verdict(fitted: Fitted) -> list[str]:
    """Describe the quality of a fit: agreement of the model, undetermined parameters, and outliers."""
    return [
        *_agreement(fitted),
        *_undetermined(fitted.estimates),
        *_one_sided(fitted.estimates),
        *_not_told_apart(fitted.alike),
        *_regimes(fitted),
        *_irregular(fitted),
        *_as_good(fitted.others),
        *_rows(fitted),
    ]


def verdict_of_history(fitted: FittedHistory) -> list[str]:
    """Describe the fit of a time history: the used part, the agreement, and undetermined parameters."""
    return [
        *_stretch(fitted),
        _history_agreement(fitted),
        *_correlated(fitted),
        *_undetermined(fitted.estimates),
        *_one_sided(fitted.estimates),
        *_not_told_apart(fitted.alike),
        *_as_good(fitted.others),
    ]


def told(confidence: float, each: Estimate) -> str:
    """Write one estimate as a sentence."""
    share = f"{100 * confidence:g} %"
    value, low, high = (quantity(each.name, one, each.digits) for one in (each.value, each.low, each.high))
    return f"{each.name} = {value} ({share} interval {low} to {high})."


def _agreement(fitted: Fitted) -> Iterator[str]:
    if fitted.question.deviation is None:
        share = float(np.median(fitted.deviation / fitted.question.measured.amplitude))
        yield _scatters(f"{100 * share:.2g} %")
        if share > POOR:
            yield (
                "This is more than the scatter of a measurement: the model, or a value taken as known, does "
                "not describe this prototype. The parameters are only the best of a wrong model."
            )
    elif fitted.probability is None:
        yield "There are no more rows than parameters, so the data cannot test the model."
    else:
        yield _agrees(fitted, fitted.probability)


def _scatters(by: str) -> str:
    return (
        "No standard deviation was given, so chi-square cannot test the model. The measurement scatters "
        f"about the fit by {by}, and the intervals follow from that."
    )


def _agrees(fitted: Outcome, probability: float) -> str:
    """Say whether the model agrees with the measurement within the stated deviations."""
    found = f"chi-square is {fitted.chi_square:.4g} for {counted(fitted.freedom, 'degree')} of freedom"
    if probability < DOUBTED:
        wider = (
            f" They are {fitted.widening:.2g} times as wide for this reason." if fitted.widening > 1.0 else ""
        )
        return (
            f"The model does not agree with the measurement within the stated deviations: {found}, which "
            f"chance alone exceeds with a probability of {probability:.2g}. Either the deviations are too "
            f"small or the model lacks something. The intervals are valid only in the first case.{wider}"
        )
    if probability > TOO_GOOD:
        return (
            f"The model agrees with the measurement better than chance allows: {found}, which chance exceeds with a "
            f"probability of {probability:.4g}. The stated deviations are too large, and so are the intervals."
        )
    return f"The model agrees with the measurement: {found}, which chance exceeds with a probability of {probability:.2g}."


def _undetermined(estimates: Sequence[Estimate]) -> Iterator[str]:
    """Name the parameters that the data do not determine."""
    names = [each.name for each in estimates if not each.determined]
    if names:
        one = len(names) == 1
        yield (
            f"The data do not determine {listing(names)} within {'its range' if one else 'their ranges'}: "
            f"almost any value agrees as well. Measure {'it' if one else 'them'} in another way, or at "
            f"frequencies and amplitudes where {'it matters' if one else 'they matter'}."
        )


def _one_sided(estimates: Sequence[Estimate]) -> Iterator[str]:
    """Name the parameters for which the data give only a lower or only an upper bound."""
    for each in estimates:
        if each.determined and not (each.bounded_below and each.bounded_above):
            end, value = ("low", each.lowest) if not each.bounded_below else ("high", each.highest)
            bound, other = ("at most", each.high) if end == "low" else ("at least", each.low)
            yield (
                f"The interval of {each.name} reaches the {end} end of its range, {quantity(each.name, value)}: the data "
                f"bound it on one side only ({bound} {quantity(each.name, other)}). Widen the range if the end is not "
                "a physical limit."
            )


def _not_told_apart(pairs: Sequence[tuple[str, str, float]]) -> Iterator[str]:
    """Name the pairs of parameters that the data cannot separate."""
    for first, second, correlation in pairs:
        way = "both rise" if correlation > 0 else "one rises and the other falls"
        yield (
            f"The data cannot tell {first} and {second} apart: the response stays the same if {way} "
            f"(correlation {correlation:.3f}). Measure one of them on its own."
        )


def _regimes(fitted: Fitted) -> Iterator[str]:
    if fitted.always_sticks:
        yield (
            "Friction locks the structure to its base in every row: the data give little more than a lower "
            "bound of the friction. Measure at a larger base amplitude or nearer to resonance."
        )
    elif fitted.never_strikes:
        without = listing(fitted.of_no_effect)
        yield (
            "The particle strikes its cavity in none of the rows"
            + (f", so no row depends on {without}" if without else "")
            + ". Measure at a larger base amplitude or nearer to resonance."
        )


def _irregular(fitted: Fitted) -> Iterator[str]:
    if fitted.irregular:
        yield (
            f"At {counted(fitted.irregular, 'row')} the fitted response is modulated or chaotic: the "
            "model's mean has an error, which is combined with that of the measurement."
        )


def _as_good(others: Iterable[Mapping[str, float]]) -> Iterator[str]:
    """Name further sets of parameters that agree with the data almost as well as the best set."""
    for other in others:
        values = listing(f"{name} = {quantity(name, value)}" for name, value in other.items())
        yield f"Another set of parameters agrees about as well: {values}. The intervals are those around the best one."


def _rows(fitted: Fitted) -> Iterator[str]:
    if fitted.outliers:
        rows = fitted.outliers[:NAMED_ROWS]
        more = len(fitted.outliers) - len(rows)
        yield (
            f"Rows further from the model than chance allows: {listing(_row(fitted, row) for row in rows)}"
            + (f", and {counted(more, 'more row')}" if more else "")
            + ". They have less weight than the other rows; check them."
        )
    failed = int(np.isnan(fitted.model).sum())
    if failed:
        ignored = "which is ignored" if failed == 1 else "which are ignored"
        yield f"The model has no response at {counted(failed, 'row')}, {ignored}."
    with np.errstate(invalid="ignore"):
        unsure = np.flatnonzero(fitted.model_error > fitted.deviation)
    if unsure.size:
        worst = unsure[np.argsort(-fitted.model_error[unsure] / fitted.deviation[unsure], kind="stable")]
        named = sorted(worst[:NAMED_ROWS])
        frequencies = listing(f"{fitted.question.measured.frequency[row]:.4g}" for row in named)
        unit = " Hz" if fitted.question.measured.in_hertz else ""
        yield (
            f"At {counted(unsure.size, 'row')} the model itself is less certain than the measurement, because the response "
            "is chaotic or jumps within the intervals. "
            f"So {'this row has' if unsure.size == 1 else 'these rows have'} less weight (frequencies {frequencies}{unit})."
        )


def _row(fitted: Fitted, row: int) -> str:
    measured = fitted.question.measured
    unit, length = (" Hz" if measured.in_hertz else ""), (" m" if measured.in_metres else "")
    return (
        f"row {row + 1} at {measured.frequency[row]:.5g}{unit}, {measured.amplitude[row]:.4g}{length} "
        f"measured and {fitted.model[row]:.4g}{length} in the model "
        f"({fitted.residual[row]:+.1f} standard deviations)"
    )


def _stretch(fitted: FittedHistory) -> Iterator[str]:
    before = fitted.question.measured.before_release
    if before:
        yield f"The table begins {counted(before, 'row')} before the release; the fit begins at the release."
    whole = fitted.question.measured.duration_s
    if fitted.whole:
        yield f"The complete history is used, {whole:.4g} s: the response is predictable throughout."
        return
    beyond = "the model agrees less well"
    if fitted.question.particle:
        beyond = (
            "either impacts make the response depend so steeply on the parameters that agreement would be chance, or "
            f"{beyond}"
        )
    yield f"The first {fitted.stretch_s:.4g} s of {whole:.4g} s are used. Beyond that, {beyond}."


def _history_agreement(fitted: FittedHistory) -> str:
    if fitted.probability is not None:
        return _agrees(fitted, fitted.probability)
    deviation = float(np.median(fitted.deviation_m))
    share = 100 * deviation / fitted.question.measured.largest_m
    return _scatters(f"{spelled(deviation, 'm', 3)}, {share:.2g} % of its largest displacement")


def _correlated(fitted: FittedHistory) -> Iterator[str]:
    if fitted.correlated > CORRELATED:
        yield (
            "The residuals of successive samples are correlated: the noise is not white, or the model lacks "
            f"something. The intervals are therefore up to {fitted.correlated:.2g} times as wide."
        )
