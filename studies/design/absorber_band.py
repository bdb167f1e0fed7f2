"""Largest response, or rms of the response, of a structure with a tuned mass damper over a band of frequencies."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.specification.excitation import Excitation
from damperlab.studies.tmd.absorber import Absorber
from damperlab.studies.tmd.stationary import Heights
from damperlab.studies.tmd.transfer import amplitude_ratio, highest

Floats = NDArray[np.float64]
SAMPLES, FEWER = 4001, 601
"""Numbers of frequencies at which a response without a closed form is sampled, for example an acceleration or the rms
over the band. The search for tuning and damping uses `FEWER`.
"""
BESIDE, FEWER_BESIDE = 60, 12
"""Numbers of additional frequencies on either side of each peak of X/Z, if the rms is judged. The additional
frequencies become denser towards the peak, because a narrow peak may lie between two samples.
"""
CLOSEST, FARTHEST = 1e-6, 0.3
"""Smallest and largest relative distance of the additional frequencies from a peak."""


class Judged(NamedTuple):
    """The judged quantity: a displacement, or a derivative of a displacement, multiplied by `factor`.

    Attributes
    ----------
    factor, order
        `factor` and `order` of a `Measure`.
    against_base : bool
        Whether the displacement is relative to the base.
    mean : bool
        Whether the rms over the band is judged, and not the largest value.
    stroke : bool
        Whether the displacement is the stroke of the absorber, relative to the structure.
    """

    factor: float = 1.0
    order: int = 0
    against_base: bool = False
    mean: bool = False
    stroke: bool = False


class Absorbers(NamedTuple):
    """Parameters of n absorbers as arrays of length n; see `Absorber`. If all absorbers have the same mass ratio,
    `mass_ratio` may be a scalar.
    """

    mass_ratio: float | Floats
    tuning: Floats
    damping_ratio: Floats


def worst_of_each(
    excitation: Excitation,
    judged: Judged,
    absorbers: Absorbers,
    damping_ratio: float | Floats,
    shift: float | Floats,
) -> Floats:
    """Return `worst_over` for n absorbers, shape (n,).

    The absorbers share one structure, or each absorber has its own structure. A value without a closed form is sampled
    at fewer frequencies than in `worst_over`.
    """
    return _sampled(excitation, judged, absorbers, damping_ratio, shift, (FEWER, FEWER_BESIDE))


def _sampled(
    excitation: Excitation,
    judged: Judged,
    absorbers: Absorbers,
    damping_ratio: float | Floats,
    shift: float | Floats,
    many: tuple[int, int],
) -> Floats:
    """Return the judged quantity for n absorbers, shape (n,).

    `many` holds the number of frequencies over the band, and the number of frequencies on either side of a peak.
    """
    share = 1.0 + np.reshape(shift, (-1, 1))
    low, high = excitation.low / share, excitation.high / share
    samples, beside = (2, 0) if _is_closed(excitation, judged) else many if judged.mean else (many[0], 0)
    tuning, damping = absorbers.tuning[:, None], absorbers.damping_ratio[:, None]
    wide = excitation.high > excitation.low
    if wide:
        square, offset = absorbers.tuning**2, (absorbers.tuning - 1.0) * (absorbers.tuning + 1.0)
        heights = Heights(
            absorbers.mass_ratio,
            square,
            offset,
            absorbers.damping_ratio,
            damping_ratio,
            not excitation.motion.force,
        )
        peaks = heights.candidates()[0]
        apart = np.geomspace(CLOSEST, FARTHEST, beside) if beside else np.empty(0)
        near = (peaks[:, :, None] * (1.0 + np.concatenate([-apart, [0.0], apart]))).reshape(tuning.size, -1)
        even = np.broadcast_to(np.linspace(low[:, 0], high[:, 0], samples, axis=1), (tuning.size, samples))
        r = np.sort(np.concatenate([even, np.clip(near, low, high)], axis=1), axis=1)
    else:
        r = np.broadcast_to(low, (tuning.size, 1))
    base_m = excitation.base_m(excitation.highest_m, r * share)
    columns = Absorbers(np.reshape(absorbers.mass_ratio, (-1, 1)), tuning, damping)
    moved = response(excitation, judged, columns, np.reshape(damping_ratio, (-1, 1)), r)
    values: Floats = judged.factor * base_m * rates(judged, 1.0, r) * moved
    if judged.mean and wide:
        return np.asarray(np.sqrt(np.trapezoid(values**2, r, axis=1) / (high - low)[:, 0]))
    return np.asarray(values.max(axis=1))


def _is_closed(excitation: Excitation, judged: Judged) -> bool:
    """Whether the judged quantity is X/Z times a constant. The largest value of X/Z has a closed form.

    An acceleration is X/Z times a constant if the amplitude of the base acceleration is constant, because the ratio of
    the two accelerations is X/Z.
    """
    motion = excitation.motion
    return (
        not judged.mean
        and not judged.stroke
        and judged.order == motion.order
        and (motion.force or not judged.against_base)
    )


def rates(judged: Judged, angular_frequency: float, r: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the ratio of the derivative of order n to the displacement, (ω_n r)**n, where n is `judged.order`."""
    found: NDArray[np.float64] = (angular_frequency * r) ** judged.order
    return found


def worst_over(
    excitation: Excitation,
    judged: Judged,
    absorber: Absorber,
    damping_ratio: float,
    shift: float,
) -> float:
    """Return the judged quantity over a band, under the largest amplitude of the excitation.

    Parameters
    ----------
    excitation : Excitation
        Excitation over a band, with frequencies relative to the nominal natural frequency.
    judged : Judged
        The judged quantity.
    absorber : Absorber
        The absorber, with ratios relative to the structure as built.
    damping_ratio, shift : float
        ζ of the structure as built, and the relative deviation of its natural frequency from nominal.

    Returns
    -------
    float
        The judged quantity divided by ω_n**order, with ω_n of the structure as built and the order of `judged`.
    """
    if _is_closed(excitation, judged):
        band = (excitation.low / (1.0 + shift), excitation.high / (1.0 + shift))
        top = highest(absorber, damping_ratio, "force" if excitation.motion.force else "base", band)
        return judged.factor * excitation.highest_m * top.value / (1.0 + shift) ** judged.order
    one = Absorbers(absorber.mass_ratio, np.array([absorber.tuning]), np.array([absorber.damping_ratio]))
    return float(_sampled(excitation, judged, one, damping_ratio, shift, (SAMPLES, BESIDE))[0])


def response(
    excitation: Excitation,
    judged: Judged,
    absorber: "Absorber | Absorbers",
    damping_ratio: float | Floats,
    r: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the amplitude ratio of the structure's absolute or relative motion, or of the absorber's stroke.

    For the formula see `damperlab.studies.tmd.transfer.amplitude_ratio`. The stroke, relative to the structure, is
    λ²/(γ² − λ² + 2iζγλ) times the structure's displacement.
    """
    if excitation.motion.force and not judged.stroke:
        return amplitude_ratio(r, absorber, damping_ratio, "force")  # type: ignore[arg-type]  # one or several absorbers
    square = r * r
    link = absorber.tuning**2 + 2j * absorber.damping_ratio * absorber.tuning * r
    structure = 1 + 2j * damping_ratio * r
    bottom = (structure - square) * (link - square) - absorber.mass_ratio * square * link
    brought = 1.0 if excitation.motion.force else structure
    top = brought * square if judged.stroke else brought * (link - square)
    if judged.against_base:
        top = top - bottom
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.abs(top / bottom)
    return np.where(np.isfinite(found), found, math.inf)
