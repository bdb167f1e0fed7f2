"""Requests with a list of studies. If a study is invalid, no study of the list is stored."""

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
"""Largest total number of axis values in a list of studies. All studies of a list are in memory at the same time."""


class SubmittedList(TypedDict):
    """Studies submitted in one request. The field `created` of a study tells whether the study is new."""

    studies: list[Annotated[dict[str, Any], Like(Record, "definition", "provenance", created=bool)]]


class EstimateList(TypedDict):
    """Cost of several studies."""

    studies: list[Estimate]


SubmittedDocument = TypeAliasType("SubmittedDocument", RecordDocument | SubmittedList)
SubmittedBefore = TypeAliasType("SubmittedBefore", RecordDocument | SubmittedList | Estimate | EstimateList)


def submit_list(service: Service, documents: list[Any], *, reuse: bool, priority: int = 0) -> Document:
    """Store all studies of a list if all are valid, and return their records in the order of the list.

    Parameters
    ----------
    service : Service
        The running service.
    documents : list
        Definitions of the studies as read from JSON or YAML.
    reuse : bool
        Whether points of earlier studies may be reused.
    priority : int
        Priority of all studies.

    Raises
    ------
    StudyFaults
        If studies are invalid. The field of each fault begins with the index of its study, for example
        ``[3].axes.friction_ratio``.
    """
    studies = _parse(documents, service.settings.records)
    chunks = [make_plan(study, seconds_per_point).chunk for study in studies]
    by = provenance()
    entered = service.store.submit_all(
        [Submission(*each, by, reuse, priority=priority) for each in zip(studies, chunks, strict=True)]
    )
    service.dispatcher.wake()
    some = [record.summary() | {"created": created} for record, created in entered]
    return Document({"studies": some}, 201 if any(created for _, created in entered) else 200)


def estimate_list(store: Store, shelf: Shelf, documents: list[Any]) -> Document:
    """Estimate the cost of each study of a list. Invalid studies raise `StudyFaults` as in `submit_list`."""
    studies = _parse(documents, shelf)
    sizes = [estimate_document(each, make_plan(each, seconds_per_point), store) for each in studies]
    return Document({"studies": sizes})


def _parse(documents: list[Any], shelf: Shelf) -> list[AnyStudy]:
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
    faults: list[Fault] = []
    studies: list[AnyStudy] = []
    values = 0
    for place, document in enumerate(documents):
        try:
            studies.append(parse_study(document, shelf))
            values += sum(studies[-1].shape)
            if values > MOST_VALUES:
                found, allowed = f"axes of {values:,} values up to this study", f"{MOST_VALUES:,} in one list"
                raise StudyFaults(
                    [
                        Fault(
                            "axes",
                            found,
                            allowed,
                            "send each study with long axes in a separate request",
                            f"Up to this study, the axes of the list have {values:,} values; "
                            f"at most {MOST_VALUES:,} are allowed.",
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
