"""Judge designs by the responses at the frequencies of the question, slab by slab."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.answers.band import say_only
from damperlab.studies.answers.comparing import Found, limits
from damperlab.studies.answers.design_question import DesignQuestion
from damperlab.studies.answers.phrases import AMPLITUDE, FREQUENCY, OVER_MORE_THAN_Z, Phrases
from damperlab.studies.answers.slab import Slab, slabs_of
from damperlab.studies.faults import counted
from damperlab.studies.portable import product
from damperlab.studies.unit_names import OVER
from damperlab.studies.variables import NONE_IS_ZERO, VARIABLES, ResponseClass, Status

if TYPE_CHECKING:
    import xarray as xr

REASONS: dict[str, str] = {
    "incomplete": "not computed yet at every judged frequency",
    "failed": "failed at a judged frequency",
    "locked": "locked to the base near resonance",
    "too_fast": "impact faster than allowed",
    "outside": "outside a limit on a result",
}
"""Reasons why a design is left out, in words."""


def may_strike(kinds: NDArray[Any]) -> NDArray[np.bool_]:
    """Return for each class of response whether the particle may strike a wall."""
    return np.asarray((kinds >= ResponseClass.SYMMETRIC) & (kinds != ResponseClass.CARRIED))


def new_tally() -> dict[str, int]:
    """Return counters with the value 0: for all designs, and for the designs left out for each reason."""
    return dict.fromkeys(("designs", *REASONS), 0)


def leave_out(
    tally: dict[str, int], reason: str, keep: NDArray[np.bool_], unfit: NDArray[np.bool_] | np.bool_
) -> NDArray[np.bool_]:
    """Return which designs are kept if unfit designs are left out, and count the designs left out for this reason."""
    tally[reason] += int((keep & unfit).sum())
    return np.asarray(keep & ~unfit)


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
    """Judge the designs of a slab.

    Parameters
    ----------
    slab : Slab
        The designs, at the frequencies to judge.
    question : DesignQuestion
        The objective, and the limits on results.
    tally : dict of int
        The counters from `new_tally`, which are updated.
    beside : tuple of str
        Further variables, of which the means over the band are returned. For "impact_speed_max", the largest value is
        returned.

    Returns
    -------
    dict of ndarray
        Arrays with one entry per qualifying design: the grid index along each dimension, `value`, `error`, `lowest` and
        `highest` (the confidence limits of the value) and `response_class`. The index along the frequency is
        that of the largest amplitude. Further arrays are `locked_share`, `locked_near_resonance` (whether the
        mass is locked at the judged frequency nearest r = 1), `impact_share` and the variables of `beside`.
    """
    cube, load = slab.cube, slab.read
    status = load("status")
    amplitude = load(AMPLITUDE)
    keep = np.ones(len(status), bool)
    tally["designs"] += keep.size
    keep = leave_out(tally, "incomplete", keep, (status == Status.NOT_COMPUTED).any(axis=1))
    failed = (status > Status.MAX_CYCLES) | ~np.isfinite(amplitude)
    keep = leave_out(tally, "failed", keep, failed.any(axis=1))
    nothing = np.full_like(amplitude, np.nan)
    error = load("amplitude_error") if "amplitude_error" in cube else nothing
    classed = "response_class" in cube
    kind = load("response_class") if classed else np.full_like(status, ResponseClass.UNKNOWN)
    locked = kind == ResponseClass.LOCKED
    if question.judging.exclude_locked:
        keep = leave_out(tally, "locked", keep, locked[:, question.nearest])
    if question.judging.max_impact_speed is not None:
        # the missing impact speed of a design without impacts does not exclude the design
        too_fast = (load("impact_speed_max") > question.judging.max_impact_speed).any(axis=1)
        keep = leave_out(tally, "too_fast", keep, too_fast)
    for name, (low, high) in question.limits.items():
        values = load(name)
        if name in NONE_IS_ZERO:
            values = np.nan_to_num(values)
        # an undefined value lies outside every range
        outside = ~((values >= low) & (values <= high)).all(axis=1)
        keep = leave_out(tally, "outside", keep, outside)
    rows = np.flatnonzero(keep)
    amplitude, error, kind, locked = amplitude[rows], error[rows], kind[rows], locked[rows]
    # the error of a run that ended at the cycle limit may be larger than stated
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
        # missing impact speeds (no impacts) and missing shares (no dissipation) become 0
        known = np.nan_to_num(load(name)[rows])
        found[name] = (
            known.max(axis=1, initial=0.0) if name == "impact_speed_max" else product(known, question.weights)
        )
    return found


def _weigh(question: DesignQuestion, amplitude: np.ndarray) -> np.ndarray:
    """Return the value of each design from the amplitudes. Bounds of the amplitudes give bounds of the value."""
    if question.objective in ("resonance", "peak"):
        return np.asarray(amplitude.max(axis=1))
    if question.objective == "band_mean":
        return product(amplitude, question.weights)
    return np.sqrt(product(amplitude**2, question.weights))


def _error(question: DesignQuestion, amplitude: np.ndarray, error: np.ndarray) -> np.ndarray:
    """Return the error of each design's value. Errors are propagated to first order, all with the same sign."""
    if question.objective in ("resonance", "peak"):
        return np.take_along_axis(error, amplitude.argmax(axis=1)[:, None], axis=1)[:, 0]
    if question.objective == "band_mean":
        return product(error, question.weights)
    rms = _weigh(question, amplitude)
    return product(amplitude * error, question.weights) / np.where(rms > 0, rms, 1.0)


