"""Fit the unknown parameters of the prototype, with friction of the particle, to the peaks printed in Table 3."""

from dataclasses import replace

from damperlab.service.figures.reproduction import draw_numbers
from damperlab.service.reproduction.prototype import (
    ASSUMED,
    BAND,
    CASES,
    CAVITIES,
    CONFIDENCE,
    RANGES,
    WORDS,
    Prototype,
    deviation_of,
    fitted,
    fitted_from_anywhere,
    intervals,
    peaks_of,
)
from damperlab.service.reproduction.readings import INSTANT, PRINTED, REAL
from damperlab.service.reproduction.section import Row, Section, Solve
from damperlab.studies.answers.tmd_comparison import tmd_comparison
from damperlab.studies.definition import Study, parse_harmonic
from damperlab.studies.paper import PaperNumber, paper_numbers
from damperlab.studies.questions import Tuning

PROFILE = (0.02, 0.05, 0.08, 0.1, 0.12, 0.15, 0.2)
"""Values of μ_i, for each of which a search finds the best Z and ζ."""
MIDDLE = Prototype(0.0015, 0.008, 0.0)
"""Initial prototype of a search. The search replaces Z and ζ by values of a coarse grid."""
FREE = (*ASSUMED, "particle_friction")
WITHOUT, WITH = "without friction of the particle", "with friction of the particle"
FIGURES = {"particle": 7, "hybrid": 12}
"""Figure of the paper that shows the curves of each damper."""


def table_3_rubbing(solve: Solve, quick: bool) -> Section:
    """Fit the prototype to Table 3, with and without friction of the particle, and compare the fit with the figures."""
    section = Section("Table 3 with the particle's own friction")
    frictions = PROFILE[-1:] if quick else PROFILE
    profile = {mu: fitted_from_anywhere(replace(MIDDLE, particle_friction=mu), quick) for mu in frictions}
    nearest = min(profile.values(), key=deviation_of)
    best = fitted(nearest, FREE, quick)
    without = fitted_from_anywhere(MIDDLE, quick)
    held = [fitted_from_anywhere(replace(MIDDLE, contact=name), quick) for name in (REAL, PRINTED)]
    section.rows, found = _peaks(section, solve, {WITHOUT: without, WITH: best})
    section.rows += _figures(section, solve, best, found[WITH])
    section.tables = [
        _fits(
            {
                WITHOUT: without,
                "the same, particle held 20.55 ms": held[0],
                "the same, particle held 0.411 s": held[1],
                WITH: best,
                "the same, e fitted as well": fitted(best, (*FREE, "restitution"), quick),
            }
        ),
        (
            ("μ_i", "Z [mm]", "ζ", "rms deviation"),
            [(f"{mu:g}", *_spelled(each), f"{deviation_of(each):.1%}") for mu, each in profile.items()],
        ),
    ]
    known = paper_numbers()
    names = ["friction\nalone", *(f"{kind}\n{known[f'clearance_{k}_mm'].value:g} mm" for kind, k in CASES)]
    measured = [known["friction_alone"].value, *(known[f"{kind}_{k}"].value for kind, k in CASES)]
    section.figures["table-3-friction.png"] = draw_numbers(
        names, measured, {name: list(peaks.values()) for name, peaks in found.items()}
    )
    section.verdict = (
        f"The best fit deviates by {deviation_of(best):.1%} (rms), with μ_i = {best.particle_friction:.2g} and Z = "
        f"{1e3 * best.base_amplitude_m:.3g} mm, "
        f"at {best.damping_ratio / known['damping_ratio'].value:.2g} times the measured ζ; without μ_i it deviates by "
        f"{deviation_of(without):.0%}."
    )
    section.words = _words(best, found[WITH], intervals(best, FREE))
    return section


def _friction_alone(prototype: Prototype) -> Study:
    document = prototype.study().document()
    axes = {name: document["axes"][name] for name in ("friction_ratio", "frequency_ratio")}
    return parse_harmonic(
        {
            "name": "table-3, friction alone",
            "damping_ratio": prototype.damping_ratio,
            "particle": False,
            "axes": {**axes, "friction_ratio": prototype.friction_ratio},
            "metrics": ["amplitude_ratio"],
        }
    )


def _peaks(
    section: Section, solve: Solve, fits: dict[str, Prototype]
) -> tuple[list[Row], dict[str, dict[str, float]]]:
    """Compare the seven peaks of each fitted prototype with the numbers of Table 3."""
    known = paper_numbers()
    rows, found = [], {}
    for name, prototype in fits.items():
        alone = section.solve(solve, _friction_alone(prototype))["amplitude_ratio"]
        six = peaks_of(section.solve(solve, prototype.study())["amplitude_ratio"])
        found[name] = {"friction_alone": float(alone.max()), **six}
        quantities = [
            "friction alone",
            *(f"{WORDS[kind]}, d = {known[f'clearance_{k}_mm'].value:g} mm" for kind, k in CASES),
        ]
        rows += [
            Row(quantity, known[number], value, f"peak of the curve, {name}", None, INSTANT)
            for quantity, (number, value) in zip(quantities, found[name].items(), strict=True)
        ]
    return rows, found


