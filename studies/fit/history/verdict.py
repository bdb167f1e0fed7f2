"""What a fit of a time history is worth, in sentences."""

from collections.abc import Iterator

import numpy as np

from damperlab.studies.faults import counted
from damperlab.studies.fit.fitted import DOUBTED
from damperlab.studies.fit.history.fitted import FittedHistory
from damperlab.studies.fit.verdict import TOO_GOOD, as_good, not_told_apart, one_sided, undetermined
from damperlab.studies.spelling import spelled

CORRELATED = 1.2
"""By how much intervals are wider for correlated residuals, from which it is said."""


def verdict_of_history(fitted: FittedHistory) -> list[str]:
    """Say what a fit of a time history is worth: over which stretch, whether the model agrees, what is not determined."""
    return [
        *_stretch(fitted),
        *_agreement(fitted),
        *_correlated(fitted),
        *undetermined(fitted.estimates),
        *one_sided(fitted.estimates),
        *not_told_apart(fitted.alike),
        *as_good(fitted.others),
    ]


def _stretch(fitted: FittedHistory) -> Iterator[str]:
    before = fitted.question.measured.before_release
    if before:
        yield f"{counted(before, 'row')} of the table before the release: left out."
    whole = fitted.question.measured.duration_s
    if fitted.whole:
        yield f"All of the history counts, {whole:.4g} s: the response is predictable throughout."
        return
    yield (
        f"The first {fitted.stretch_s:.4g} s of {whole:.4g} s count. Later on impacts make the response depend on the "
        "parameters so steeply, within what the data leave open, that what agrees there agrees by chance; or the model "
        "describes it worse."
    )


def _agreement(fitted: FittedHistory) -> Iterator[str]:
    probability = fitted.probability
    if probability is None:
        deviation = float(np.median(fitted.deviation_m))
        share = 100 * deviation / fitted.question.measured.largest_m
        yield (
            f"No standard deviation was given, so chi-square cannot say whether the model is right: the measurement scatters "
            f"about the fit by {spelled(deviation, 'm', 3)}, {share:.2g} % of its "
            "largest displacement, and the intervals follow from that."
        )
        return
    found = f"chi-square is {fitted.chi_square:.4g} for {counted(fitted.freedom, 'degree')} of freedom"
    if probability < DOUBTED:
        yield (
            f"The model does not agree with the measurement within the stated deviations: {found}, and chance alone exceeds "
            f"that with a probability of {probability:.2g}. The intervals are {fitted.widening:.2g} times as wide for it, "
            "which helps only if it is the deviations that are too small."
        )
    elif probability > TOO_GOOD:
        yield (
            f"The model agrees with the measurement better than chance allows: {found}. The stated deviations are too large, "
            "and so are the intervals."
        )
    else:
        yield (
            f"The model agrees with the measurement: {found}, and chance exceeds that with a probability of "
            f"{probability:.2g}."
        )


def _correlated(fitted: FittedHistory) -> Iterator[str]:
    if fitted.correlated > CORRELATED:
        yield (
            "What is left is correlated from sample to sample: noise that is not white, or a model that is not quite right. "
            f"Intervals are up to {fitted.correlated:.2g} times as wide for it."
        )
