"""Find out whether a peak may lie between the computed frequencies of a response."""

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.answers.design_question import DesignQuestion
from damperlab.studies.answers.judging import may_strike
from damperlab.studies.answers.nearness import nearest_place
from damperlab.studies.answers.phrases import FREQUENCY
from damperlab.studies.brief import Note
from damperlab.studies.store.export.slabs import BUDGET
from damperlab.studies.variables import ResponseClass

if TYPE_CHECKING:
    import xarray as xr

HIGHER = 1.1
"""A hidden peak is reported only if it may exceed the largest value by this factor."""
PER_BANDWIDTH = 4
"""Number of steps per bandwidth that resolves a resonance.

With this number of steps, a computed peak is at most 3 % too low.
"""
MOST_FREQUENCIES = 1001
"""Number of frequencies that is advised if even this number does not resolve a narrow resonance.

If halving all steps gives more than `MOST_FREQUENCIES` frequencies, halving all steps is advised instead.
"""

PEAK_BETWEEN = "Between the frequencies computed a peak may be more than a tenth higher."


def may_hide(r: NDArray[np.float64], values: NDArray[np.float64], peak: float, mass_ratio: float) -> bool:
    """Whether a resonance of the structure may reach `peak` between two neighbouring frequencies.

    Near a resonance at r₀ with height P, X = 1/√((1 + β)² (r² − r₀²)² + 1/P²) if the particle of mass ratio β moves
    with the structure. If the particle does not move with the structure, the formula has 1 instead of 1 + β.
    A resonance in the middle of an interval is the hardest to detect: at both ends, |r² − r₀²| is then half
    the width of the interval in r². So if the values at both ends are lower than X at this distance, no
    resonance of height P lies in the interval. Narrower features, for example a separate response next to a
    jump, are not excluded.

    Parameters
    ----------
    r, values : ndarray, (n,)
        Ascending frequency ratios, and the amplitude ratio at each of them.
    peak : float
        Amplitude ratio of the peak.
    mass_ratio : float
        Mass ratio β.
    """
    half = 0.5 * (1.0 + mass_ratio) * np.diff(r * r)
    return bool((np.maximum(values[:-1], values[1:]) >= 1.0 / np.sqrt(half**2 + peak**-2.0)).any())


def hidden(
    r: NDArray[np.float64],
    values: NDArray[np.float64],
    kinds: NDArray[np.int8],
    damping_ratio: NDArray[np.float64],
    mass_ratio: NDArray[np.float64],
    level: float | None = None,
) -> NDArray[np.bool_]:
    """Find the intervals in which the response of a design may exceed a level.

    Only intervals wider than ζ, half of the half-power bandwidth, are examined. A peak may hide in such an interval in
    two cases:

    * A resonance raises the response at both ends of the interval, see `may_hide`. The height of the resonance is at
      most 1/(2ζ), the height without a damper. The interval overlaps the range of natural frequencies, from
      1/√(1 + β), where the particle moves with the structure, to 1.
    * The particle strikes at one end only, so the response jumps within the interval. One end may lie on the flank
      of a resonance. The flank may extend over the interval as far as the other end. For an infinite height P, the
      formula in `may_hide` is X = 1/((1 + β)|r² − r₀²|). So a flank with the value X at one end reaches at most
      1/(1/X − (1 + β) Δ(r²)) within the interval. The flank is unbounded if the denominator of this expression is
      not positive. A flank rises towards the range of natural frequencies.

    No peak hides between two frequencies at which friction holds the mass, because the force that is required to hold
    the mass increases with the frequency.

    Parameters
    ----------
    r : ndarray, (n,)
        Ascending frequencies.
    values, kinds : ndarray, (designs, n)
        Amplitude ratio and class of response at those frequencies. Where an amplitude ratio is unknown, the result is
        False.
    damping_ratio, mass_ratio : ndarray, (designs,)
        ζ and β of each design.
    level : float, optional
        The level as an amplitude ratio; by default `HIGHER` times the largest computed value of each design.

    Returns
    -------
    ndarray, (designs, n − 1)
    """
    zeta, beta = damping_ratio[:, None], mass_ratio[:, None]
    ends = values[:, :-1], values[:, 1:]
    known = np.isfinite(ends[0]) & np.isfinite(ends[1])
    highest = np.nanmax(np.where(np.isfinite(values), values, 0.0), axis=1, keepdims=True)
    exceeded = HIGHER * highest if level is None else np.maximum(level, highest)
    coarse = np.diff(r) > zeta
    rises, falls = r[:-1] <= 1.0, r[1:] >= 1.0 / np.sqrt(1.0 + beta)
    with np.errstate(divide="ignore"):
        flank = 1.0 / np.where(known, np.maximum(*ends), np.inf)
        rising = 1.0 / np.where(known, np.maximum(ends[0] * rises, ends[1] * falls), np.inf)
        limit = 1.0 / exceeded
        alone = np.sqrt(1.0 + beta) * np.sqrt(1.0 + 4.0 * zeta**2) / (2.0 * zeta)
    width = (1.0 + beta) * np.diff(r * r)
    strikes = may_strike(kinds) & (beta > 0)
    jumps = (strikes[:, :-1] != strikes[:, 1:]) & (kinds[:, :-1] >= 0) & (kinds[:, 1:] >= 0)
    held = (kinds[:, :-1] == ResponseClass.LOCKED) & (kinds[:, 1:] == ResponseClass.LOCKED)
    seen_by_both = rises & falls & (flank**2 - (0.5 * width) ** 2 < limit**2)
    seen_by_one = jumps & (rising - width < limit)
    return np.asarray(known & coarse & ~held & (exceeded < alone) & (seen_by_both | seen_by_one), np.bool_)


