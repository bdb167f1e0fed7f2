"""Reads a swept sine from a document, and reports every fault."""

import math
from typing import Any

from damperlab.studies.faults import Fault, StudyFaults, listing
from damperlab.studies.ground.recipe import OPTIONAL, one_of, read_numbers, schema_of, too_many_samples
from damperlab.studies.ground.sweep import FEWEST_RAMP_CYCLES, SAMPLES_PER_CYCLE, Sweep
from damperlab.studies.physical import BASE_AMPLITUDE
from damperlab.studies.quantity import Quantity

PLACE = "sweep"
ENDS: dict[str, Quantity] = {
    name: Quantity(name, meaning, 0.02, 1000.0, "give it in Hz")
    for name, meaning in (
        ("start_hz", "frequency at the beginning [Hz]"),
        ("stop_hz", "frequency at the end [Hz]; lower than at the beginning in a run-down"),
    )
}
PACES: dict[str, Quantity] = {
    each.name: each
    for each in (
        Quantity("rate_hz_per_s", "change of the frequency [Hz/s]", 1e-6, 1e6, "give it in Hz/s"),
        Quantity("rate_octaves_per_minute", "octaves in a minute", 1e-6, 1e6, "one octave in a minute is usual"),
        Quantity("duration_s", "duration of a sweep at a constant rate in Hz/s [s]", 1e-3, 1e6, "give it in s"),
    )
}  # fmt: skip
"""Keys for the rate of a sweep, which is positive also in a run-down. A document has exactly one of
the keys.
"""
AMPLITUDES: dict[str, Quantity] = {
    each.name: each
    for each in (
        BASE_AMPLITUDE,
        Quantity("base_velocity_m_per_s", "amplitude of the base velocity [m/s]", 1e-12, 1e12, "give it in m/s"),
        Quantity(
            "base_acceleration_m_per_s2", "amplitude of the base acceleration [m/s²]", 1e-12, 1e12, "give it in m/s²"
        ),
    )
}  # fmt: skip
"""Keys for the constant amplitude of displacement, velocity or acceleration."""
RAMP_CYCLES = Quantity(
    "ramp_cycles",
    "cycles of `start_hz` in which the amplitude rises, and of `stop_hz` in which it falls",
    FEWEST_RAMP_CYCLES,
    1000.0,
    f"{FEWEST_RAMP_CYCLES:g} is the default",
)
NUMBERS: dict[str, tuple[Quantity, float | None]] = {
    **{name: (quantity, None) for name, quantity in ENDS.items()},
    **{name: (quantity, OPTIONAL) for name, quantity in (PACES | AMPLITUDES).items()},
    RAMP_CYCLES.name: (RAMP_CYCLES, FEWEST_RAMP_CYCLES),
}


def sweep_of(document: object) -> Sweep:
    """Read a sweep from a document.

    Parameters
    ----------
    document : object
        Mapping with ``start_hz``, ``stop_hz``, one of `PACES`, one of `AMPLITUDES`, and optionally ``ramp_cycles`` and
        ``name``.

    Raises
    ------
    StudyFaults
        If the document is invalid; the exception lists every fault.
    """
    example = '{"start_hz": 6, "stop_hz": 10, "rate_hz_per_s": 0.2, "base_amplitude_m": 0.001}'
    given, found, faults = read_numbers(document, PLACE, NUMBERS, (), example)
    pace = one_of(PACES, given, PLACE, faults, "how fast the frequency changes", "rate_hz_per_s")
    amplitude = one_of(AMPLITUDES, given, PLACE, faults, "how far the base moves", "base_amplitude_m")
    start, stop = (found.get(key) for key in ENDS)
    if start is not None and start == stop:
        told = f"{{field}} = {stop:g} is also the frequency at the start of the sweep; the two must differ."
        advice = "give another frequency"
        faults.append(Fault(f"{PLACE}.stop_hz", f"{stop:g}", "another frequency than start_hz", advice, told))
    if faults or start is None or stop is None:
        raise StudyFaults(faults)
    sweep = Sweep(
        start,
        stop,
        _duration_s(pace, found[pace], start, stop),
        pace == "rate_octaves_per_minute",
        found[amplitude],
        list(AMPLITUDES).index(amplitude),
        found[RAMP_CYCLES.name],
    )
    why = f"{SAMPLES_PER_CYCLE} in each cycle of {sweep.highest_hz:g} Hz over {sweep.duration_s:.4g} s"
    faults = _too_short(sweep, pace) + too_many_samples(f"{PLACE}.{pace}", sweep.samples, why, sweep.shorter)
    if faults:
        raise StudyFaults(faults)
    return sweep


def sweep_schema() -> dict[str, Any]:
    """Return the JSON schema of a sweep."""
    told = "A sinusoidal base motion whose frequency runs from `start_hz` to `stop_hz`, with one of "
    return schema_of(f"{told}{listing(PACES)}, and one of {listing(AMPLITUDES)}.", NUMBERS)


def _duration_s(pace: str, value: float, start: float, stop: float) -> float:
    if pace == "rate_hz_per_s":
        return abs(stop - start) / value
    if pace == "rate_octaves_per_minute":
        return 60.0 * abs(math.log2(stop / start)) / value
    return value


def _too_short(sweep: Sweep, pace: str) -> list[Fault]:
    ramps = sweep.rise_s + sweep.fall_s
    if ramps <= sweep.duration_s:
        return []
    found, allowed = f"{sweep.duration_s:.4g} s", f"a sweep of at least {ramps:.4g} s"
    told = (
        f"{{field}} makes a sweep of {found}, but the amplitude takes {ramps:.4g} s to rise and fall, "
        f"{sweep.ramp_cycles:g} cycles at either end."
    )
    return [Fault(f"{PLACE}.{pace}", found, allowed, "sweep slower, or over a wider band", told)]
