"""Figure 9, and a comparison of Figures 9 and 10: the damper with friction alone."""

import math
from collections.abc import Callable

import numpy as np

from damperlab.service.figures.reproduction import draw_finite_time, draw_friction_law
from damperlab.service.reproduction.readings import FRICTION_RATIOS
from damperlab.service.reproduction.section import Row, Section, Solve, at, variant
from damperlab.studies.paper import PaperNumber, paper_numbers
from damperlab.worker.point import Design
from damperlab.worker.simulate import simulate

LONGEST = 1000
"""Number of cycles in which a free vibration with the paper's damping decays to less than 1e-10."""
SMALL_DAMPING = 1e-4
"""Damping ratio ζ so small that the amplitude at r = 1 equals (1 − 4γ_F/π)/(2ζ) to a millionth."""
ROUNDS = 50


def figure_9(solve: Solve, quick: bool) -> Section:
    """Compute the steady response with friction alone, and the largest response in the first cycles from rest."""
    section = Section("Figure 9: frequency response, friction alone")
    known = paper_numbers()
    ratio, damping = known["friction_ratio"].value, known["damping_ratio"].value
    wanted = known["friction_peak"]
    few = {"friction_ratio": [0.0, 0.2, 0.4, ratio, 0.8]} if quick else {}
    cube = section.solve(solve, variant("figure-9", "", quick, **few))
    steady = cube["amplitude_ratio"].squeeze(drop=True).transpose("friction_ratio", "frequency_ratio")
    r, friction = steady["frequency_ratio"].values, steady["friction_ratio"].values
    row = steady.sel(friction_ratio=ratio, method="nearest").values
    cycles = cycles_to_reach(wanted.value, ratio, damping)
    seconds = cycles / known["natural_frequency_hz"].value
    finite = np.array([[after(cycles, g, damping, x) for x in r] for g in friction])
    point = {"friction_ratio": ratio, "frequency_ratio": 1.0}
    theirs = PaperNumber(known["friction_limit"].value, known["friction_limit"].place)
    above = min(g for g in FRICTION_RATIOS if g > theirs.value)
    section.rows = [
        Row(f"γ_F = {ratio:g}, peak", wanted, float(np.nanmax(row)), f"steady; at r = {r[int(np.nanargmax(row))]:g}",
            at(cube, "amplitude_error", **point)),
        Row(f"γ_F = {ratio:g}, r = 1, relative amplitude of x − z, over Z", None,
            at(cube, "relative_amplitude_ratio", **point), "steady", at(cube, "amplitude_error", **point)),
        Row(f"γ_F = {ratio:g}, peak", wanted, float(np.nanmax(finite[int(np.abs(friction - ratio).argmin())])),
            f"largest peak in {cycles} cycles from rest, {seconds:.3g} s at 2.5 Hz; at r = 1 the first cycle that reaches "
            f"{wanted.value:g} is cycle {cycles}"),
        Row("no damper, r = 1", None, at(cube, "amplitude_ratio", friction_ratio=0.0, frequency_ratio=1.0), "steady",
            at(cube, "amplitude_error", friction_ratio=0.0, frequency_ratio=1.0)),
        Row("no damper, r = 1", None, after(cycles, 0.0, damping, 1.0), f"largest peak in {cycles} cycles from rest"),
        Row("γ_F above which friction bounds the resonance", theirs, friction_limit(),
            f"zero of the straight line through the steady amplitudes at γ_F = 0.2 and 0.6; r = 1, ζ = {SMALL_DAMPING:g}"),
        Row(f"γ_F = {above:g}, r = 1", None, at(cube, "amplitude_ratio", friction_ratio=above, frequency_ratio=1.0),
            "steady; the paper says that (12) is infinite for any friction",
            at(cube, "amplitude_error", friction_ratio=above, frequency_ratio=1.0)),
    ]  # fmt: skip
    section.figures["figure-9.png"] = draw_finite_time(r, friction, steady.values, finite, cycles)
    section.verdict = (
        f"A start from rest reaches the peak of {wanted.value:g} within {seconds:.3g} s; the steady peak is "
        f"{section.rows[0].ours:.4g}."
    )
    section.words = [
        f"The paper's peak of about 20 is not the steady peak, which is {section.rows[0].ours:.4g}. From "
        f"rest, X/Z first reaches {wanted.value:g} in cycle {cycles}, after {seconds:.3g} s. The paper does not "
        "print the duration of its run.",
        "Equation (12) leaves out viscous damping. With damping the resonance is finite at any friction, and the amplitude "
        "relative to the base is close to (1 − 4γ_F/π)/(2ζ). If γ_F exceeds π/4, friction alone keeps the mass near its base.",
    ]
    return section


