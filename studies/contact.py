"""Reads a contact model from a document that is not a study."""

from pydantic import ValidationError

from damperlab.studies.choices import Choice, CompliantContact, Contact, DwellContact, InstantContact
from damperlab.studies.faults import StudyFaults
from damperlab.studies.pydantic_faults import faults_of

KEYS: dict[str, tuple[str, ...]] = {
    "contact.instant": tuple(InstantContact.model_fields),
    "contact.dwell": tuple(DwellContact.model_fields),
    "contact.compliant": tuple(CompliantContact.model_fields),
}
"""Allowed keys of each contact model."""


class _ContactAlone(Choice):
    contact: Contact = InstantContact()


def parse_contact(raw: object) -> Contact:
    """Read a contact model in the form of the field ``contact`` of a study.

    Raises
    ------
    StudyFaults
        If the contact model has faults; the error lists every fault, under the field ``contact``.
    """
    try:
        return _ContactAlone.model_validate({"contact": raw}).contact
    except ValidationError as error:
        raise StudyFaults(faults_of(error, KEYS, {"contact": raw})) from None
