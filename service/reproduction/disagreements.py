"""Contradictions within the paper, found by computing some of its printed numbers from others."""

from damperlab.service.reproduction.section import Row, Section, Solve
from damperlab.studies.paper import paper_numbers
from damperlab.studies.presets import SLOW_MOTION
from damperlab.studies.tmd.tunings import den_hartog


def disagreements(solve: Solve, quick: bool) -> Section:
    """Compare printed numbers of the paper with values that follow from other printed numbers."""
    section = Section("The paper compared with itself")
    known = paper_numbers()
    value = {name: number.value for name, number in known.items()}
    hybrid = [value[f"hybrid_{k}"] for k in (1, 2, 3)]
    particle = [value[f"particle_{k}"] for k in (1, 2, 3)]
    section.rows = [
        Row("relative reduction of X/Z, best hybrid against friction alone", known["less_than_friction"],
            1 - min(hybrid) / value["friction_alone"], "from Table 3: agrees"),
        Row("relative reduction of X/Z, best hybrid against best particle alone", known["less_than_particle"],
            1 - min(hybrid) / min(particle),
            "from Table 3, the best hybrid (7.5 mm) against the best particle (22.5 mm): agrees"),
        *(
            Row(f"the same at one clearance, {value[f'clearance_{k}_mm']:g} mm", known["less_than_particle"],
                1 - hybrid[k - 1] / particle[k - 1], "from Table 3")
            for k in (1, 2, 3)
        ),
        *(
            Row(f"base amplitude Z [mm] for d = {value[f'clearance_{k}_mm']:g} mm", None,
                value[f"clearance_{k}_mm"] / value[f"clearance_ratio_{k}"],
                f"from its label d/Z = {value[f'clearance_ratio_{k}']:g}; the three labels imply different amplitudes")
            for k in (1, 2, 3)
        ),
        Row("third clearance, mm", known["clearance_3_text_mm"], value["clearance_3_mm"],
            "caption of Figure 7; the text has another value"),
        Row("clearance best for the particle alone, mm", known["clearance_3_mm"],
            value[f"clearance_{1 + particle.index(min(particle))}_mm"],
            "lowest of Table 3; the text of Figure 7 has another value"),
        Row("contact time of the foam divided by the period", None,
            value["contact_time_soft_s"] * value["natural_frequency_hz"],
            "from Tables 1 and 2: longer than a whole cycle, and two impacts a cycle are common"),
        Row("the same, if read off slow motion", None,
            value["contact_time_soft_s"] * value["natural_frequency_hz"] / SLOW_MOTION,
            f"if the film ran {SLOW_MOTION:g} times slower than real time"),
        Row("ζ_opt", known["absorber_damping"], den_hartog(value["mass_ratio"]).damping_ratio,
            "(15) with the μ of Table 4; see Table 4"),
        Row("relative reduction of the peak in the earthquake, hybrid against tuned mass damper",
            known["earthquake_less_than_tmd"],
            1 - value["earthquake_peak_hybrid_m"] / value["earthquake_peak_tmd_m"], "from Table A1: agrees"),
    ]  # fmt: skip
    section.verdict = (
        "Some numbers of the paper contradict each other, among them the clearances and the contact time of "
        "the foam."
    )
    section.words = [
        "In this section *Paper* is a printed number, and *This run* is what follows from other printed "
        "numbers.",
        "The text also contradicts itself. The text says that (12) is infinite at resonance \"with any magnitude "
        "of the friction "
        "force\". The text also says that 0.6 is \"quite close to the theoretical limit of π/4\"; beyond that "
        "limit (12) is finite. "
        "Equation (1) is unforced as printed. Momentum is conserved, according to the text, in elastic "
        "impacts only.",
    ]  # fmt: skip
    return section