def figure_10(solve: Solve, quick: bool) -> Section:
    """Compare the friction ratios of the curves in Figure 10 with the law of the spring, F_N = k_s Δs."""
    section = Section("Figures 10 and 9 compared: friction ratio of a spring compression")
    known = paper_numbers()
    damping, ratio = known["damping_ratio"].value, known["friction_ratio"].value
    peaks = {"compared": known["friction_peak"], "hybrid": known["friction_alone"]}
    compression = {name: known[f"compression_{name}_mm"] for name in peaks}
    law = compression["hybrid"].value / compression["compared"].value
    cycles = cycles_to_reach(peaks["compared"].value, ratio, damping)
    readings: dict[str, Callable[[float], float]] = {
        "steady": lambda g: float(simulate(Design(damping, 1.0, g)).metrics["amplitude_ratio"]),
        f"largest peak in {cycles} cycles from rest": lambda g: after(cycles, g, damping, 1.0),
    }
    found: dict[str, dict[str, float]] = {}
    for reading, value in readings.items():
        found[reading] = {name: friction_for(peak.value, value) for name, peak in peaks.items()}
        section.rows += [
            Row(f"γ_F of Δs = {compression['compared'].value:g} mm", known["friction_ratio"],
                found[reading]["compared"], f"{reading}: gives X/Z = {peaks['compared'].value:g} at r = 1"),
            Row(f"γ_F of Δs = {compression['hybrid'].value:g} mm",
                PaperNumber(ratio * law, f"F_N = k_s Δs, Section 4.2, from γ_F = {ratio:g} at 3 mm"),
                found[reading]["hybrid"],
                f"{reading}: gives the X/Z = {peaks['hybrid'].value:g} of Table 3 at r = 1"),
            Row("ratio of the two friction forces", PaperNumber(law, "F_N = k_s Δs, Section 4.2"),
                found[reading]["hybrid"] / found[reading]["compared"], reading),
        ]  # fmt: skip
        section.rows.append(
            Row(f"X/Z at γ_F = {ratio * law:g}, the friction at 4 mm if it is {ratio:g} at 3 mm and proportional to the "
                "compression", known["friction_alone"],
                value(ratio * law), f"{reading}, r = 1"),
        )  # fmt: skip
    axis = np.linspace(0.0, 0.9, 10 if quick else 91)
    curves = {reading: [value(float(g)) for g in axis] for reading, value in readings.items()}
    levels = {f"Δs = {compression[name].value:g} mm": peak.value for name, peak in peaks.items()}
    section.figures["figure-10.png"] = draw_friction_law(axis, curves, levels)
    section.verdict = (
        "The spring's law and the measured peaks disagree. By the law, the friction at 4 mm is "
        f"{law:.3g} times that at 3 mm. By the peaks, the factor is "
        + " or ".join(f"{one['hybrid'] / one['compared']:.3g}" for one in found.values())
        + ", depending on whether they are steady."
    )
    section.words = [
        f"With F_N = k_s Δs the friction at 4 mm is {law:.4g} times that at 3 mm: γ_F = {ratio * law:g}, "
        "above π/4, where friction alone would almost prevent the resonance. The measured peaks require "
        + " or ".join(
            f"a factor of {one['hybrid'] / one['compared']:.3g} ({reading})" for reading, one in found.items()
        )
        + ". So the comparison of Figures 9 and 10, the spring's law and Table 3 contradict each other. One "
        "explanation would be a spring that was already compressed at its zero reading.",
    ]
    return section


def after(cycles: int, friction_ratio: float, damping: float, r: float) -> float:
    """Return the largest |x|/Z in a number of cycles from rest."""
    return float(simulate(Design(damping, r, friction_ratio), cycles=cycles).metrics["amplitude_ratio_max"])


def cycles_to_reach(peak: float, friction_ratio: float, damping: float) -> int:
    """Return the number of the first cycle from rest at r = 1 in which |x|/Z reaches `peak`.

    Raises
    ------
    ValueError
        If the steady response is below `peak`.
    """
    low, high = 0, LONGEST
    if after(high, friction_ratio, damping, 1.0) < peak:
        raise ValueError(f"X/Z = {peak:g} is never reached at friction ratio {friction_ratio:g}")
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if after(middle, friction_ratio, damping, 1.0) >= peak else (middle, high)
    return high


def friction_for(peak: float, value: Callable[[float], float]) -> float:
    """Find by bisection the friction ratio below π/4 at which `value`, a decreasing function, equals `peak`."""
    low, high = 0.0, math.pi / 4
    for _ in range(ROUNDS):
        middle = (low + high) / 2
        low, high = (middle, high) if value(middle) > peak else (low, middle)
    return (low + high) / 2


def friction_limit() -> float:
    """Return the friction ratio at which the steady relative amplitude at r = 1, extrapolated linearly, is zero."""
    first, second = (
        float(simulate(Design(SMALL_DAMPING, 1.0, g)).metrics["relative_amplitude_ratio"]) for g in (0.2, 0.6)
    )
    return 0.2 + 0.4 * first / (first - second)
