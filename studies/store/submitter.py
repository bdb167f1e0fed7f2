"""Who submits: known at the door, and kept with the study."""

from collections.abc import Mapping
from contextvars import ContextVar
from typing import TypeVar

SUBMITTED_BY = "submitted_by"
"""Where a study's provenance says whose it is."""

submitter: ContextVar[str | None] = ContextVar("submitter", default=None)
"""Owner of the studies that are entered from here on; None where nobody asked who it is."""


Value = TypeVar("Value")


def signed(provenance: Mapping[str, Value]) -> dict[str, Value | str]:
    """Add to a provenance whose study it is, where that is known."""
    owner = submitter.get()
    return dict(provenance) if owner is None else {**provenance, SUBMITTED_BY: owner}
