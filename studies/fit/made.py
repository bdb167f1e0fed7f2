"""What a fit makes of a prototype: a study that computes it, and a specification that corrects its design."""

from dataclasses import dataclass
from typing import Any

from damperlab.studies.faults import StudyFaults
from damperlab.studies.fit.correction import check_correction, corrected
from damperlab.studies.fit.fitted import Estimate, Fitted
from damperlab.studies.fit.history.fitted import FittedHistory
from damperlab.studies.fit.history.harmonic import harmonic_document
from damperlab.studies.fit.history.question import HistoryQuestion
from damperlab.studies.fit.prototype import Question, as_asked, prototype_of
from damperlab.studies.fit.specified import Specified, specified
from damperlab.studies.ground.shelf import Shelf
from damperlab.studies.specification.specification import Specification


@dataclass(frozen=True)
class Correction:
    """The specification that a fit corrects.

    Parameters
    ----------
    asked : Specification
        As it is.
    shelf : Shelf, optional
        Where its ground-motion records are.
    """

    asked: Specification
    shelf: Shelf | None = None


@dataclass(frozen=True)
class Made:
    """Documents that a fit makes, each where it can be made.

    Parameters
    ----------
    study : dict or None
        The prototype as a study.
    specification : Specified or None
        A specification of its design.
    words : tuple of str
        About the specification; or why there is none.
    """

    study: dict[str, Any] | None
    specification: Specified | None
    words: tuple[str, ...]


def made_of(fitted: Fitted | FittedHistory, correction: Correction | None = None) -> Made:
    """Make the study and the specification of what was found.

    Parameters
    ----------
    fitted : Fitted or FittedHistory
        The outcome.
    correction : Correction, optional
        The specification to be corrected; without it a new one is made.
    """
    study: dict[str, Any] | None
    try:
        study = fitted.study()
    except StudyFaults:
        study = None
    try:
        found = specification_of(fitted.question, list(fitted.estimates), correction)
    except StudyFaults as error:
        return Made(study, None, tuple(str(fault) for fault in error.faults))
    return Made(study, found, found.words)


def specification_of(
    question: Question, estimates: list[Estimate], correction: Correction | None = None
) -> Specified:
    """Make a specification of what was found, new or by correcting one.

    Raises
    ------
    StudyFaults
        Where none can be made, with the reason.
    """
    if correction is None:
        return specified(prototype_of(question, estimates))
    return corrected(correction.asked, question, estimates, correction.shelf)


def check_specification(question: Question, correction: Correction | None = None) -> None:
    """Refuse, before anything is computed, a question from whose answer no specification can be made.

    Raises
    ------
    StudyFaults
        With the reason.
    """
    if correction is None:
        specification_of(question, as_asked(question))
        return
    # whether what is measured keeps its limits is known once it is measured
    check_correction(correction.asked, question, as_asked(question))


def check_study(question: Question) -> None:
    """Refuse, before anything is computed, a question from whose answer no study can be made; as `check_specification` does."""
    if isinstance(question, HistoryQuestion):
        harmonic_document(question, {each.name: each.value for each in as_asked(question)})
