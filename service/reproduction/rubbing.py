"""Table 3 once more, with the particle's own friction: one base amplitude, peaks of curves, what is open fitted."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from math import exp, log, pi, sqrt

import numpy as np
import xarray as xr
from scipy.optimize import minimize

from damperlab.service.figures.reproduction import draw_numbers
from damperlab.service.reproduction.readings import INSTANT
from damperlab.service.reproduction.section import Row, Section, Solve
from damperlab.studies.definition import Study, parse_harmonic
from damperlab.studies.paper import paper_numbers
from damperlab.studies.plan import Block
from damperlab.studies.specification.cavity import Cavity
from damperlab.worker.block import solve_block

MEASURED = {"restitution": "restitution_soft", "mass_ratio": "mass_ratio"}
"""What the paper states of the particle, by the names of its numbers."""
BAND = {"start": 0.86, "stop": 1.12, "num": 53}
AMPLITUDES_M, DAMPING, FRICTION = (0.0005, 0.004), (0.002, 0.03), (0.0, 0.2)
"""Physical ranges of the base amplitude Z, of ζ and of μ_i."""
RANGES = (AMPLITUDES_M, DAMPING)
"""Of what is searched in its logarithm."""
STARTS = 4
"""Values of each of them that are looked at first."""
EVALUATIONS = 80
"""Of each fit, after those."""
CAVITIES = (1, 2, 3)
WORDS = {"particle": "particle alone", "hybrid": "hybrid"}
CASES = tuple(product(WORDS, CAVITIES))
"""The numbers of Table 3 with a particle, by what their names begin with and the cavity."""
RMS_DIGITS = 5
"""To which the deviation is compared: two roundings of one response make no other fit."""


@dataclass(frozen=True)
class Prototype:
    """What is open about the prototype: base amplitude Z [m], ζ and μ_i."""

    base_amplitude_m: float
    damping_ratio: float
    particle_friction: float

    @property
    def friction_ratio(self) -> float:
        """γ_F with which friction alone has the peak that the paper prints: (1 − 4γ_F/π)/(2ζ) (Den Hartog)."""
        peak = paper_numbers()["friction_alone"].value
        return 0.25 * pi * (1.0 - 2.0 * self.damping_ratio * peak)

    def study(self) -> Study:
        """Make the study of the particle alone and of the hybrid in each cavity."""
        known = paper_numbers()
        frequency_hz = known["natural_frequency_hz"].value
        cavity = Cavity(self.particle_friction)
        lengths_m = [1e-3 * known[f"clearance_{k}_mm"].value for k in CAVITIES]
        document = {
            "name": f"table-3, μ_i = {self.particle_friction:.4g}",
            "damping_ratio": self.damping_ratio,
            "axes": {
                "clearance_ratio": [length / self.base_amplitude_m for length in lengths_m],
                "friction_ratio": [0.0, self.friction_ratio],
                "frequency_ratio": BAND,
                **{name: known[number].value for name, number in MEASURED.items()},
            },
            "metrics": ["amplitude_ratio"],
        }
        if self.particle_friction > 0.0:
            document["particle_friction_ratio"] = cavity.ratios(frequency_hz, self.base_amplitude_m)[0]
        return parse_harmonic(document)


def peaks_of(amplitude: xr.DataArray) -> dict[str, float]:
    """Give the six peaks of a prototype's responses, by the names of the paper's numbers."""
    peaks = amplitude.max("frequency_ratio").squeeze(drop=True)
    return {
        f"{kind}_{k}": float(peaks.isel(friction_ratio=int(kind == "hybrid"), clearance_ratio=k - 1))
        for kind, k in CASES
    }


def computed_here(study: Study) -> xr.DataArray:
    """Compute the responses of a study that nobody will ask for again, and store nothing."""
    values = solve_block(study, Block.whole(study.shape))
    return xr.DataArray(values["amplitude_ratio"], dims=tuple(study.coordinates))


def table_3_rubbing(solve: Solve, quick: bool) -> Section:
    """Fit base amplitude, damping and the particle's friction to the six numbers with a particle; and without friction."""
    section = Section("Table 3 with the particle's own friction")
    known = paper_numbers()
    fitted = {
        "without friction of the particle": _fitted(quick, rubs=False),
        "with friction of the particle": _fitted(quick, rubs=True),
    }
    found = {
        name: peaks_of(section.solve(solve, prototype.study())["amplitude_ratio"])
        for name, prototype in fitted.items()
    }
    for name, peaks in found.items():
        assumption = f"peak of the curve, {name}"
        for (kind, k), value in zip(CASES, peaks.values(), strict=True):
            quantity = f"{WORDS[kind]}, d = {known[f'clearance_{k}_mm'].value:g} mm"
            section.rows.append(Row(quantity, known[f"{kind}_{k}"], value, assumption, None, INSTANT))
    head = ("fit", "Z [mm]", "ζ", "μ_i", "γ_F", "rms deviation")
    lines: list[tuple[object, ...]] = [
        (
            name,
            f"{1e3 * each.base_amplitude_m:.3g}",
            f"{each.damping_ratio:.3g}",
            f"{each.particle_friction:.3g}",
            f"{each.friction_ratio:.3g}",
            f"{deviation(found[name]):.1%}",
        )
        for name, each in fitted.items()
    ]
    section.tables.append((head, lines))
    section.figures["table-3-friction.png"] = draw_numbers(
        [f"{kind}\n{known[f'clearance_{k}_mm'].value:g} mm" for kind, k in CASES],
        [known[f"{kind}_{k}"].value for kind, k in CASES],
        {name: list(peaks.values()) for name, peaks in found.items()},
    )
    rubbing = found["with friction of the particle"]
    section.words = [
        "The paper lists μ_i, internal friction, among its symbols, and its particle slides on a rail. Here the numbers "
        "of Table 3 are read as peaks of the curves at one base amplitude Z for all cavities. e is the measured one; γ_F is "
        f"that with which friction alone has the peak printed ({known['friction_alone'].value:g}). Z, ζ and μ_i are fitted "
        f"to the six numbers with a particle, within Z of {1e3 * AMPLITUDES_M[0]:g} to {1e3 * AMPLITUDES_M[1]:g} mm, ζ of "
        f"{DAMPING[0]:g} to {DAMPING[1]:g} and μ_i up to {FRICTION[1]:g}, and once with μ_i = 0. The deviation is the root "
        "mean square of the logarithms of ours over the paper's.",
        f"The hybrids of the two longer cavities are printed as {known['hybrid_2'].value:g} and "
        f"{known['hybrid_3'].value:g}, all but equal. With friction of the particle they come out as "
        f"{rubbing['hybrid_2']:.3g} and {rubbing['hybrid_3']:.3g}. Equal numbers say that the particle reaches no wall and "
        "damps by its friction alone.",
        f"The damping ratio that was measured is {known['damping_ratio'].value:g}; what the fit wants beyond it, the model "
        "lacks. Three numbers are fitted to six, and no interval is stated.",
    ]
    return section


