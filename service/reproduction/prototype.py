"""The paper's prototype: its unknown parameters, and the values that agree best with Table 3."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from math import log, pi, sqrt
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.stats import t as student

from damperlab.service.reproduction.readings import INSTANT, SOFT
from damperlab.studies.cavity import Cavity
from damperlab.studies.definition import Study, parse_harmonic
from damperlab.studies.paper import paper_numbers
from damperlab.studies.plan import Block
from damperlab.studies.variables import PARTICLE_FRICTION
from damperlab.worker.block import solve_block

BAND = {"start": 0.86, "stop": 1.12, "num": 53}
RANGES = {
    "base_amplitude_m": (0.0005, 0.004),
    "damping_ratio": (0.002, 0.03),
    "particle_friction": (0.0, 0.2),
    "restitution": (0.2, 0.9),
}
"""Ranges of the fitted parameters. A search uses fractions of each range, on a logarithmic scale if the range
starts above 0."""
ASSUMED = ("base_amplitude_m", "damping_ratio")
"""Parameters that every fit estimates."""
STARTS = 4
"""Number of initial values of each parameter in `ASSUMED`."""
STEP = 0.08
"""First step of a search, as a fraction of the range."""
EVALUATIONS_EACH = 20
"""Largest number of evaluations in a search, for each free parameter."""
DIFFERENCE = 1e-3
"""Step of the finite differences, as a fraction of the range."""
CONFIDENCE = 0.95
RMS_DIGITS = 5
"""Decimals to which a search rounds deviations, so that every processor gives the same result."""
CAVITIES = (1, 2, 3)
WORDS = {"particle": "particle alone", "hybrid": "hybrid"}
CASES = tuple(product(WORDS, CAVITIES))
"""The six cases of Table 3 with a particle: each damper with each cavity."""


@dataclass(frozen=True)
class Prototype:
    """Unknown parameters of the prototype: base amplitude Z [m], ζ, μ_i, e, and the name of the contact model."""

    base_amplitude_m: float
    damping_ratio: float
    particle_friction: float
    restitution: float = 0.47
    contact: str = INSTANT

    @property
    def friction_ratio(self) -> float:
        """γ_F with which friction alone gives the peak printed in Table 3."""
        return self.friction_of(paper_numbers()["friction_alone"].value)

    def friction_of(self, peak: float) -> float:
        """Return the γ_F with which friction alone gives `peak` = (1 − 4γ_F/π)/(2ζ), after Den Hartog."""
        return 0.25 * pi * (1.0 - 2.0 * self.damping_ratio * peak)

    def study(self) -> Study:
        """Make one study of two dampers, the particle alone and the hybrid, with each cavity."""
        known = paper_numbers()
        lengths_m = [1e-3 * known[f"clearance_{k}_mm"].value for k in CAVITIES]
        particle = {"restitution": self.restitution, "mass_ratio": known["mass_ratio"].value}
        document = {
            "name": f"table-3, μ_i = {self.particle_friction:.4g}, e = {self.restitution:.4g}",
            "damping_ratio": self.damping_ratio,
            "contact": SOFT[self.contact],
            "axes": {
                "clearance_ratio": [length / self.base_amplitude_m for length in lengths_m],
                "friction_ratio": [0.0, self.friction_ratio],
                "frequency_ratio": BAND,
                **particle,
            },
            "metrics": ["amplitude_ratio"],
        }
        if self.particle_friction > 0.0:
            case = {
                "natural_frequency_hz": known["natural_frequency_hz"].value,
                "base_amplitude_m": self.base_amplitude_m,
            }
            cavity = Cavity(self.particle_friction)
            document[PARTICLE_FRICTION] = cavity.ratio(PARTICLE_FRICTION, case)
        return parse_harmonic(document)

    def shares(self, names: Sequence[str]) -> NDArray[np.float64]:
        """Return the values of some parameters as fractions of their ranges, shape (names,)."""
        return np.array([_share(getattr(self, name), *RANGES[name]) for name in names])

    def at(self, names: Sequence[str], shares: Sequence[float] | NDArray[np.float64]) -> "Prototype":
        """Return the prototype with some parameters at fractions of their ranges, clipped to [0, 1]."""
        values: dict[str, Any] = {
            name: _value(share, *RANGES[name]) for name, share in zip(names, shares, strict=True)
        }
        return replace(self, **values)


def _share(value: float, low: float, high: float) -> float:
    return (value - low) / (high - low) if low == 0.0 else log(value / low) / log(high / low)


def _value(share: float, low: float, high: float) -> float:
    """Return the value at a fraction of a range, rounded to six digits so that a study states it exactly."""
    within = float(np.clip(share, 0.0, 1.0))
    return float(f"{low + within * (high - low) if low == 0.0 else low * (high / low) ** within:.6g}")


def peaks_of(amplitude: xr.DataArray) -> dict[str, float]:
    """Return the six peaks of the responses of a prototype, by the names of the paper's numbers."""
    peaks = amplitude.max("frequency_ratio").squeeze(drop=True)
    return {
        f"{kind}_{k}": float(peaks.isel(friction_ratio=int(kind == "hybrid"), clearance_ratio=k - 1))
        for kind, k in CASES
    }


