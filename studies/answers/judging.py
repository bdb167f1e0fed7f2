"""Judging designs slab by slab: each by its response at the frequencies of the question."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.answers.band import WHY
from damperlab.studies.answers.comparing import Found, limits
from damperlab.studies.answers.design_question import FREQUENCY, METRIC, DesignQuestion
from damperlab.studies.answers.phrases import OVER_MORE_THAN_Z, Phrases
from damperlab.studies.answers.slab import Slab, slabs_of
from damperlab.studies.faults import counted
from damperlab.studies.portable import product
from damperlab.studies.unit_names import OVER
from damperlab.studies.variables import NONE_IS_ZERO, VARIABLES, ResponseClass, Status

if TYPE_CHECKING:
    import xarray as xr

REASONS: dict[str, str] = {
    "incomplete": "not computed yet at every frequency that counts",
    "failed": "failed at a frequency that counts",
    "locked": "locked to the base near resonance",
    "too_fast": "impact faster than allowed",
    "outside": "outside a limit on a result",
}
"""Reasons to leave out a design."""


def may_strike(kinds: NDArray[Any]) -> NDArray[np.bool_]:
    """Whether the particle of a response may strike a wall, by its class: one that is carried never does."""
    return np.asarray((kinds >= ResponseClass.SYMMETRIC) & (kinds != ResponseClass.CARRIED))


def new_tally() -> dict[str, int]:
    """Make the counters of the designs and of those left out, all zero."""
    return dict.fromkeys(("designs", *REASONS), 0)


def judged(
    cube: "xr.Dataset",
    question: DesignQuestion,
    tally: dict[str, int],
    beside: tuple[str, ...] = (),
) -> Iterator[Found]:
    """Judge every design that a question admits, in slabs that fit in memory; see `judge`."""
    for slab in slabs_of(cube, question.axes, question.design):
        yield judge(slab, question, tally, beside)


def judge(slab: Slab, question: DesignQuestion, tally: dict[str, int], beside: tuple[str, ...] = ()) -> Found:
    """Judge designs.

    Parameters
    ----------
    slab : Slab
        The designs, at the frequencies that count.
    question : DesignQuestion
        The objective and limits.
    tally : dict of int
        The counts of `new_tally`; updated.
    beside : tuple of str
        Further variables, each reduced over the band to its largest ("impact_speed_max") or its mean.

    Returns
    -------
    dict of ndarray
        One entry per qualifying design. It has the six grid indices by dimension (the frequency's where the
        amplitude is largest), `value`, `error`, `lowest` and `highest` (its limits with the question's confidence)
        and `response_class`. It also has `locked_share`, `locked_near_resonance` (at the judged frequency nearest r
        = 1), `impact_share` and `beside`.
    """
    cube, load = slab.cube, slab.read
    status = load("status")
    amplitude = load(METRIC)
    missing = (status == Status.NOT_COMPUTED).any(axis=1)
    bad = ~missing & ((status > Status.MAX_CYCLES) | ~np.isfinite(amplitude)).any(axis=1)
    keep = ~missing & ~bad
    tally["designs"] += keep.size
    tally["incomplete"] += int(missing.sum())
    tally["failed"] += int(bad.sum())
    nothing = np.full_like(amplitude, np.nan)
    error = load("amplitude_error") if "amplitude_error" in cube else nothing
    classed = "response_class" in cube
    kind = load("response_class") if classed else np.full_like(status, ResponseClass.UNKNOWN)
    locked = kind == ResponseClass.LOCKED
    if question.exclude_locked:
        tally["locked"] += int((keep & locked[:, question.nearest]).sum())
        keep &= ~locked[:, question.nearest]
    if question.max_impact_speed is not None:
        # without an impact there is no speed: a missing value does not exclude a design
        too_fast = (load("impact_speed_max") > question.max_impact_speed).any(axis=1)
        tally["too_fast"] += int((keep & too_fast).sum())
        keep &= ~too_fast
    for name, (low, high) in question.limits.items():
        values = load(name)
        if name in NONE_IS_ZERO:
            values = np.nan_to_num(values)
        # an undefined value lies in no range
        outside = ~((values >= low) & (values <= high)).all(axis=1)
        tally["outside"] += int((keep & outside).sum())
        keep &= ~outside
    rows = np.flatnonzero(keep)
    amplitude, error, kind, locked = amplitude[rows], error[rows], kind[rows], locked[rows]
    # a run that ended at the cycle limit may have a larger error than it states
    bounded = np.where(status[rows] == Status.MAX_CYCLES, np.nan, error)
    place = amplitude.argmax(axis=1)
    each = np.arange(rows.size)
    value, lowest, highest = (_weigh(question, each) for each in (amplitude, *limits(amplitude, bounded)))
    found: Found = slab.designs_at(rows) | slab.cases_at(place)
    found |= {"value": value, "error": _error(question, amplitude, error)}
    found |= {"lowest": lowest, "highest": np.where(np.isinf(highest), np.nan, highest)}
    unknown = np.full(rows.size, np.nan)
    found |= {
        "response_class": kind[each, place],
        "locked_share": locked.mean(axis=1) if classed else unknown,
    }
    massless = cube["mass_ratio"].values[found["mass_ratio"]] == 0
    found["locked_near_resonance"] = locked[:, question.nearest]
    found["impact_share"] = unknown
    if classed:
        # if friction holds the mass, impacts do not damp it
        strikes = may_strike(kind) & ~massless[:, None]
        if "impacts_per_cycle" in cube:
            strikes &= load("impacts_per_cycle")[rows] > 0
        found["impact_share"] = strikes.mean(axis=1)
    for name in beside:
        # a design without an impact has no impact speed, and one without dissipation no shares
        known = np.nan_to_num(load(name)[rows])
        found[name] = (
            known.max(axis=1, initial=0.0) if name == "impact_speed_max" else product(known, question.weights)
        )
    return found


def _weigh(question: DesignQuestion, amplitude: np.ndarray) -> np.ndarray:
    """Give the value of each design from its amplitudes, or a limit of it from their limits."""
    if question.objective in ("resonance", "peak"):
        return np.asarray(amplitude.max(axis=1))
    if question.objective == "band_mean":
        return product(amplitude, question.weights)
    return np.sqrt(product(amplitude**2, question.weights))


def _error(question: DesignQuestion, amplitude: np.ndarray, error: np.ndarray) -> np.ndarray:
    """Give the error of each design's value; errors propagate to first order, all with one sign."""
    if question.objective in ("resonance", "peak"):
        return np.take_along_axis(error, amplitude.argmax(axis=1)[:, None], axis=1)[:, 0]
    if question.objective == "band_mean":
        return product(error, question.weights)
    rms = _weigh(question, amplitude)
    return product(amplitude * error, question.weights) / np.where(rms > 0, rms, 1.0)


def described(cube: "xr.Dataset", question: DesignQuestion, found: Mapping[str, np.ndarray]) -> "xr.Dataset":
    """Put judged designs into a Dataset along `rank`, with their coordinates, units and names; no attributes."""
    import xarray as xr

    named: dict[str, dict[str, object]] = {
        "value": {"units": "1", "long_name": question.long_name},
        "error": {"units": "1", "long_name": f"error of the {question.long_name}"},
        "lowest": {"units": "1", "long_name": f"lower confidence limit of the {question.long_name}"},
        "highest": {"units": "1", "long_name": f"upper confidence limit of the {question.long_name}"},
        "response_class": dict(cube["response_class"].attrs) if "response_class" in cube else {},
        "locked_share": {
            "units": "1",
            "long_name": "share of the judged frequencies at which the mass is locked",
        },
        "impact_share": {
            "units": "1",
            "long_name": "share of the judged frequencies at which the particle strikes",
        },
    }
    coordinates: dict[str, object] = {"rank": np.arange(1, found["value"].size + 1)}
    for name in (*question.design, FREQUENCY):
        coordinates[name] = ("rank", cube[name].values[found[name]], dict(cube[name].attrs))
    return xr.Dataset(
        {name: ("rank", found[name], attributes) for name, attributes in named.items()}, coordinates
    )


def say_limits(question: DesignQuestion, phrases: Phrases) -> str:
    """Say which results are required of designs, as ratios and, if the study is given in units, also in units."""

    def spelled(name: str, *ends: float) -> str:
        over = f" {OVER[name]}" if name in OVER_MORE_THAN_Z else ""
        ratio = " to ".join(f"{end:.6g}" for end in ends) + over
        unit = phrases.unit(name)
        return f"{ratio} = {' to '.join(phrases.number(name, end) for end in ends)}{unit}" if unit else ratio

    told = [
        f"{VARIABLES[name].long_name} from {spelled(name, low, high)}"
        for name, (low, high) in question.limits.items()
    ]
    if question.max_impact_speed is not None:
        told.insert(0, f"impacts of at most {spelled('impact_speed_max', question.max_impact_speed)}")
    return f"Allowed at every frequency that counts: {'; '.join(told)}." if told else ""


def say_judged(question: DesignQuestion, computed: int, phrases: Phrases) -> str:
    """Say at how many of the computed frequencies designs were judged."""
    low, high = question.frequencies[0], question.frequencies[-1]
    if question.frequencies.size == 1:
        why = "was computed" if computed == 1 else "counts here"
        at = phrases.equal(FREQUENCY, low, ".10g")
        return f"Only one frequency {why}, {at}: the judgement applies to that frequency alone. {WHY}"
    span = phrases.span(FREQUENCY, low, high, ".10g")
    return f"Judged at {question.frequencies.size} frequencies from {span}."


def say_left_out(tally: Mapping[str, int], reasons: Mapping[str, str] = REASONS, noun: str = "design") -> str:
    """Say how many designs were left out, and why; empty if none was."""
    why = [f"{tally[name]} {reason}" for name, reason in reasons.items() if tally.get(name)]
    return f"Left out of {counted(tally['designs'], noun)}: {', '.join(why)}." if why else ""


def attributes_of(question: DesignQuestion, tally: Mapping[str, int]) -> dict[str, object]:
    """Give the common part of every judgement: objective, band, number of frequencies, completeness, counts."""
    return {
        "objective": question.objective,
        "band": [float(question.frequencies[0]), float(question.frequencies[-1])],
        "frequencies": int(question.frequencies.size),
        "complete": 1 - tally["incomplete"] / tally["designs"],
        **tally,
    }