def hidden_of(
    cube: "xr.Dataset", r: NDArray[np.float64], design: Mapping[str, Any], level: float | None = None
) -> NDArray[np.bool_]:
    """Apply `hidden` to one design of a study. The cube is not read if no interval is wide enough to hide a peak.

    Parameters
    ----------
    cube : Dataset
        A study of the response to a harmonic base.
    r : ndarray, (n,)
        The judged frequencies of the study, ascending.
    design : mapping
        The values of the design along the other dimensions.
    level : float, optional
        As in `hidden`.

    Returns
    -------
    ndarray, (n − 1,)
    """
    zeta, beta = (np.array([float(design[name])]) for name in ("damping_ratio", "mass_ratio"))
    if not (np.diff(r) > zeta).any():
        return np.zeros(r.size - 1, np.bool_)
    wanted = {str(name): design[str(name)] for name in cube["status"].dims if name != FREQUENCY}
    place = {name: nearest_place(cube[name].values, value) for name, value in wanted.items()}
    # a follow-up may have the same frequencies up to rounding
    one = cube.isel({**place, FREQUENCY: [nearest_place(cube[FREQUENCY].values, each) for each in r]})
    kinds = one["response_class"].values if "response_class" in cube else np.full(r.size, -1, np.int8)
    values = np.asarray(one["amplitude_ratio"].values, np.float64)
    return np.asarray(hidden(r, values[None], kinds[None], zeta, beta, level)[0])