def computed_here(study: Study) -> xr.DataArray:
    """Compute the responses of a study in this process, without storing them."""
    values = solve_block(study, Block.whole(study.shape))
    return xr.DataArray(values["amplitude_ratio"], dims=tuple(study.coordinates))


def off(peaks: Mapping[str, float]) -> NDArray[np.float64]:
    """Return ln(peak / the paper's number) for each peak."""
    known = paper_numbers()
    return np.array([log(value / known[name].value) for name, value in peaks.items()])


def deviation(peaks: Mapping[str, float]) -> float:
    """Return the root mean square of ln(peak / the paper's number)."""
    return sqrt(float(np.mean(off(peaks) ** 2)))


@cache
def deviation_of(prototype: Prototype) -> float:
    """Compute the responses of a prototype, and return the deviation of the peaks."""
    return deviation(peaks_of(computed_here(prototype.study())))


def _seen(prototype: Prototype) -> float:
    return round(deviation_of(prototype), RMS_DIGITS)


def fitted(start: Prototype, free: Sequence[str], quick: bool) -> Prototype:
    """Find the prototype with the smallest deviation near `start`, by the method of Nelder and Mead."""
    first = start.shares(free)
    steps = np.diag(np.where(first > 0.5, -STEP, STEP))
    found = minimize(
        lambda shares: _seen(start.at(free, shares)),
        first,
        method="Nelder-Mead",
        options={
            "initial_simplex": np.vstack([first, first + steps]),
            "maxfev": 2 if quick else EVALUATIONS_EACH * len(free),
            "xatol": 1e-3,
            "fatol": 1e-4,
        },
    )
    return start.at(free, found.x)


def fitted_from_anywhere(start: Prototype, quick: bool) -> Prototype:
    """Find Z and ζ with the smallest deviation, starting from the best point of a coarse grid."""
    count = 1 if quick else STARTS
    shares = (np.arange(count) + 0.5) / count
    grid = [start.at(ASSUMED, each) for each in product(shares, repeat=len(ASSUMED))]
    return fitted(min(grid, key=_seen), ASSUMED, quick)


def intervals(best: Prototype, free: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Return the confidence intervals of fitted parameters, from derivatives and residuals of the fit.

    Least squares with errors of equal, unknown size (Seber and Wild, Nonlinear Regression, 1989, section 5.1): each
    interval is the estimate ± t·s·√((JᵀJ)⁻¹). The degrees of freedom of Student's t are the number of peaks minus the
    number of parameters.
    """

    def left_over(shares: NDArray[np.float64]) -> NDArray[np.float64]:
        return off(peaks_of(computed_here(best.at(free, shares).study())))

    at = best.shares(free)
    steps = DIFFERENCE * np.eye(len(free))
    slopes = np.stack([left_over(at + step) - left_over(at - step) for step in steps], axis=1) / (
        2.0 * DIFFERENCE
    )
    left = left_over(at)
    spare = left.size - len(free)
    spread = np.sqrt(np.sum(left**2) / spare * np.diag(np.linalg.inv(slopes.T @ slopes)))
    half = float(student.ppf(0.5 + 0.5 * CONFIDENCE, spare)) * spread
    ends = (best.at(free, at - half), best.at(free, at + half))
    return {name: (getattr(ends[0], name), getattr(ends[1], name)) for name in free}
