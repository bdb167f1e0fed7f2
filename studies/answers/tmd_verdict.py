"""Which is better, a study's damper or a tuned mass damper: what is known of it, in sentences."""

from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from damperlab.studies.answers.band import FREQUENCY
from damperlab.studies.answers.hidden_peak import hidden, may_hide, say_hidden
from damperlab.studies.answers.phrases import AMPLITUDE, Phrases
from damperlab.studies.answers.verdict import say_next
from damperlab.studies.variables import Status


def is_judged(answer: xr.Dataset) -> bool:
    """Whether it is known which damper has the lower peak over the band.

    A peak is the largest of all values, so it is known to be higher as soon as one value is. That it is lower is known only if
    every frequency has a value, and if they are so close that no resonance as high lies between them.

    Parameters
    ----------
    answer : Dataset
        Of `tmd_comparison`, with its peaks and their `ratio`.
    """
    if answer.sizes[FREQUENCY] == 1 or np.isnan(answer.attrs["ratio"]):
        return False
    hybrid = answer["hybrid"].values
    if answer.attrs["ratio"] > 1 or not np.isfinite(hybrid).all():
        return bool(answer.attrs["ratio"] > 1)
    return not may_hide(
        answer[FREQUENCY].values, hybrid, answer.attrs["tmd_peak"], float(answer["mass_ratio"])
    )


def verdict(answer: xr.Dataset, phrases: Phrases) -> list[str]:
    """Say which damper has the lower peak over the band, or why that is not known.

    Parameters
    ----------
    answer : Dataset
        Of `tmd_comparison`, with its peaks, their `ratio`, and `judged`.
    phrases : Phrases
        How quantities are spelled.
    """
    words = _which(answer, phrases)
    where = _hidden(answer)
    if where.any():
        zeta = np.array([float(answer["damping_ratio"])])
        words.append(
            say_hidden("The largest value of this design", answer[FREQUENCY].values, where, zeta, phrases)
        )
    elif answer.sizes[FREQUENCY] > 1 and not answer.attrs["judged"] and not _missing(answer):
        words.append("Compute more frequencies.")
    return words


def _hidden(answer: xr.Dataset) -> NDArray[np.bool_]:
    """Where this design's peak may lie between the frequencies, as `hidden` says; nowhere where not all are known."""
    hybrid, r = answer["hybrid"].values, answer[FREQUENCY].values
    if r.size == 1 or not np.isfinite(hybrid).all():
        return np.zeros((1, r.size - 1), np.bool_)
    kinds = answer["response_class"].values if "response_class" in answer else np.full(r.size, -1, np.int8)
    zeta, beta = (np.array([float(answer[name])]) for name in ("damping_ratio", "mass_ratio"))
    return hidden(r, hybrid[None], kinds[None], zeta, beta)


def _which(answer: xr.Dataset, phrases: Phrases) -> list[str]:
    found: dict[str, Any] = answer.attrs
    r = answer[FREQUENCY].values
    if np.isinf(found["hybrid_peak"]):
        at = phrases.equal(FREQUENCY, found["hybrid_peak_at"])
        return [
            f"The response of this design grows without bound at {at}; the peak of the tuned mass damper is "
            f"{phrases.value(AMPLITUDE, found['tmd_peak'])}."
        ]
    missing = _missing(answer)
    if np.isnan(found["ratio"]):
        if (answer["status"].values == Status.NOT_COMPUTED).all():
            return ["Nothing of this design's curve is computed yet."]
        return [f"No value of this design's curve is known: {missing}."]
    if r.size == 1:
        return [
            f"Only {phrases.equal(FREQUENCY, r[0], '.10g')} was computed, so nothing is said about which damper is better: a "
            f"tuned mass damper is judged by its peaks, which lie beside {phrases.equal(FREQUENCY, 1.0)}, and so is this one.",
            f"{say_next(phrases)}.",
        ]
    band = phrases.span(FREQUENCY, r[0], r[-1], ".10g")
    peak, error = found["hybrid_peak"], found["hybrid_peak_error"]
    largest = phrases.measured(peak, error) if error == error else phrases.value(AMPLITUDE, peak)
    beside = phrases.value(AMPLITUDE, found["tmd_peak"])
    apart = f"{100 * abs(found['ratio'] - 1):.3g} %"
    if not found["judged"]:
        told = f"Which damper has the lower peak over {band} is not known: "
        if missing:
            return [
                f"{told}{missing}. The largest value of this design so far is {largest}; the peak of the tuned mass damper is "
                f"{beside}."
            ]
        return [
            f"{told}the largest value of this design at {r.size} frequencies, {largest}, is {apart} lower than the peak of the "
            f"tuned mass damper, {beside}, but between them it may be higher than that."
        ]
    if missing:
        return [
            f"The peak of this design over {band} is at least {largest}, {apart} higher than that of the tuned mass damper, "
            f"{beside}; {missing}."
        ]
    which = "lower" if found["ratio"] < 1 else "higher"
    return [
        f"The peak of this design over {band}, {largest} at {r.size} frequencies, is {apart} {which} than that of the tuned "
        f"mass damper, {beside}."
    ]


def _missing(answer: xr.Dataset) -> str:
    """Say how many frequencies have no value, and why; nothing where all have one."""
    unknown = ~np.isfinite(answer["hybrid"].values)
    number = int(unknown.sum())
    if not number:
        return ""
    waiting = int((answer["status"].values[unknown] == Status.NOT_COMPUTED).sum())
    reasons = ((waiting, "not computed yet"), (number - waiting, "failed"))
    why = ", ".join(f"{count:,} {reason}" for count, reason in reasons if count)
    return f"{number:,} of {unknown.size:,} frequencies {'has' if number == 1 else 'have'} no value ({why})"
