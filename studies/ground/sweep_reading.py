"""A swept sine read from a document, with every fault of it."""

import math

from damperlab.studies.faults import NOTHING, Fault, StudyFaults, describe, listing, path, unknown_key
from damperlab.studies.ground.motion import MOST_SAMPLES, GroundMotion, checked
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
"""One of them says how fast; a rate is positive whichever way it goes."""
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
"""One of them is constant, by the order of the derivative."""
RAMP_CYCLES = Quantity(
    "ramp_cycles",
    "cycles of `start_hz` in which the amplitude rises, and of `stop_hz` in which it falls",
    FEWEST_RAMP_CYCLES,
    1000.0,
    f"{FEWEST_RAMP_CYCLES:g} is the default",
)
KEYS = (*ENDS, *PACES, *AMPLITUDES, RAMP_CYCLES.name, "name")
MOST_LETTERS = 200


def read_sweep(document: object) -> GroundMotion:
    """Generate the record of a sweep from a document.

    Parameters
    ----------
    document : object
        ``start_hz``, ``stop_hz``, one of `PACES`, one of `AMPLITUDES`, and any of ``ramp_cycles`` and ``name``.

    Raises
    ------
    StudyFaults
        With every fault.
    """
    sweep = sweep_of(document)
    assert isinstance(document, dict)  # or it was refused
    return checked(sweep.motion(document.get("name", "")), PLACE)


def sweep_of(document: object) -> Sweep:
    """Read a sweep, as `read_sweep` does, without its samples.

    Raises
    ------
    StudyFaults
        With every fault.
    """
    if not isinstance(document, dict):
        advice = 'write {"start_hz": 6, "stop_hz": 10, "rate_hz_per_s": 0.2, "base_amplitude_m": 0.001}'
        raise StudyFaults([Fault(PLACE, describe(document), "a mapping", advice)])
    faults = [unknown_key(path((PLACE, key)), key, KEYS, document) for key in document if key not in KEYS]
    found: dict[str, float] = {}
    for key, quantity in (ENDS | PACES | AMPLITUDES | {RAMP_CYCLES.name: RAMP_CYCLES}).items():
        if key in document:
            try:
                found[key] = quantity.read(document[key], f"{PLACE}.{key}")
            except StudyFaults as caught:
                faults.extend(caught.faults)
    faults += [
        Fault(f"{PLACE}.{key}", NOTHING, ENDS[key].allowed, f"add `{key}`")
        for key in ENDS
        if key not in document
    ]
    name = document.get("name", "")
    if not isinstance(name, str) or len(name) > MOST_LETTERS or not name.isprintable():
        faults.append(Fault(f"{PLACE}.name", describe(name), "a short text on one line", "shorten it"))
    pace = _one_of(PACES, document, faults, "how fast the frequency changes", "rate_hz_per_s")
    amplitude = _one_of(AMPLITUDES, document, faults, "how far the base moves", "base_amplitude_m")
    start, stop = (found.get(key) for key in ENDS)
    if start is not None and start == stop:
        told = f"{{field}} = {stop:g} is where the sweep begins: it must be another frequency."
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
        found.get(RAMP_CYCLES.name, FEWEST_RAMP_CYCLES),
    )
    faults = [*_too_short(sweep, pace), *_too_long(sweep, pace)]
    if faults:
        raise StudyFaults(faults)
    return sweep


def sweep_schema() -> dict[str, object]:
    """Return the JSON schema of a sweep."""
    quantities = ENDS | PACES | AMPLITUDES
    return {
        "type": "object",
        "description": "A sine of the base whose frequency runs from `start_hz` to `stop_hz`: with one of "
        f"{listing(PACES)}, and one of {listing(AMPLITUDES)}.",
        "required": list(ENDS),
        "additionalProperties": False,
        "properties": {
            **{name: quantity.schema() for name, quantity in quantities.items()},
            RAMP_CYCLES.name: RAMP_CYCLES.schema(FEWEST_RAMP_CYCLES),
            "name": {"type": "string", "maxLength": MOST_LETTERS, "default": ""},
        },
    }


def _one_of(
    known: dict[str, Quantity], document: dict[object, object], faults: list[Fault], what: str, usual: str
) -> str:
    """Give which of them the document has; a fault where it has none, and one for each beyond the first."""
    given = [key for key in known if key in document]
    if not given:
        told = f"{{field}} does not say {what}: give one of {listing(known)}."
        faults.append(Fault(PLACE, NOTHING, f"one of {listing(known)}", f"add `{usual}`", told))
    for key in given[1:]:
        told = f"{{field}} and `{PLACE}.{given[0]}` both say {what}."
        found, allowed = describe(document[key]), f"one of {listing(known)}"
        faults.append(Fault(f"{PLACE}.{key}", found, allowed, "keep one of them", told))
    return given[0] if given else ""


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
        f"{{field}} makes a sweep of {found}, in which the amplitude takes {ramps:.4g} s to rise and fall: "
        f"{sweep.ramp_cycles:g} cycles at either end."
    )
    return [Fault(f"{PLACE}.{pace}", found, allowed, "sweep slower, or over a wider band", told)]


def _too_long(sweep: Sweep, pace: str) -> list[Fault]:
    if sweep.samples <= MOST_SAMPLES:
        return []
    found, allowed = f"{sweep.samples:,} samples", f"at most {MOST_SAMPLES:,} samples"
    told = (
        f"{{field}} makes {found}: {SAMPLES_PER_CYCLE} in each cycle of {sweep.highest_hz:g} Hz over "
        f"{sweep.duration_s:.4g} s; a record may have at most {MOST_SAMPLES:,}."
    )
    advice = "sweep faster, over a narrower band, or at lower frequencies"
    return [Fault(f"{PLACE}.{pace}", found, allowed, advice, told)]
