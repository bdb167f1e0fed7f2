"""Read the definition and the measurement of a fit from one document, as in an HTTP request."""

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from damperlab.studies.definition import MAX_NAME
from damperlab.studies.faults import NOTHING, Fault, StudyFaults, attempt, describe, printable, unknown_key
from damperlab.studies.fit.asking import CONFIDENCE, DEVIATION, make_question
from damperlab.studies.fit.history.asking import make_history_question
from damperlab.studies.fit.history.question import History, HistoryQuestion
from damperlab.studies.fit.history.table import is_history, parse_history
from damperlab.studies.fit.lines import MOST_BYTES, lines_of, read_bytes
from damperlab.studies.fit.measured import Measurement, parse_measurement
from damperlab.studies.fit.question import FREE, NAMED, FitQuestion
from damperlab.studies.guard import guard
from damperlab.studies.quantity import read_count
from damperlab.studies.text import load_text, read_file

KEYS = ("measured", "name", "structure", "fit", "deviation", "confidence", "seed")
MOST_SEED = 2**32 - 1


def read_fit(document: object) -> FitQuestion | HistoryQuestion:
    """Read the definition of a fit, and report every fault.

    Parameters
    ----------
    document : object
        A mapping as read from JSON: `measured` (the text of the table), `structure` (the known values, as in a study)
        and `fit` (the parameters to estimate, each with a range or null). `name`, `deviation`, `confidence` and `seed`
        are optional.

    Raises
    ------
    StudyFaults
        If the document, the table or the resulting definition is invalid. The exception contains all faults found.
    """
    if not isinstance(document, Mapping):
        advice = "write `measured`, `structure` and `fit`"
        raise StudyFaults([Fault("body", describe(document), "a mapping", advice)])
    document, faults = guard(document)
    faults += [unknown_key(str(key), str(key), KEYS, document) for key in document if key not in KEYS]
    measured = _measured(document, faults)
    structure = document.get("structure", {})
    if not isinstance(structure, Mapping):
        advice = "write names and numbers, as in a study"
        faults.append(Fault("structure", describe(structure), "a mapping", advice))
    ranges = _ranges(document.get("fit", {}), faults)
    numbers: dict[str, Any] = {"deviation": None, "confidence": 0.95, "seed": 0}
    for quantity in (DEVIATION, CONFIDENCE):
        if (raw := document.get(quantity.name)) is not None:
            numbers[quantity.name] = attempt(partial(quantity.read, raw, quantity.name), None, faults)
    if (raw := document.get("seed")) is not None:
        numbers["seed"] = attempt(partial(read_count, raw, 0, MOST_SEED, "seed"), None, faults)
    if faults or measured is None:
        raise StudyFaults(faults)
    numbers["share"] = numbers.pop("deviation")
    if isinstance(measured, History):
        return make_history_question(measured, structure, ranges, **numbers)
    return make_question(measured, structure, ranges, **numbers)


def _measured(document: Mapping[str, Any], faults: list[Fault]) -> Measurement | History | None:
    name = document.get("name", "measurement")
    if not (isinstance(name, str) and 0 < len(name) <= MAX_NAME and name.isprintable()):
        allowed = f"a text of 1 to {MAX_NAME} printable characters"
        faults.append(Fault("name", describe(name), allowed, "write a short text, or leave it out"))
    text = document.get("measured", NOTHING)
    if not isinstance(text, str) or "measured" not in document:
        found = describe(text) if "measured" in document else NOTHING
        advice = "give the rows as one text, the first line with the names of the columns"
        faults.append(Fault("measured", found, "the text of a table", advice))
        return None
    return attempt(lambda: parse_table(text, str(name)), None, faults)


def _ranges(raw: object, faults: list[Fault]) -> dict[str, tuple[float, float] | None]:
    """Read the range of each parameter: null, ``[low, high]`` or ``{start, stop}``."""
    if not isinstance(raw, Mapping):
        advice = 'write the parameters to estimate, as in {"friction_ratio": [0, 0.8], "restitution": null}'
        faults.append(Fault("fit", describe(raw), "a mapping of ranges", advice))
        return {}
    found: dict[str, tuple[float, float] | None] = {}
    for name, span in raw.items():
        ends = list(span.values()) if isinstance(span, Mapping) and list(span) == ["start", "stop"] else span
        if ends is None:
            found[str(name)] = None
        elif isinstance(ends, list) and len(ends) == 2 and name in NAMED:
            low, high = (attempt(partial(NAMED[name].read, end, f"fit.{name}"), 0.0, faults) for end in ends)
            found[str(name)] = (low, high)
        elif name in NAMED:
            advice = f'write "{name}": [LOW, HIGH], or null for the default range'
            faults.append(Fault(f"fit.{name}", describe(span), "a range", advice))
        else:
            found[str(name)] = None  # `make_question` reports the unknown name
    return found


def fit_schema() -> dict[str, Any]:
    """Return the JSON schema of the document."""

    def span(name: str) -> dict[str, Any]:
        ends = {"type": "array", "items": NAMED[name].schema(), "minItems": 2, "maxItems": 2}
        return {
            "description": f"{NAMED[name].meaning}: lowest and highest, or null for the default range",
            "anyOf": [ends, {"type": "null"}],
        }

    return {
        "type": "object",
        "required": ["measured", "fit"],
        "additionalProperties": False,
        "properties": {
            "measured": {
                "type": "string",
                "maxLength": MOST_BYTES,
                "description": "A table, separated by comma, semicolon or tab; its first line names the "
                "columns with units.",
            },
            "name": {"type": "string", "minLength": 1, "maxLength": MAX_NAME, "default": "measurement"},
            "structure": {
                "type": "object",
                "description": "The known values of the prototype, in the form of a study; an axis is a "
                "range within which to estimate.",
            },
            "fit": {
                "type": "object",
                "description": "The parameters to estimate.",
                "additionalProperties": False,
                "properties": {name: span(name) for name in FREE},
            },
            "deviation": DEVIATION.schema(),
            "confidence": CONFIDENCE.schema(0.95),
            "seed": {"type": "integer", "minimum": 0, "maximum": MOST_SEED, "default": 0},
        },
    }


def read_table(path: Path | str) -> Measurement | History:
    """Read a measured table from a file. Raise StudyFaults with every fault of the table."""
    return parse_table(read_bytes(path), Path(path).stem)


def parse_table(text: bytes | str, name: str = "measurement") -> Measurement | History:
    """Read a table with a column of times as a time history, and any other table as a frequency response."""
    if is_history(lines_of(text)):
        return parse_history(text, name)
    return parse_measurement(text, name)


def read_structure(path: Path | str) -> dict[str, Any]:
    """Read the known values of a prototype from a ``.json``, ``.yaml`` or ``.yml`` file.

    Returns
    -------
    dict
        The values as written, before the checks in `damperlab.studies.fit.asking.make_question`.

    Raises
    ------
    StudyFaults
        If the file cannot be read or breaks the rules of its format.
    """
    document = load_text(*read_file(path, "structure"))
    if not isinstance(document, dict):
        told = f"The file {printable(str(path))} holds no mapping."
        advice = "write names and values, as in a study"
        raise StudyFaults([Fault("structure", describe(document), "a mapping", advice, told)])
    return document
