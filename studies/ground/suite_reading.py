"""Reads a ground-motion suite from a document, and reports every fault. JSON schema of the document."""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from damperlab.studies.axes import AxisSpec, axis_count, axis_schema, axis_values, read_axis
from damperlab.studies.faults import Fault, StudyFaults, attempt, counted, describe, unknown_key
from damperlab.studies.ground.generated import LISTED_SCHEMAS, WRITTEN
from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.ground.quantities import QUANTITIES
from damperlab.studies.ground.question import read_contact
from damperlab.studies.ground.recipe import LARGEST_SEED
from damperlab.studies.ground.shelf import Shelf
from damperlab.studies.ground.source import RecordSource, read_entries
from damperlab.studies.ground.suite import AXES, NUMBERS, Suite, windows_of
from damperlab.studies.ground.variables import VARIABLES, available_variables
from damperlab.studies.guard import guard
from damperlab.studies.metrics import read_metrics
from damperlab.studies.quantity import PARTICLE_FRICTION, read_count
from damperlab.studies.questions import MOST_STARTS
from damperlab.studies.variables import MADE_BY

KEYS = ("name", "records", "axes", *NUMBERS, "starts", "seed", "contact", "metrics")

MOST_NAME = 200
MOST_RECORDS = 100
MOST_SAMPLES = 4_000_000
"""Largest number of samples of all records of a suite (32 MB). Every suite stores a copy of the samples."""
MOST_RUNS = 1_000_000_000
"""Largest number of runs of a suite, which has one run for each point and start."""
MOST_WINDOWS = 200_000
"""Largest number of time steps of one run. Without this limit, a run of a stiff structure under a long record
could take seconds.
"""


def read_suite(document: object, shelf: Shelf | None = None) -> Suite:
    """Read a ground-motion suite.

    Parameters
    ----------
    document : object
        Mapping with ``records``, and with ``axes`` that give any of `AXES` as a number, a list, or
        ``{start, stop, num, spacing}``. Missing values are taken from the paper's prototype.
    shelf : Shelf, optional
        Store of records; see `damperlab.studies.ground.source.read_source`.

    Raises
    ------
    StudyFaults
        If the document is invalid; the exception lists every fault.
    """
    held, faults = guard(document)
    faults += [_unknown(key) for key in held if key not in KEYS]
    given = held.get("axes", {})
    if not isinstance(given, dict):
        faults.append(Fault("axes", describe(given), "a mapping", "write keys and values"))
        given = {}
    faults += [_no_axis(key, given) for key in given if key not in AXES]
    name = held.get("name", "")
    if not isinstance(name, str) or len(name) > MOST_NAME or not name.isprintable():
        allowed = f"a text of at most {MOST_NAME} printable characters"
        faults.append(Fault("name", describe(name), allowed, "write a short text on one line"))

    def quantity(key: str) -> float:
        bounds, default = QUANTITIES[key]
        return attempt(lambda: bounds.read(held.get(key, default), key), default, faults)

    def axis(key: str) -> AxisSpec:
        bounds, default = QUANTITIES[key]
        return attempt(lambda: read_axis(given.get(key, default), bounds, f"axes.{key}"), default, faults)

    axes = {key: axis(key) for key in AXES}
    numbers = {key: quantity(key) for key in NUMBERS}
    numbers = {key: value for key, value in numbers.items() if value or key not in MADE_BY.values()}
    starts = attempt(lambda: read_count(held.get("starts", 0), 0, MOST_STARTS, "starts"), 0, faults)
    seed = attempt(lambda: read_count(held.get("seed", 0), 0, LARGEST_SEED, "seed"), 0, faults)
    least = float(axis_values(axes["restitution"]).min())
    contact = read_contact(held, numbers, "axes.restitution", least, faults)
    available = available_variables(starts, numbers.get(PARTICLE_FRICTION.name, 0.0) > 0.0)
    metrics = attempt(
        lambda: read_metrics(held.get("metrics", available), available, "metrics"), available, faults
    )
    found = _records(held.get("records"), shelf, faults)
    if not faults:
        faults += _too_much([source for source, _ in found], axes, numbers, starts)
    if faults:
        raise StudyFaults(faults)
    found.sort(key=lambda one: one[0].id)
    motions = {source.id: motion for source, motion in found if motion is not None}
    sources = tuple(source for source, _ in found)
    return Suite(name.strip(), sources, axes, numbers, starts, seed, contact, metrics, motions)