def _figures(section: Section, solve: Solve, best: Prototype, peaks: dict[str, float]) -> list[Row]:
    """Compare the fitted prototype with the paper's other statements."""
    known = paper_numbers()
    lengths = {k: known[f"clearance_{k}_mm"].value for k in CAVITIES}
    hard = replace(best, restitution=known["restitution_hard"].value)
    harder = peaks_of(section.solve(solve, hard.study())["amplitude_ratio"])
    shortest = {
        kind: Row(
            f"clearance best for the {words}, mm",
            PaperNumber(lengths[min(CAVITIES, key=lambda k: known[f"{kind}_{k}"].value)], "Table 3"),
            lengths[min(CAVITIES, key=lambda k: peaks[f"{kind}_{k}"])],
            f"the lowest peak; Figure {FIGURES[kind]}",
            None,
            INSTANT,
        )
        for kind, words in WORDS.items()
    }
    by_spring = PaperNumber(4.0 / 3.0, "F_N = k_s Δs, Section 4.2")
    at_3_mm = best.friction_of(known["friction_peak"].value)
    cavity = lengths[1] * 1e-3 / best.base_amplitude_m
    beside = tmd_comparison(
        section.solve(solve, best.study()),
        Tuning(criterion="den_hartog_table4"),
        {"clearance_ratio": cavity, "friction_ratio": best.friction_ratio},
    ).attrs
    return [
        *shortest.values(),
        *(
            Row(
                f"particle alone, d = {length:g} mm, ratio of the peak at e = {hard.restitution:g} to "
                f"that at e = {best.restitution:g}",
                None,
                harder[f"particle_{k}"] / peaks[f"particle_{k}"],
                "Figure 8; the paper says that the harder wall is worse",
                None,
                INSTANT,
            )
            for k, length in lengths.items()
        ),
        Row(
            "ratio of the friction forces at spring compressions of 4 and 3 mm",
            by_spring,
            best.friction_ratio / at_3_mm,
            "Figure 10; each force from its measured peak, (1 − 4γ_F/π)/(2ζ)",
        ),
        Row(
            f"ratio of the hybrid's peak to the tuned mass damper's, d = {lengths[1]:g} mm",
            None,
            beside["ratio"],
            f"Figure 14, r = {BAND['start']:g} to {BAND['stop']:g}, (13) with the ζ of Table 4; the hybrid is lower at "
            f"{beside['hybrid_better_share']:.0%} of the frequencies",
            None,
            INSTANT,
        ),
    ]


def _spelled(fit: Prototype) -> tuple[str, str]:
    return f"{1e3 * fit.base_amplitude_m:.3g}", f"{fit.damping_ratio:.3g}"


def _fits(fits: dict[str, Prototype]) -> tuple[tuple[str, ...], list[tuple[object, ...]]]:
    lines = [
        (name, *_spelled(fit), f"{fit.particle_friction:.3g}", f"{fit.restitution:.3g}", f"{fit.friction_ratio:.3g}",
         f"{deviation_of(fit):.1%}")
        for name, fit in fits.items()
    ]  # fmt: skip
    return ("fit", "Z [mm]", "ζ", "μ_i", "e", "γ_F", "rms deviation"), list(lines)


def _words(best: Prototype, peaks: dict[str, float], within: dict[str, tuple[float, float]]) -> list[str]:
    """Describe the reading of Table 3, the findings, and open points."""
    known = paper_numbers()
    (z, zeta, mu), factor = (within[name] for name in FREE), 1e3
    ranges = {name: RANGES[name] for name in FREE}
    return [
        "The paper lists μ_i, internal friction, among its symbols, and its particle slides on a rail. Here the numbers of "
        "Table 3 are read as peaks of the curves, at one base amplitude Z for all cavities. The restitution "
        "e is the measured one, and γ_F is chosen so that friction alone has the printed peak "
        f"({known['friction_alone'].value:g}). Z, ζ and μ_i are fitted to the six numbers with a particle. "
        f"The search covers Z from {factor * ranges['base_amplitude_m'][0]:g} to "
        f"{factor * ranges['base_amplitude_m'][1]:g} mm, ζ from {ranges['damping_ratio'][0]:g} to "
        f"{ranges['damping_ratio'][1]:g} and μ_i up to {ranges['particle_friction'][1]:g}. The deviation is "
        "the root mean square of ln(our value / the paper's value).",
        f"The {CONFIDENCE:.0%} intervals of the fit with friction of the particle are {factor * z[0]:.3g} to "
        f"{factor * z[1]:.3g} mm for Z, {zeta[0]:.3g} to {zeta[1]:.3g} for ζ and {mu[0]:.3f} to {mu[1]:.3f} for μ_i. "
        "The last table lists the best Z and ζ for given values of μ_i.",
        f"The peaks of the hybrid in the two longer cavities are printed as {known['hybrid_2'].value:g} and "
        f"{known['hybrid_3'].value:g}, almost equal. With friction of the particle the two peaks are "
        f"{peaks['hybrid_2']:.3g} and {peaks['hybrid_3']:.3g}. Equal numbers mean that the particle reaches "
        "no wall and damps by its friction alone.",
        f"The fitted ζ is {best.damping_ratio / known['damping_ratio'].value:.2g} times the measured "
        f"{known['damping_ratio'].value:g}. The measured ζ belongs to the structure without a damper. The paper does "
        "not say what adds damping on the prototype.",
    ]
