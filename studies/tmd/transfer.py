"""Transfer function of a structure with a tuned mass damper, its curve, and its peaks from the roots of a polynomial."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from damperlab.studies.tmd.absorber import NO_DAMPER, Absorber
from damperlab.studies.tmd.stationary import Heights, all_stationary
from damperlab.studies.vocabulary import Excitation

ALIKE = 1e-9
"""Largest relative difference between two peak heights that is attributed to rounding."""

BEND = 0.01
"""Largest relative deviation of a curve from the lines between its points. This deviation is too small to be seen."""
LEAST_SHARE = 1e-5
"""Intervals of at most this share of the band are not divided. Otherwise the division would not end near an infinite
peak.
"""


@dataclass(frozen=True)
class Peak:
    """A maximum of the amplitude ratio."""

    value: float
    frequency_ratio: float


def amplitude_ratio(
    frequency_ratio: ArrayLike,
    absorber: Absorber,
    structural_damping: float = 0.0,
    excitation: Excitation = "base",
) -> NDArray[np.float64]:
    """Return the amplitude ratio of the primary mass with a tuned mass damper.

    With λ the frequency ratio, ζ_s the structure's damping ratio and s = 1 + 2iζ_sλ,

        H = a (γ² − λ² + 2iζγλ) / [(s − λ²)(γ² − λ² + 2iζγλ) − μλ²(γ² + 2iζγλ)],

    where a = s for a shaken base, and a = 1 for a force. For ζ_s = 0, H is the paper's equation (13) in both cases.

    Parameters
    ----------
    frequency_ratio : array_like
        λ = ω/ω_n, any shape.
    absorber : Absorber
        The damper.
    structural_damping : float
        ζ_s of the primary structure.
    excitation : {"base", "force"}
        See `Excitation`.

    Returns
    -------
    ndarray
        |H|, with the shape of `frequency_ratio`. |H| is infinite at an undamped resonance.
    """
    lam = np.asarray(frequency_ratio, dtype=float)
    square = lam * lam
    link = absorber.tuning**2 + 2j * absorber.damping_ratio * absorber.tuning * lam
    structure = 1 + 2j * structural_damping * lam
    top = np.abs((structure if excitation == "base" else 1.0) * (link - square))
    bottom = np.abs((structure - square) * (link - square) - absorber.mass_ratio * square * link)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.asarray(top / bottom)
    # For an undamped absorber at its own frequency, numerator and denominator vanish, and the limit of the ratio is 0.
    return np.where((top == 0) & (bottom == 0), 0.0, ratio)


def without_absorber(
    frequency_ratio: ArrayLike, structural_damping: float, excitation: Excitation = "base"
) -> NDArray[np.float64]:
    """Return the amplitude ratio of the structure alone, which is infinite at an undamped resonance."""
    return amplitude_ratio(frequency_ratio, NO_DAMPER, structural_damping, excitation)


def peaks(
    absorber: Absorber, structural_damping: float = 0.0, excitation: Excitation = "base"
) -> tuple[Peak, ...]:
    """Return every stationary point of the amplitude ratio over λ > 0, by ascending frequency.

    See `stationary.Heights` for the method.

    Returns
    -------
    tuple of Peak
        Maxima and minima. The largest value is the H∞ norm, unless the response is largest at λ = 0.
    """
    found = all_stationary(_heights(absorber, structural_damping, excitation))
    return tuple(Peak(float(value), float(np.sqrt(1 + off))) for off, value in zip(*found, strict=True))


def highest(
    absorber: Absorber,
    structural_damping: float = 0.0,
    excitation: Excitation = "base",
    band: tuple[float, float] = (0.0, np.inf),
) -> Peak:
    """Return the largest amplitude ratio over a band of frequencies, both ends included.

    Parameters
    ----------
    absorber, structural_damping, excitation
        As in `amplitude_ratio`.
    band : (float, float)
        Lowest and highest λ; all frequencies by default.

    Returns
    -------
    Peak
        The peak, whose value is infinite if neither the structure nor the absorber has damping and a resonance is in
        the band.
    """
    low, high = band
    if structural_damping == 0 and absorber.damping_ratio * absorber.mass_ratio == 0:
        poles = _undamped_poles(absorber)
        inside = poles[(poles >= low) & (poles <= high)]
        if inside.size:
            return Peak(np.inf, float(inside[0]))
    places, values = _heights(absorber, structural_damping, excitation).candidates()
    inside = (places[0] >= low) & (places[0] <= high)
    ends = np.array([low, high] if np.isfinite(high) else [low])
    places = np.append(places[0][inside], ends)
    values = np.append(values[0][inside], amplitude_ratio(ends, absorber, structural_damping, excitation))
    most = float(values.max())
    # an optimal tuning gives peaks that are equal within rounding: take the one at the lowest frequency
    return Peak(most, float(places[values >= most * (1.0 - ALIKE)].min()))


def _heights(absorber: Absorber, structural_damping: float, excitation: Excitation) -> Heights:
    # this form of γ² − 1 avoids cancellation for a light absorber, which is tuned close to the structure
    offset = (absorber.tuning - 1) * (absorber.tuning + 1)
    return Heights(
        absorber.mass_ratio,
        np.array([absorber.tuning**2]),
        np.array([offset]),
        np.array([absorber.damping_ratio]),
        structural_damping,
        excitation == "base",
    )


def _undamped_poles(absorber: Absorber) -> NDArray[np.float64]:
    if absorber.mass_ratio == 0:
        return np.ones(1)
    gamma = absorber.tuning**2
    middle = (1 + gamma * (1 + absorber.mass_ratio)) / 2
    spread = np.sqrt(middle**2 - gamma)
    return np.asarray(np.sqrt([gamma / (middle + spread), middle + spread]))


def exact_curves(
    frequency_ratio: ArrayLike,
    absorber: Absorber,
    structural_damping: float = 0.0,
    excitation: Excitation = "base",
) -> dict[str, list[float]]:
    """Return the amplitude ratio with a tuned mass damper and without a damper over a band.

    Intervals are divided until straight lines between the points follow both curves to within `BEND`. The amplitude
    scale of these lines is logarithmic.

    Parameters
    ----------
    frequency_ratio : array_like, (n,)
        Ascending frequency ratios, all of which are kept. Further frequency ratios are added between the first and the
        last frequency ratio.
    absorber, structural_damping, excitation
        As in `amplitude_ratio`.

    Returns
    -------
    dict of list
        `frequency_ratio`, and the amplitude ratios `tmd` and `no_damper` at these frequency ratios. An amplitude ratio
        is infinite at an undamped resonance.
    """
    given = np.asarray(frequency_ratio, dtype=float)
    places = [peak.frequency_ratio for peak in peaks(absorber, structural_damping, excitation)] + [1.0]
    r = np.union1d(given, [each for each in places if given[0] < each < given[-1]])
    curves = _both(r, absorber, structural_damping, excitation)
    narrow = LEAST_SHARE * (r[-1] - r[0])
    split = np.flatnonzero(np.diff(r) > narrow)
    while split.size:
        # an interval is tested at both thirds, because the line around an inflection may meet the curve in the middle
        step = np.diff(r)[split] / 3
        thirds = np.stack([r[split] + step, r[split] + 2 * step])
        between = _both(thirds, absorber, structural_damping, excitation)
        with np.errstate(divide="ignore", invalid="ignore"):
            left, right = np.log(curves[:, split]), np.log(curves[:, split + 1])
            line = np.stack([left + (right - left) / 3, left + 2 * (right - left) / 3], axis=1)
            bend = np.abs(np.log(between) - line)
        at = np.repeat(split + 1, 2)
        r = np.insert(r, at, thirds.T.ravel())
        curves = np.insert(curves, at, between.transpose(0, 2, 1).reshape(2, -1), axis=1)
        bent = ~(bend < math.log1p(BEND)).all(axis=(0, 1))
        first = (split + 2 * np.arange(split.size))[bent]
        split = np.sort(np.concatenate([first, first + 1, first + 2]))
        split = split[np.diff(r)[split] > narrow]
    tmd, no_damper = curves
    return {"frequency_ratio": r.tolist(), "tmd": tmd.tolist(), "no_damper": no_damper.tolist()}


def _both(
    r: NDArray[np.float64], absorber: Absorber, structural_damping: float, excitation: Excitation
) -> NDArray[np.float64]:
    beside = amplitude_ratio(r, absorber, structural_damping, excitation)
    return np.stack([beside, without_absorber(r, structural_damping, excitation)])
