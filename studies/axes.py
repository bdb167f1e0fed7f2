"""An axis: the values of one quantity in a study, written as a number, a list or a range."""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict

from damperlab.studies.faults import Fault, StudyFaults, counted, describe, join, path, unknown_key
from damperlab.studies.quantity import (
    CLEARANCE_RATIO,
    DAMPING_RATIO,
    FREQUENCY_RATIO,
    FRICTION_RATIO,
    MASS_RATIO,
    RESTITUTION,
    Quantity,
    read_count,
)
from damperlab.studies.reads import Reads
from damperlab.studies.spacing import evenly_spaced, log_spaced
from damperlab.studies.spelled_numbers import range_advice
from damperlab.studies.vocabulary import DEFAULTS

MAX_AXIS_VALUES = 1_000_000
"""Largest number of values on one axis."""

LARGEST = 1e15
"""Advice converts a step into a number of values only if start, stop and step are below this limit."""

MAX_FAULTS_PER_AXIS = 20
"""Largest number of faulty values listed for one axis, so that the faults of other axes are also listed."""


class Range(BaseModel):
    """Evenly or logarithmically spaced values, both ends included."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    start: float
    stop: float
    num: int
    spacing: Literal["linear", "log"] = "linear"

    def values(self) -> NDArray[np.float64]:
        """Return the values, float64 of shape (num,). Each value is the double nearest to the exact value.

        Each end stands for the shortest decimal number that rounds to its double. So ranges with equal exact values
        give equal doubles on every machine.
        """
        if self.spacing == "log":
            return log_spaced(self.start, self.stop, self.num)
        return evenly_spaced(self.start, self.stop, self.num)


AxisSpec = float | tuple[float, ...] | Range
"""An axis as written: one number, sorted numbers, or a range."""


def axis_values(spec: AxisSpec) -> NDArray[np.float64]:
    """Return the values of an axis as a 1-D float64 array, strictly increasing."""
    if isinstance(spec, Range):
        return spec.values()
    return np.atleast_1d(np.asarray(spec, dtype=np.float64))


class Coordinates(dict[str, NDArray[Any]]):
    """Read-only values along every dimension. Two instances are equal if their dimensions and values are equal."""

    def __init__(self, values: dict[str, NDArray[Any]]) -> None:
        super().__init__(values)
        for axis in values.values():
            axis.flags.writeable = False

    def __eq__(self, other: object) -> bool:
        """Return whether all dimensions and values are equal."""
        if not isinstance(other, Coordinates) or self.keys() != other.keys():
            return NotImplemented if not isinstance(other, Coordinates) else False
        return all(np.array_equal(values, other[name]) for name, values in self.items())

    __hash__ = None


def axis_count(spec: AxisSpec) -> int:
    """Return the number of values of an axis, without computing the values."""
    if isinstance(spec, Range):
        return spec.num
    return len(spec) if isinstance(spec, tuple) else 1


def read_axis(raw: object, quantity: Quantity, field: str = "") -> AxisSpec:
    """Read one axis of a document.

    Parameters
    ----------
    raw : object
        A number, a list of numbers, or a mapping ``{start, stop, num, spacing}``. The numbers of a list may have any
        order; the returned axis is sorted.
    quantity : Quantity
        The quantity along the axis.
    field : str
        Path of `raw` in the document, for the faults.

    Raises
    ------
    StudyFaults
        If the axis has faults; the error lists every fault.
    """
    if isinstance(raw, Range):
        raw = raw.model_dump()
    if isinstance(raw, dict):
        return _read_range(raw, quantity, field)
    if isinstance(raw, list | tuple):
        return _read_list(raw, quantity, field)
    try:
        return quantity.read(raw, field)
    except StudyFaults as error:
        if isinstance(raw, int | float) and not isinstance(raw, bool):
            raise
        allowed = f"{quantity.allowed}, a list of such numbers, or {{start, stop, num, spacing}}"
        span = range_advice(raw)
        faults = [replace(fault, allowed=allowed, advice=span or fault.advice) for fault in error.faults]
        raise StudyFaults(faults) from None


def _read_list(raw: list[Any] | tuple[Any, ...], quantity: Quantity, field: str) -> tuple[float, ...]:
    if not raw:
        advice = "give at least one value, or leave the axis out to get its default"
        raise StudyFaults([Fault(field, "an empty list", "a list of at least one value", advice)])
    if len(raw) > MAX_AXIS_VALUES:
        raise StudyFaults([_too_many(field, len(raw))])
    faults: list[Fault] = []
    first: dict[float, int] = {}
    for index, item in enumerate(raw):
        if len(faults) == MAX_FAULTS_PER_AXIS:
            rest = f"{counted(len(raw) - index, 'more value')} that may be faulty too"
            faults.append(
                Fault(
                    field,
                    rest,
                    "valid values only",
                    "correct the ones listed first, then submit again",
                    f"{{field}} has {counted(len(raw) - index, 'more value')} that have not been checked yet.",
                )
            )
            break
        try:
            value = quantity.read(item)
        except StudyFaults as error:
            faults.extend(fault.under(f"{field}[{index}]") for fault in error.faults)
            continue
        if value in first:
            found = f"{describe(item)}, the value of entry {first[value]} again"
            told = f"{{field}} repeats the value of entry {first[value]}, {describe(item)}."
            faults.append(Fault(f"{field}[{index}]", found, "each value once", "remove the duplicate", told))
        else:
            first[value] = index
    if faults:
        raise StudyFaults(faults)
    return tuple(sorted(first))


def _read_range(raw: dict[Any, Any], quantity: Quantity, field: str) -> Range:
    faults: list[Fault] = []
    known = tuple(Range.model_fields)
    faults.extend(_unknown_of_range(join(field, path([key])), key, raw) for key in raw if key not in known)
    faults.extend(
        Fault(join(field, key), "nothing", "a number", f"add `{key}`; a range needs start, stop and num")
        for key in ("start", "stop", "num")
        if key not in raw
    )
    numbers: dict[str, float] = {}
    for key in ("start", "stop"):
        if key in raw:
            _collect(faults, numbers, key, partial(quantity.read, raw[key], join(field, key)))
    if "num" in raw:
        count = partial(read_count, raw["num"], 1, MAX_AXIS_VALUES, join(field, "num"))
        _collect(faults, numbers, "num", count)
    spacing = raw.get("spacing", "linear")
    if not isinstance(spacing, str) or spacing not in ("linear", "log"):
        faults.append(
            Fault(join(field, "spacing"), describe(spacing), "linear or log", "choose one of the two")
        )
        spacing = None
    if "start" in numbers and spacing == "log" and numbers["start"] == 0:
        faults.append(
            Fault(
                join(field, "start"),
                "0",
                "a number above 0 for log spacing",
                "start above 0, or use linear spacing",
            )
        )
    if len(numbers) == 3 and spacing is not None:
        faults.extend(_order_faults(numbers, field))
    if faults:
        raise StudyFaults(faults)
    spaced: Literal["linear", "log"] = "log" if spacing == "log" else "linear"
    result = Range(start=numbers["start"], stop=numbers["stop"], num=int(numbers["num"]), spacing=spaced)
    if not _distinct(result):
        found = f"{counted(result.num, 'value')} between {result.start!r} and {result.stop!r}"
        raise StudyFaults(
            [
                Fault(
                    field,
                    found,
                    "values that differ in double precision",
                    "use fewer values or a wider range",
                )
            ]
        )
    return result


_COUNTS = ("step", "steps", "n", "count", "points", "number", "nums")
"""Keys of other programs for the number of values or the step of a range."""


def _unknown_of_range(field: str, key: object, raw: dict[Any, Any]) -> Fault:
    """Return the fault of an unknown key of a range. If the key is the step or the number of values in another program,
    advise `num`.
    """
    known = tuple(Range.model_fields)
    fault = unknown_key(field, key, known, raw)
    if key not in _COUNTS:
        return fault
    fault = replace(fault, meant="num")  # the similar word `stop` would be a wrong suggestion for `step`
    if "num" in raw:
        return replace(fault, advice="remove it: `num` is the number of values, both ends included")
    advice = "write `num`, the number of values, both ends included, in its place"
    given = (raw.get("start"), raw.get("stop"), raw[key])
    start, stop, step = (
        float(each)
        if isinstance(each, int | float) and not isinstance(each, bool) and abs(each) < LARGEST
        else math.nan
        for each in given
    )
    spaced = (stop - start) / step if key == "step" and step else math.nan
    if 1.0 <= spaced <= MAX_AXIS_VALUES and abs(spaced - round(spaced)) < 1e-6:
        advice += f": a step of {step:g} makes `num: {round(spaced) + 1}`"
    return replace(fault, advice=advice)


def _distinct(span: Range) -> bool:
    """Return whether double precision distinguishes all values of a range."""
    if span.num == 1:
        return True
    width = (
        math.log(span.stop / span.start) if span.spacing == "log" else (span.stop - span.start) / span.stop
    )
    # rounding changes a value by a relative error of at most 1.2e-16: only much larger steps are safe without a comparison
    return width / (span.num - 1) > 1e-12 or bool(np.all(np.diff(span.values()) > 0.0))


def _collect(faults: list[Fault], numbers: dict[str, float], key: str, read: Callable[[], float]) -> None:
    try:
        numbers[key] = read()
    except StudyFaults as error:
        faults.extend(error.faults)


def _order_faults(numbers: dict[str, float], field: str) -> list[Fault]:
    start, stop, num = numbers["start"], numbers["stop"], int(numbers["num"])
    if num == 1 and start != stop:
        found = f"1, with start {start:g} and stop {stop:g}"
        advice = "ask for more values, or write the one value as a plain number"
        return [Fault(join(field, "num"), found, "at least 2 if start and stop differ", advice)]
    if num > 1 and not start < stop:
        advice = "exchange start and stop, or write a single value as a plain number"
        return [Fault(join(field, "stop"), f"{stop:g}", f"greater than start ({start:g})", advice)]
    return []


def _too_many(field: str, count: int) -> Fault:
    allowed = f"at most {MAX_AXIS_VALUES:,} values on one axis"
    told = f"{{field}} has {counted(count, 'value')}; an axis may have at most {MAX_AXIS_VALUES:,}."
    return Fault(field, counted(count, "value"), allowed, "use fewer values", told)


def axis_schema(quantity: Quantity, default: float | None = None) -> dict[str, Any]:
    """Return the JSON schema of an axis."""
    number = {key: value for key, value in quantity.schema().items() if key != "description"}
    span = {
        "type": "object",
        "properties": {
            "start": number,
            "stop": number,
            "num": {"type": "integer", "minimum": 1, "maximum": MAX_AXIS_VALUES},
            "spacing": {"type": "string", "enum": ["linear", "log"], "default": "linear"},
        },
        "required": ["start", "stop", "num"],
        "additionalProperties": False,
    }
    numbers = {"type": "array", "items": number, "minItems": 1, "uniqueItems": True}
    meaning = quantity.meaning if default is None else f"{quantity.meaning}; {default:g} if left out"
    return {"description": meaning, "anyOf": [number, numbers, span]}


def along(quantity: Quantity, default: float | None = None) -> Reads:
    """Return the annotation of a pydantic field that is an axis of `quantity`."""
    return Reads(lambda raw: read_axis(raw, quantity), axis_schema(quantity, default))


DampingRatio = Annotated[AxisSpec | None, along(DAMPING_RATIO, DEFAULTS["damping_ratio"])]
Restitution = Annotated[AxisSpec | None, along(RESTITUTION, DEFAULTS["restitution"])]
MassRatio = Annotated[AxisSpec | None, along(MASS_RATIO, DEFAULTS["mass_ratio"])]
ClearanceRatio = Annotated[AxisSpec | None, along(CLEARANCE_RATIO)]
FrictionRatio = Annotated[AxisSpec | None, along(FRICTION_RATIO, DEFAULTS["friction_ratio"])]
FrequencyRatio = Annotated[AxisSpec | None, along(FREQUENCY_RATIO)]