def hidden_on(
    cube: "xr.Dataset", metric: str, plane: tuple[str, str], index: Mapping[str, int]
) -> list[Note]:
    """Apply `hidden` to every point of a map of the largest values over the frequency, and note where peaks may hide.

    Parameters
    ----------
    cube : Dataset
        A study of the response to a harmonic base.
    metric : str
        An amplitude of the structure.
    plane : tuple of str
        Dimensions of the map.
    index : mapping of int
        Grid indices along the other dimensions.
    """
    order = np.argsort(cube[FREQUENCY].values)
    r = cube[FREQUENCY].values[order]
    part = cube.isel({name: place for name, place in index.items() if name != FREQUENCY})
    one = part["status"].isel({FREQUENCY: 0})

    def each(name: str) -> NDArray[np.float64]:
        return np.asarray(part[name].broadcast_like(one).transpose(*plane).values, np.float64).ravel()

    zeta, beta = each("damping_ratio"), each("mass_ratio")
    if not (np.diff(r) > zeta.min()).any():
        return []  # no step exceeds half of the smallest bandwidth, so no peak can hide
    where = np.zeros((zeta.size, r.size - 1), np.bool_)
    extent, across = (part.sizes[name] for name in plane)
    step = max(1, BUDGET // (across * r.size))
    for start in range(0, extent, step):
        some = part.isel({plane[0]: slice(start, start + step), FREQUENCY: order})
        rows = slice(start * across, (start + step) * across)

        def load(name: str, some: "xr.Dataset" = some) -> NDArray[Any]:
            return np.asarray(some[name].transpose(*plane, FREQUENCY).values).reshape(-1, r.size)

        values = load(metric).astype(np.float64)
        kinds = load("response_class") if "response_class" in cube else np.full(values.shape, -1, np.int8)
        where[rows] = hidden(r, values, kinds, zeta[rows], beta[rows])
    places = {"places": int(where.any(axis=1).sum()), "of": len(where)}
    return hidden_note(r, where, zeta, places)


def hidden_note(
    r: NDArray[np.float64],
    where: NDArray[np.bool_],
    damping_ratio: NDArray[np.float64],
    whose: Mapping[str, Any] = MappingProxyType({}),
) -> list[Note]:
    """Return a note that the largest value over a band may miss the peak.

    The note advises frequencies that resolve the peak. The list is empty if no peak hides.

    Parameters
    ----------
    r, where : ndarray, (n,) and (designs, n − 1)
        The frequencies given to `hidden`, and its result.
    damping_ratio : ndarray, (designs,)
        ζ of each design.
    whose : mapping
        Data of the note about the designs or points with hidden peaks.
    """
    if not where.any():
        return []
    bandwidth = 2.0 * float(damping_ratio[where.any(axis=1)].min())
    axis = {"start": float(r[0]), "stop": float(r[-1]), "num": _number(r, bandwidth)}
    apart = float(np.diff(r)[where.any(axis=0)].max())
    return [Note("hidden_peak", "danger", {**whose, "apart": apart, "bandwidth": bandwidth, **axis})]


def _number(r: NDArray[np.float64], bandwidth: float) -> int:
    """Return the advised number of frequencies. On an evenly spaced axis, the computed frequencies are kept."""
    steps = np.diff(r)
    wanted = bandwidth / PER_BANDWIDTH
    twice = 2 * r.size - 1
    if wanted * MOST_FREQUENCIES < r[-1] - r[0]:
        return max(twice, MOST_FREQUENCIES)
    if np.allclose(steps, steps[0], rtol=1e-6):
        return (r.size - 1) * _ceiling(float(steps[0]) / wanted) + 1
    return max(twice, _ceiling(float(r[-1] - r[0]) / wanted) + 1)


def _ceiling(steps: float) -> int:
    # the factor prevents rounding from adding a step
    return math.ceil(steps * (1.0 - 1e-9))


MOST_PEAKS = 10
"""Number of designs of a ranking that are checked for hidden peaks."""


def hidden_peaks(
    cube: "xr.Dataset",
    question: DesignQuestion,
    ranked: "xr.Dataset",
    lead: Mapping[str, Any],
    homes: "Mapping[str, xr.Dataset] | None" = None,
) -> list[Note]:
    """Return a note if any of the ranked designs, or the recommended one, may have a hidden peak.

    Of the ranked designs, at most the first `MOST_PEAKS` are checked.
    """
    r = question.frequencies
    listed = min(question.top, ranked.sizes["rank"], MOST_PEAKS)
    if question.objective != "peak" or r.size == 1 or not listed:
        return []
    names = [*question.design, *(["study"] if homes else [])]
    designs = [{name: ranked[name].values[rank].item() for name in names} for rank in range(listed)]
    recommended = {name: lead[name] for name in names}
    designs += [] if recommended in designs else [recommended]
    where = np.array([hidden_of(homes[each["study"]] if homes else cube, r, each) for each in designs])
    zeta = np.array([each["damping_ratio"] for each in designs])
    return hidden_note(
        r, where, zeta, whose([bool(each.any()) for each in where], listed, designs.index(recommended))
    )


def whose(hides: Sequence[bool], listed: int, recommended: int = 0) -> dict[str, Any]:
    """Return the data of a note: how many designs, and which of them, may have hidden peaks.

    Parameters
    ----------
    hides : sequence of bool
        For each listed design, whether a peak may be hidden. One more entry follows if the recommended design
        is not listed.
    listed : int
        Number of listed designs.
    recommended : int
        Index of the recommended design in `hides`.
    """
    return {
        "designs": sum(hides),
        "listed": sum(hides[:listed]),
        "of": listed,
        "best": hides[0],
        "with_impacts": any(hides[listed:]),
        "recommended": hides[recommended],
    }