def suite_json_schema() -> dict[str, Any]:
    """Return the self-contained JSON schema of a suite."""
    record = {
        "anyOf": [
            {"type": "string", "description": "the id of a record, or an earthquake's name"},
            {
                "type": "object",
                "description": f"{WRITTEN}, or a record as written in a stored study",
                "properties": LISTED_SCHEMAS,
            },
        ]
    }
    numbers = {name: QUANTITIES[name] for name in NUMBERS}
    return {
        "type": "object",
        "description": "A grid of responses to ground motions, in physical units. A study with `records` is "
        "such a grid.",
        "required": ["records"],
        "additionalProperties": False,
        "properties": {
            "name": {"type": "string", "maxLength": MOST_NAME, "default": ""},
            "records": {"type": "array", "items": record, "minItems": 1, "maxItems": MOST_RECORDS},
            "axes": {
                "type": "object",
                "additionalProperties": False,
                "properties": {name: axis_schema(*QUANTITIES[name]) for name in AXES},
            },
            **{name: quantity.schema(default) for name, (quantity, default) in numbers.items()},
            "starts": {
                "type": "integer",
                "minimum": 0,
                "maximum": MOST_STARTS,
                "default": 0,
                "description": "number of perturbed starts of each point; the spread of their results is stored",
            },
            "seed": {"type": "integer", "minimum": 0, "default": 0, "description": "seed of the starts"},
            "contact": {
                "type": "object",
                "description": "{model: instant}, or {model: dwell, contact_time: …} in units of 1/ω_n",
            },
            "metrics": {
                "type": "array",
                "items": {"type": "string", "enum": list(VARIABLES)},
                "minItems": 1,
                "uniqueItems": True,
            },
        },
    }


def _unknown(key: str) -> Fault:
    fault = unknown_key(key, key, KEYS)
    if key not in AXES:
        return fault
    return replace(fault, advice="write it inside `axes`")


def _no_axis(key: str, beside: Mapping[str, object]) -> Fault:
    fault = unknown_key(f"axes.{key}", key, AXES, beside)
    if key not in NUMBERS:
        return fault
    return replace(fault, advice="write it outside `axes`, as one number")


def _records(
    raw: object, shelf: Shelf | None, faults: list[Fault]
) -> list[tuple[RecordSource, GroundMotion | None]]:
    if isinstance(raw, str | dict):
        raw = [raw]
    if not isinstance(raw, list | tuple) or not 0 < len(raw) <= MOST_RECORDS:
        allowed = f"a list of 1 to {MOST_RECORDS} records"
        faults.append(Fault("records", describe(raw), allowed, 'write ["loma-prieta"]'))
        return []
    entries = [(f"records[{place}]", f"records[{place}]", one) for place, one in enumerate(raw)]
    found = read_entries(entries, shelf, set(), faults)
    if len(found) > MOST_RECORDS:
        words, allowed = f"{len(found)} records", f"at most {MOST_RECORDS} records"
        faults.append(Fault("records", words, allowed, "use fewer records or seeds"))
    return [(source, motion) for _, source, motion in found]


def _too_much(
    sources: list[RecordSource], axes: dict[str, AxisSpec], numbers: dict[str, float], starts: int
) -> list[Fault]:
    faults = []
    runs = len(sources) * math.prod(axis_count(spec) for spec in axes.values()) * (1 + starts)
    if runs > MOST_RUNS:
        advice = "use fewer values, records or starts"
        told = f"The suite takes {runs:,} runs; at most {MOST_RUNS:,} are allowed."
        faults.append(Fault("axes", f"{runs:,} runs", f"at most {MOST_RUNS:,} runs", advice, told))
    samples = sum(source.samples for source in sources)
    if samples > MOST_SAMPLES:
        allowed = f"at most {MOST_SAMPLES:,} samples"
        found = counted(samples, "sample")
        told = f"The records have {found} in all; at most {MOST_SAMPLES:,} are allowed."
        faults.append(Fault("records", found, allowed, "use fewer or shorter records", told))
    fastest = float(axis_values(axes["natural_frequency_hz"])[-1])
    for source in sources:
        faults += too_long("axes.natural_frequency_hz", source, fastest, numbers["tail_s"])
    return faults


def too_long(field: str, source: RecordSource, natural_frequency_hz: float, tail_s: float) -> list[Fault]:
    """Return a fault if a run under a record takes more than `MOST_WINDOWS` time steps."""
    steps = float(windows_of(source, natural_frequency_hz, tail_s))
    if steps <= MOST_WINDOWS:
        return []
    found = f"{steps:,.0f} steps of {source.called}"
    told = f"{{field}} takes about {found} for each damper; at most {MOST_WINDOWS:,} are allowed."
    advice = "use a shorter record or tail, or a slower structure"
    if source.generated is not None:
        advice = source.generated.shorter
    return [Fault(field, found, f"at most {MOST_WINDOWS:,} steps", advice, told)]
