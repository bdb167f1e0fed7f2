"""A list of studies in one request: either all are valid and stored, or none."""

from typing import Annotated, Any

from typing_extensions import TypeAliasType, TypedDict

from damperlab.service.documents import Document
from damperlab.service.estimates import Estimate, estimate_document
from damperlab.service.state import Service
from damperlab.studies.definition import parse_study
from damperlab.studies.faults import MAX_FAULTS, WHOLE, Fault, StudyFaults
from damperlab.studies.ground.shelf import Shelf
from damperlab.studies.kind import AnyStudy
from damperlab.studies.plan import make_plan
from damperlab.studies.shapes import Like
from damperlab.studies.store.life_cycle.entering import Submission
from damperlab.studies.store.record import Record, RecordDocument
from damperlab.studies.store.store import Store
from damperlab.studies.text import MOST_STUDIES
from damperlab.worker.dispatch.cost_model import seconds_per_point
from damperlab.worker.provenance import provenance

MOST_VALUES = 1_000_000
"""Largest number of values along all axes of a list's studies together, because all are in memory at once."""


class SubmittedList(TypedDict):
    """Studies submitted together; `created` says for each whether it is new."""

    studies: list[Annotated[dict[str, Any], Like(Record, "definition", "provenance", created=bool)]]


class EstimateList(TypedDict):
    """Cost of several studies."""

    studies: list[Estimate]


SubmittedDocument = TypeAliasType("SubmittedDocument", RecordDocument | SubmittedList)
SubmittedBefore = TypeAliasType("SubmittedBefore", RecordDocument | SubmittedList | Estimate | EstimateList)


def submit_list(
    service: Service, documents: list[Any], *, reuse: bool, key: str | None, priority: int = 0
) -> Document:
    """Store every study of a list, or none; the answer has them in the list's order.

    Parameters
    ----------
    service : Service
        The service.
    documents : list
        The studies as read from JSON or YAML.
    reuse : bool
        Whether points of earlier studies may be reused.
    key : str, optional
        It is refused, because a list is identified by its definitions.
    priority : int
        Priority of every study.

    Raises
    ------
    StudyFaults
        With the faults of every study; each field begins with the study's index, as in ``[3].axes.friction_ratio``.
    """
    studies = _parse(documents, service.settings.records, key)
    plans = [make_plan(study, seconds_per_point) for study in studies]
    by = provenance()
    entered = service.store.submit_all(
        [Submission(*each, by, reuse, priority=priority) for each in zip(studies, plans, strict=True)]
    )
    service.dispatcher.wake()
    some = [record.summary() | {"created": created} for record, created in entered]
    return Document({"studies": some}, 201 if any(created for _, created in entered) else 200)


def estimate_list(store: Store, shelf: Shelf, documents: list[Any], key: str | None) -> Document:
    """Estimate the cost of each of several studies; the faults are those of `submit_list`."""
    studies = _parse(documents, shelf, key)
    sizes = [estimate_document(each, make_plan(each, seconds_per_point), store) for each in studies]
    return Document({"studies": sizes})


def _parse(documents: list[Any], shelf: Shelf, key: str | None) -> list[AnyStudy]:
    if not 1 <= len(documents) <= MOST_STUDIES:
        advice = "send one study without brackets, or several lists"
        raise StudyFaults(
            [
                Fault(
                    WHOLE,
                    f"a list of {len(documents)}",
                    f"1 to {MOST_STUDIES} studies",
                    advice,
                    f"A list may hold 1 to {MOST_STUDIES} studies; this one holds {len(documents)}.",
                )
            ]
        )
    faults = []
    if key is not None:
        advice = "leave it out: the same definition is the same study, however often it is sent"
        faults.append(
            Fault(
                "Idempotency-Key",
                "a key for a list of studies",
                "one for a single study",
                advice,
                "`Idempotency-Key` applies to a single study, not to a list.",
            )
        )
    studies: list[AnyStudy] = []
    values = 0
    for place, document in enumerate(documents):
        try:
            studies.append(parse_study(document, shelf))
            values += sum(studies[-1].shape)
            if values > MOST_VALUES:
                found, allowed = f"axes of {values:,} values up to here", f"{MOST_VALUES:,} in one list"
                raise StudyFaults(
                    [
                        Fault(
                            "axes",
                            found,
                            allowed,
                            "send studies with long axes alone",
                            f"The axes up to here have {values:,} values; those of one list may have at most {MOST_VALUES:,}.",
                        )
                    ]
                )
        except StudyFaults as error:
            faults += [fault.under(f"[{place}]") for fault in error.faults]
        if values > MOST_VALUES:
            break
        if len(faults) >= MAX_FAULTS and place + 1 < len(documents):
            told = f"The studies from [{place + 1}] on were not read."
            advice = "correct those that are listed, then submit again"
            faults[MAX_FAULTS - 1 :] = [Fault(WHOLE, f"faults up to [{place}]", "none", advice, told)]
            break
    if faults:
        raise StudyFaults(faults)
    return studies
