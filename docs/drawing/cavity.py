"""What friction of the particle and a tilted cavity change: the figures of `cavity.md`."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from damperlab.service.figures.reproduction import draw_numbers
from damperlab.service.figures.style import BLUE, GREY, VERMILION
from damperlab.service.reproduction.prototype import CASES, WORDS, Prototype, computed_here, peaks_of
from damperlab.studies.definition import parse_harmonic
from damperlab.studies.paper import paper_numbers
from damperlab.studies.plan import Block
from damperlab.studies.tmd.minimax import minimax
from damperlab.studies.tmd.transfer import amplitude_ratio
from damperlab.worker.block import solve_block

FLOOR = {"mass_kg": 250.0, "natural_frequency_hz": 7.6, "base_amplitude_m": 0.001}
"""The floor: ω_n² Z is 0.23 g."""
DAMPING, RESTITUTION, MASS, FORCE_N = 0.02, 0.5, 20.0, 120.0
LOW, HIGH = 0.85, 1.2
COARSE, FINE = 41, 181
"""Frequencies at which a largest amplitude is looked for, and at which a response is drawn."""
CLEARANCES_M = np.geomspace(0.003, 0.018, 20)
FRICTIONS = np.geomspace(0.005, 0.5, 11)
ROLLING = 0.01
"""Friction coefficient of a ball that rolls. A particle without any would rest in mid cavity for good until it is struck."""

FITS = {
    "without friction of the particle": Prototype(0.002, 0.0119, 0.0),
    "with it": Prototype(0.00212, 0.0126, 0.094),
}
"""Of Table 3, as the report on the paper finds them."""


def responses(frequencies: int, **more: Any) -> NDArray[np.float64]:
    """Compute the floor's amplitude [mm] over clearances, then over the band, with what is added to its physical block."""
    physical = FLOOR | {"particle_mass_kg": MASS, "friction_force_n": FORCE_N} | more
    study = parse_harmonic(
        {
            "damping_ratio": DAMPING,
            "physical": physical,
            "axes": {
                "restitution": RESTITUTION,
                "frequency_ratio": {"start": LOW, "stop": HIGH, "num": frequencies},
            },
            "metrics": ["amplitude_ratio"],
        }
    )
    amplitude = solve_block(study, Block.whole(study.shape))["amplitude_ratio"]
    return np.asarray(amplitude).reshape(-1, frequencies)  # Z is 1 mm


def draw_friction_of_the_particle() -> Figure:
    """Draw the largest amplitude over the band by friction of the particle and clearance, and the best clearance."""
    worst = np.array(
        [
            responses(COARSE, clearance_m=CLEARANCES_M.tolist(), particle_friction_coefficient=each).max(
                axis=1
            )
            for each in FRICTIONS
        ]
    )
    figure = Figure(figsize=(8.0, 3.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    drawn = left.pcolormesh(FRICTIONS, 1e3 * CLEARANCES_M, worst.T, cmap="cividis", shading="nearest")
    best_mm = 1e3 * CLEARANCES_M[worst.argmin(axis=1)]
    left.plot(FRICTIONS, best_mm, color=VERMILION, marker="o", ms=3.0, lw=1.0)
    left.set(xscale="log", xlabel="Friction coefficient $μ_i$", ylabel="Clearance [mm]")
    figure.colorbar(drawn, ax=left, label="Largest amplitude [mm]")
    least = int(worst[0].argmin())
    right.plot(FRICTIONS, worst[:, least], color=BLUE, label="best clearance for the least $μ_i$")
    right.plot(FRICTIONS, worst.min(axis=1), color=VERMILION, label="best clearance for each $μ_i$")
    right.set(xscale="log", xlabel="Friction coefficient $μ_i$", ylabel="Largest amplitude [mm]")
    right.set_ylim(bottom=0.0)
    right.legend(loc="upper left")
    return figure


def draw_standing() -> Figure:
    """Draw the response of the floor with the damper lying, standing, and with a tuned mass damper of the same mass."""
    lying = {"particle_friction_coefficient": ROLLING}
    upright = {"tilt_deg": 90.0}
    figure = Figure(figsize=(6.4, 3.2), layout="constrained")
    axes = figure.subplots()
    r = np.linspace(LOW, HIGH, FINE)
    best_m = _best_clearance_m(lying)
    for label, colour, clearance_m, lies in (
        ("lying", BLUE, best_m, lying),
        ("the same, standing", GREY, best_m, upright),
        ("standing", VERMILION, _best_clearance_m(upright), upright),
    ):
        amplitude = responses(FINE, clearance_m=clearance_m, **lies)[0]
        axes.plot(r, amplitude, color=colour, label=f"{label}, {1e3 * clearance_m:.1f} mm")
    tuned = minimax(MASS / FLOOR["mass_kg"], DAMPING)
    axes.plot(
        r, amplitude_ratio(r, tuned, DAMPING), color="black", ls="--", lw=1.0, label="tuned mass damper"
    )
    axes.set(xlabel="Frequency ratio $r$", ylabel="Amplitude [mm]")
    axes.legend(loc="upper right")
    return figure


def _best_clearance_m(lies: dict[str, float]) -> float:
    """Find the clearance of the least amplitude over the band."""
    worst = responses(COARSE, clearance_m=CLEARANCES_M.tolist(), **lies).max(axis=1)
    return float(CLEARANCES_M[worst.argmin()])


def draw_table_3() -> Figure:
    """Draw the amplitudes that the paper measured with a particle, and ours without and with friction of the particle."""
    known = paper_numbers()
    return draw_numbers(
        [f"{WORDS[kind]}\n{known[f'clearance_{k}_mm'].value:g} mm" for kind, k in CASES],
        [known[f"{kind}_{k}"].value for kind, k in CASES],
        {name: list(peaks_of(computed_here(each.study())).values()) for name, each in FITS.items()},
    )