def described(cube: "xr.Dataset", question: DesignQuestion, found: Mapping[str, np.ndarray]) -> "xr.Dataset":
    """Return judged designs as a Dataset along `rank`, with coordinates, units and long names."""
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
    """Describe the limits on the results of designs.

    The limits are written as ratios, and also in physical units if the study is given in physical units.
    """

    def spelled(name: str, *ends: float) -> str:
        over = f" {OVER[name]}" if name in OVER_MORE_THAN_Z else ""
        ratio = " to ".join(f"{end:.6g}" for end in ends) + over
        unit = phrases.unit(name)
        return f"{ratio} = {' to '.join(phrases.number(name, end) for end in ends)}{unit}" if unit else ratio

    told = [
        f"{VARIABLES[name].long_name} from {spelled(name, low, high)}"
        for name, (low, high) in question.limits.items()
    ]
    if question.judging.max_impact_speed is not None:
        told.insert(0, f"impacts of at most {spelled('impact_speed_max', question.judging.max_impact_speed)}")
    return f"Allowed at every judged frequency: {'; '.join(told)}." if told else ""


def say_judged(question: DesignQuestion, computed: int, phrases: Phrases) -> str:
    """Say at how many of the computed frequencies designs were judged."""
    low, high = question.frequencies[0], question.frequencies[-1]
    if question.frequencies.size == 1:
        return say_only(low, computed == 1, phrases)
    span = phrases.span(FREQUENCY, low, high, ".10g")
    return f"Judged at {question.frequencies.size} frequencies from {span}."


def say_left_out(tally: Mapping[str, int], reasons: Mapping[str, str] = REASONS, noun: str = "design") -> str:
    """Say how many designs were left out for each reason; empty if none was left out."""
    why = [f"{tally[name]} {reason}" for name, reason in reasons.items() if tally.get(name)]
    return f"Left out of {counted(tally['designs'], noun)}: {', '.join(why)}." if why else ""


def attributes_of(question: DesignQuestion, tally: Mapping[str, int]) -> dict[str, object]:
    """Return the attributes of every judgement: objective, band, number of frequencies, completeness and counts."""
    return {
        "objective": question.objective,
        "band": [float(question.frequencies[0]), float(question.frequencies[-1])],
        "frequencies": int(question.frequencies.size),
        "complete": 1 - tally["incomplete"] / tally["designs"],
        **tally,
    }
