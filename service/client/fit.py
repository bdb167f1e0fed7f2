"""Request to estimate parameters of a prototype from a measured response or time history."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from damperlab.service.client.faults import refused
from damperlab.studies.faults import Fault, describe

if TYPE_CHECKING:
    Ranges = Mapping[str, tuple[float, float] | None] | Iterable[str]


def question(
    measured: str | Path,
    fit: "Ranges",
    structure: Mapping[str, Any] | None,
    **numbers: float | None,
) -> dict[str, Any]:
    """Return the body of a request for a fit; see `Client.fit` for the arguments."""
    ranges = fit if isinstance(fit, Mapping) else dict.fromkeys([fit] if isinstance(fit, str) else fit)
    faults = [
        _no_range(name, span) for name, span in ranges.items() if span is not None and not _is_range(span)
    ]
    if structure is not None and not isinstance(structure, Mapping):
        advice = "name the parameters to estimate as `fit`, the second argument, and the known values as `structure`, the third"
        faults.append(Fault("structure", describe(structure), "a mapping of the known values", advice))
    if faults:
        raise refused(tuple(faults))
    given = {name: None if span is None else [float(end) for end in span] for name, span in ranges.items()}
    document = _measured(measured) | {"structure": dict(structure or {}), "fit": given}
    return document | {name: value for name, value in numbers.items() if value is not None}


def _is_range(span: Any) -> bool:
    try:
        ends = [float(end) for end in span]
    except (TypeError, ValueError):
        return False
    return len(ends) > 0


def _no_range(name: str, span: object) -> Fault:
    allowed = "lowest and highest value, or None for the default range"
    advice = "give the known values as `structure`, the third argument"
    return Fault(f"fit.{name}", describe(span), allowed, advice)


def _measured(measured: str | Path) -> dict[str, str]:
    if isinstance(measured, str) and "\n" in measured:
        return {"measured": measured}
    path = Path(measured)
    try:
        return {"measured": path.read_text(encoding="utf-8-sig"), "name": path.stem}
    except (OSError, ValueError) as error:
        advice = "give the path of a table in UTF-8, or the table itself as text of several lines"
        told = f"The table {describe(str(measured))} cannot be read: {error}."
        raise refused(
            (Fault("measured", describe(str(measured)), "a readable file", advice, told),)
        ) from None
