"""Documents without some of their keys, and what a document is refused with."""

from collections.abc import Callable, Mapping
from typing import Any

import pytest

from damperlab.studies.faults import Fault, StudyFaults


def without(document: Mapping[str, Any], *keys: str) -> dict[str, Any]:
    """Leave keys of a document out."""
    return {key: value for key, value in document.items() if key not in keys}


def faults_of(read: Callable[..., object], *given: Any, **more: Any) -> tuple[Fault, ...]:
    """Read what is refused; give its faults."""
    with pytest.raises(StudyFaults) as caught:
        read(*given, **more)
    return caught.value.faults


def fields_of(read: Callable[..., object], *given: Any, **more: Any) -> list[str]:
    """Name the fields of these faults."""
    return [fault.field for fault in faults_of(read, *given, **more)]


def told_of(read: Callable[..., object], *given: Any, **more: Any) -> dict[str, str]:
    """Give what is told of each of these faults, by its field."""
    return {fault.field: str(fault) for fault in faults_of(read, *given, **more)}
