"""Advice on base-motion keys that belong in a specification and not in a study."""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from damperlab.studies.amplitudes import AMPLITUDE, CONSTANT, RATIOS_OF
from damperlab.studies.faults import NOTHING, Fault, describe

KEYS = {"base_velocity_m_per_s": "velocity", "base_acceleration_m_per_s2": "acceleration"}
"""For each key of a specification, the equivalent value of `constant` in a study."""


def named_after_motion(faults: Iterable[Fault], raw: Mapping[str, Any]) -> Iterator[Fault]:
    """Add advice to the faults of the keys in `KEYS`, and omit faults that only these keys cause."""
    physical = raw.get("physical")
    written = [key for key in KEYS if isinstance(physical, dict) and key in physical]
    if not isinstance(physical, dict) or not written:
        yield from faults
        return
    fields = {f"physical.{key}": key for key in written}
    forced = raw.get("excitation") == "force"
    for fault in faults:
        if fault.field in fields and forced:
            told = "{field} is a key of designs, and the base of this structure stands still: a force excites it."
            found = describe(physical[fields[fault.field]])
            yield replace(fault, found=found, advice="remove it", message=told)
        elif fault.field in fields:
            yield _as_constant(fault, fields[fault.field], physical, raw.get("particle", True) is not False)
        elif forced or (
            not (fault.field == f"physical.{AMPLITUDE}" and fault.found == NOTHING)
            and (fault.field != "physical.constant" or physical.get("constant") not in CONSTANT)
        ):
            yield fault


def _as_constant(fault: Fault, key: str, physical: Mapping[str, Any], particle: bool) -> Fault:
    constant = KEYS[key]
    power = CONSTANT[constant]
    law = "A/ω_n²" if power > 1 else "V/ω_n"
    amplitude = _amplitude(physical[key], physical.get("natural_frequency_hz"), power)
    value = f"`{AMPLITUDE}: [{amplitude}]`"
    needed = [name for name in RATIOS_OF if particle or name != "clearance_m"]
    beside = (
        ""
        if all(name in physical for name in needed)
        else f", and give {' and '.join(f'`{n}`' for n in needed)} too"
    )
    if amplitude is None:
        value = f"a list `{AMPLITUDE}`"
    advice = (
        f"write `constant: {constant}` and {value} in its place{beside}. The list, even if it has one value, "
        f"holds the amplitude {law} at the natural frequency"
    )
    told = f"{{field}} is a key of designs; a study writes this {constant} of the base as `constant: {constant}`."
    return replace(fault, found=describe(physical[key]), advice=advice, message=told)


def _amplitude(level: object, frequency_hz: object, power: int) -> str | None:
    """Return the base amplitudes at the natural frequency, written as in a list; None if an input is not a positive
    number.
    """
    levels = level if isinstance(level, list | tuple) else [level]
    numbers = [
        each
        for each in (*levels, frequency_hz)
        if isinstance(each, int | float) and not isinstance(each, bool)
    ]
    if not levels or len(numbers) != len(levels) + 1 or not all(0.0 < each < 1e12 for each in numbers):
        return None
    rate = (2.0 * math.pi * numbers[-1]) ** power
    return ", ".join(f"{each / rate:.10g}" for each in numbers[:-1])
