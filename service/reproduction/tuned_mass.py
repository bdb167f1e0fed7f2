"""Table 4 and Figure 14: the tuned mass damper, compared with the hybrid damper."""

import numpy as np

from damperlab.service.figures.reproduction import draw_beside_tuned_mass
from damperlab.service.reproduction.readings import INSTANT, SOFT
from damperlab.service.reproduction.section import Row, Section, Solve, at, variant
from damperlab.studies.answers.tmd_comparison import tmd_comparison
from damperlab.studies.faults import listing
from damperlab.studies.paper import paper_numbers
from damperlab.studies.questions import Tuning
from damperlab.studies.tmd.absorber import Absorber
from damperlab.studies.tmd.transfer import amplitude_ratio, highest, without_absorber
from damperlab.studies.tmd.tunings import tuned
from damperlab.studies.vocabulary import Criterion

SHOWN_FRICTION = (0.4, 0.6, 0.69, 0.8)
"""Friction ratios for the hybrid damper. The paper prints no friction ratio for the spring of Figure 14."""
ALIKE = 0.15
"""Largest relative difference at which two peaks count as similar."""


def table_4(solve: Solve, quick: bool) -> Section:
    """Compare the optimal tuning and damping with Table 4, for both definitions of the absorber's damping ratio."""
    section = Section("Table 4: optimal tuned mass damper")
    known = paper_numbers()
    mass = known["mass_ratio"].value
    right = tuned("den_hartog", mass)
    printed = known["absorber_damping"]
    mixed = Absorber(mass, right.tuning, printed.value)
    section.rows = [
        Row("γ_opt", known["absorber_tuning"], right.tuning, "(14), 1/(1 + μ)"),
        Row("ζ_opt", printed, right.damping_ratio, "(15) as printed, ζ = c/(2√(m k₁)) as (13) defines it"),
        Row("ζ_opt", printed, right.damping_over_structure,
            "the same dashpot, relative to the structure's frequency, c/(2 m ω_n)"),
        Row("peak of (13)", None, highest(right).value, f"ζ = {right.damping_ratio:.6g}, γ = {right.tuning:.6g}"),
        Row("peak of (13)", None, highest(mixed).value,
            f"the printed ζ put into (13) unconverted, γ from (14): a dashpot too weak by a factor of {1 + mass:g}"),
        Row("peak of (13)", None, highest(tuned("hinf", mass)).value,
            "exact optimum of an undamped structure, Nishihara and Asami (2002)"),
    ]  # fmt: skip
    damping = known["damping_ratio"].value
    least = tuned("minimax", mass, damping)
    section.rows.append(
        Row("peak with the structure's own damping", None, highest(least, damping).value,
            f"numerical minimax, ζ of the structure {damping:g}: γ = {least.tuning:.6g}, ζ = {least.damping_ratio:.6g}")
    )  # fmt: skip
    section.verdict = (
        f"The frequency is right. The damping {printed.value:g} is relative to the structure's frequency; "
        "by (15) "
        f"it is {right.damping_ratio:.4g}."
    )
    section.words = [
        "Table 4's 0.1679 differs from (15). The printed number is √(3μ/(8(1+μ)³)). It is the same optimum, "
        "written as c/(2 m ω_n), with the structure's natural frequency in place of the absorber's own. Both "
        "numbers describe the same dashpot. But the ζ of (13) refers to the absorber's own frequency, so the "
        "number of Table 4, put into (13), makes the dashpot too weak.",
    ]
    return section


def figure_14(solve: Solve, quick: bool) -> Section:
    """Compare the frequency response of the hybrid damper with that of the tuned mass damper of Table 4."""
    section = Section("Figure 14: hybrid and tuned mass damper")
    known = paper_numbers()
    mass, damping = known["mass_ratio"].value, known["damping_ratio"].value
    curves = {}
    ratios: dict[str, float] = {}
    for contact, model in SOFT.items():
        study = variant("figure-14", contact, quick, contact=model, friction_ratio=list(SHOWN_FRICTION))
        cube = section.solve(solve, study)
        for g in SHOWN_FRICTION:
            answer = tmd_comparison(cube, Tuning(criterion="den_hartog_table4"), at={"friction_ratio": g})
            said = answer.attrs
            if not section.rows:
                section.rows.append(
                    Row("peak of the tuned mass damper", None, said["tmd_peak"],
                        f"Table 4's ζ in (13), with the structure's ζ = {damping:g}, at r = {said['tmd_peak_at']:.4g}")
                )  # fmt: skip
            at_resonance = at(cube, "amplitude_ratio", friction_ratio=g, frequency_ratio=1.0)
            section.rows.append(
                Row(f"peak of the hybrid, γ_F = {g:g}", None, said["hybrid_peak"],
                    f"{said['ratio']:.3g} times the tuned mass damper's peak; the peak is at r = "
                    f"{said['hybrid_peak_at']:.4g}; smaller X/Z than with the tuned mass damper at "
                    f"{said['hybrid_better_share']:.0%} of the frequencies; X/Z = {at_resonance:.3g} at r = 1",
                    said["hybrid_peak_error"], contact)
            )  # fmt: skip
            if contact == INSTANT:
                ratios[f"{g:g}"] = said["ratio"]
                curves[f"hybrid, $γ_F$ = {g:g}"] = (answer["frequency_ratio"].values, answer["hybrid"].values)
    lam = np.linspace(0.5, 1.5, 1001)
    absorbers: dict[str, Criterion] = {
        "TMD, $ζ$ of Table 4 in (13)": "den_hartog_table4",
        "TMD, (14) and (15)": "den_hartog",
    }
    beside = {
        name: amplitude_ratio(lam, tuned(criterion, mass), damping) for name, criterion in absorbers.items()
    }
    section.figures["figure-14.png"] = draw_beside_tuned_mass(lam, beside, without_absorber(lam, damping), curves)  # fmt: skip
    alike = [g for g, ratio in ratios.items() if abs(ratio - 1) <= ALIKE]
    lowest = min(ratios, key=ratios.__getitem__)
    section.verdict = (
        f"The paper prints no number. With the contact model {INSTANT}, the hybrid's peak is within {ALIKE:.0%} of the "
        f"tuned mass damper's at {f'γ_F = {listing(alike)}' if alike else 'no friction ratio'}. The hybrid's lowest peak, at "
        f"γ_F = {lowest}, is {ratios[lowest]:.3g} times the tuned mass damper's."
    )
    section.words = [
        "The paper prints no number of its Figure 14; it says that the tuned mass damper has the smaller "
        "peak at resonance, and that the hybrid works over a wider band. "
        + (
            f"With the contact model {INSTANT}, our hybrid's peak is within {ALIKE:.0%} of the tuned mass damper's "
            f"at γ_F = {listing(alike)}."
            if alike
            else f"Our hybrid's peak is at no friction ratio within {ALIKE:.0%} of the tuned mass damper's."
        ),
    ]
    return section