def deviation(peaks: Mapping[str, float]) -> float:
    """Give the root mean square of the logarithms of peaks over the paper's."""
    known = paper_numbers()
    off = [log(value / known[name].value) for name, value in peaks.items()]
    return sqrt(sum(each * each for each in off) / len(off))


def _fitted(quick: bool, rubs: bool) -> Prototype:
    """Find the prototype of the least deviation: the best of a coarse grid, and down from there by Nelder and Mead."""

    def prototype(at: np.ndarray) -> Prototype:
        friction = float(np.clip(at[2], *FRICTION)) if rubs else 0.0
        amplitude, damping = (
            exp(float(np.clip(x, log(low), log(high)))) for x, (low, high) in zip(at[:2], RANGES, strict=True)
        )
        return Prototype(float(f"{amplitude:.6g}"), float(f"{damping:.6g}"), float(f"{friction:.6g}"))

    def value(at: np.ndarray) -> float:
        return round(deviation(peaks_of(computed_here(prototype(at).study()))), RMS_DIGITS)

    count = 2 if quick else STARTS
    shares = (np.arange(count) + 0.5) / count
    axes = [log(low) + shares * log(high / low) for low, high in RANGES]
    axes.append(FRICTION[1] * shares**2 if rubs else np.zeros(1))
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    best = min(grid, key=value)
    free = 3 if rubs else 2
    simplex = np.vstack([best[:free], best[:free] + np.diag([0.2, 0.3, 0.02][:free])])
    options = {
        "initial_simplex": simplex,
        "maxfev": 2 if quick else EVALUATIONS,
        "xatol": 1e-3,
        "fatol": 1e-4,
    }
    found = minimize(
        lambda at: value(np.append(at, best[free:])), simplex[0], method="Nelder-Mead", options=options
    )
    return prototype(np.append(found.x, best[free:]))
