"""Read a document field by field. Unreadable values become faults, and reading continues."""

from collections.abc import Mapping
from typing import Any

from damperlab.studies.faults import NOTHING, Fault, attempt, describe, join, listing, unknown_key
from damperlab.studies.quantity import Quantity, read_count


class Fields:
    """Reads a document part by part, and collects the faults.

    Parameters
    ----------
    document : dict
        The document, as returned by `guard`.
    faults : list of Fault
        The faults found so far.
    """

    def __init__(self, document: dict[str, Any], faults: list[Fault]) -> None:
        self.document = document
        self.faults = faults

    def _number(self, key: str, quantity: Quantity, default: float) -> float | None:
        return self._read(key, self.document[key], quantity) if key in self.document else default

    def _count(self, key: str, lowest: int, highest: int, default: int | None) -> int | None:
        if key not in self.document:
            return default
        return attempt(lambda: read_count(self.document[key], lowest, highest, key), None, self.faults)

    def _span(self, field: str, raw: object, quantity: Quantity) -> tuple[float, float] | None:
        """Read a number, or ``{start, stop}``."""
        if isinstance(raw, list) and len(raw) == 2 and all(isinstance(each, int | float) for each in raw):
            advice = f"write a range as {{start: {raw[0]}, stop: {raw[1]}}}"
            self._fault(field, describe(raw), "a number or {start, stop}", advice)
            return None
        if not isinstance(raw, Mapping):
            value = self._read(field, raw, quantity)
            return None if value is None else (value, value)
        self._unknown(field, raw, ("start", "stop"))
        ends: list[float] = []
        for key in ("start", "stop"):
            place = f"{field}.{key}"
            if key not in raw:
                self._fault(place, NOTHING, "a number", f"add `{key}`; a range needs start and stop")
            elif (value := self._read(place, raw[key], quantity)) is not None:
                ends.append(value)
        if len(ends) < 2:
            return None
        if not ends[0] < ends[1]:
            self._fault(
                f"{field}.stop",
                f"{ends[1]:g}",
                f"greater than start ({ends[0]:g})",
                "exchange start and stop, or write a single value as a plain number",
            )
            return None
        return ends[0], ends[1]

    def _mapping(self, key: str, known: tuple[str, ...], raw: object = NOTHING) -> Mapping[str, Any] | None:
        value = self.document.get(key) if raw is NOTHING else raw
        if not isinstance(value, Mapping):
            found = NOTHING if value is None else describe(value)
            self._fault(key, found, f"a mapping of {listing(known)}", "write keys and values")
            return None
        self._unknown(key, value, known)
        return value

    def _has(self, key: str, *names: str) -> bool:
        held = self.document.get(key)
        return isinstance(held, Mapping) and any(name in held for name in names)

    def _read(self, field: str, raw: object, quantity: Quantity) -> float | None:
        return attempt(lambda: quantity.read(raw, field), None, self.faults)

    def _unknown(self, field: str, raw: Mapping[str, Any], known: tuple[str, ...]) -> None:
        self.faults.extend(unknown_key(join(field, key), key, known, raw) for key in raw if key not in known)

    def _fault(self, field: str, found: str, allowed: str, advice: str, told: str = "") -> None:
        self.faults.append(Fault(field, found, allowed, advice, told))
