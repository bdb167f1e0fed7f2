"""Figures 7 and 8: the particle impact damper alone."""

from typing import Any

import numpy as np

from damperlab.service.figures.reproduction import draw_histories, draw_responses
from damperlab.service.reproduction.readings import (
    HARD,
    INSTANT,
    PRINTED,
    SOFT,
    clearances,
    contacts_in_words,
)
from damperlab.service.reproduction.section import Row, Section, Solve, at, variant
from damperlab.studies.answers.frequency_response import frequency_response
from damperlab.studies.faults import counted, listing
from damperlab.studies.paper import paper_numbers
from damperlab.studies.questions import Selection
from damperlab.studies.tmd.transfer import without_absorber
from damperlab.worker.point import Design
from damperlab.worker.simulate import simulate
from damperlab.worker.solver.particle import Particle

CAVITIES = (1, 2, 3)
SHOWN_CYCLES = 60


def figure_7(solve: Solve, quick: bool) -> Section:
    """Compute the frequency response with the particle alone, for three clearances and each contact model."""
    section = Section("Figure 7: frequency response, particle alone")
    known = paper_numbers()
    wanted = tuple(known[f"clearance_ratio_{k}"].value for k in CAVITIES)
    panels: list[dict[str, Any]] = [{"title": f"$d/Z$ = {ratio:g}", "curves": {}} for ratio in wanted]
    peaks: dict[str, list[float]] = {}
    for contact, model in SOFT.items():
        cube = section.solve(solve, variant("figure-7", contact, quick, contact=model))
        peaks[contact] = []
        for k, ratio, panel in zip(CAVITIES, wanted, panels, strict=True):
            curve = frequency_response(cube, Selection(at={"clearance_ratio": ratio, "friction_ratio": 0.0}))
            values, error = curve["amplitude_ratio"].values, curve["amplitude_error"].values
            place = int(np.nanargmax(values))
            peaks[contact].append(float(values[place]))
            r = curve["frequency_ratio"].values
            panel["curves"][contact] = (r, values, error)
            panel["level"] = known[f"particle_{k}"].value
            length = known[f"clearance_{k}_mm"].value
            where = f"the largest over r = {r[0]:g} to {r[-1]:g}, at r = {r[place]:g}; d/Z = {ratio:g} as labelled"
            section.rows += [
                Row(f"d = {length:g} mm, peak of the curve", known[f"particle_{k}"], float(values[place]), where,
                    float(error[place]), contact),
                Row(f"d = {length:g} mm, at r = 1", known[f"particle_{k}"],
                    at(cube, "amplitude_ratio", clearance_ratio=ratio, friction_ratio=0.0, frequency_ratio=1.0),
                    "mean of the cycles' peaks; the same d/Z",
                    at(cube, "amplitude_error", clearance_ratio=ratio, friction_ratio=0.0, frequency_ratio=1.0),
                    contact),
            ]  # fmt: skip
    best = {name: known[f"clearance_{1 + int(np.argmin(found))}_mm"].value for name, found in peaks.items()}
    damping = known["damping_ratio"].value
    bare = float(without_absorber(1.0, damping))
    section.figures["figure-7.png"] = draw_responses(panels)
    section.verdict = (
        "The labels d/Z do not explain the measured peaks. Without a contact time the best clearance is "
        f"{best[INSTANT]:g} mm; in the paper it is 37.5 mm by the text and 22.5 mm by Table 3."
    )
    section.words = [
        contacts_in_words(),
        "Our values are compared with the measured ones of Table 3 for the particle alone; the paper prints "
        "no values of the curves. A particle in a short cavity stays at its wall and moves the resonance to about "
        "r = 1/√(1 + β) = 0.953. So the peak of the curve differs from the value at r = 1.",
        "The clearance with the lowest peak: "
        + "; ".join(f"{length:g} mm ({name})" for name, length in best.items())
        + ". The text says 37.5 mm, Table 3 says 22.5 mm.",
        f"A particle that is held for the printed {known['contact_time_soft_s'].value:g} s, longer than a "
        "period, acts as added mass: the peaks are then "
        + listing(f"{peak:.3g}" for peak in peaks[PRINTED])
        + f", against {bare:.4g} without a damper. No value in the paper comes near these peaks, so its "
        "simulations can hardly have used such a long contact.",
    ]
    return section


def figure_8(solve: Solve, quick: bool) -> Section:
    """Compute the response at resonance with the particle alone, for both walls and three clearances."""
    section = Section("Figure 8: soft and hard walls, particle alone, at resonance")
    known = paper_numbers()
    soft, hard = known["restitution_soft"].value, known["restitution_hard"].value
    labels = next(iter(clearances().values()))
    worse = 0
    for contact in SOFT:
        models = {soft: SOFT[contact], hard: HARD[contact]}
        cubes = {
            e: section.solve(solve, variant("figure-8", f"e = {e:g}, {contact}", quick, restitution=e, contact=model))
            for e, model in models.items()
        }  # fmt: skip
        for k, ratio in zip(CAVITIES, labels, strict=True):
            length = known[f"clearance_{k}_mm"].value
            found = {e: at(cube, "amplitude_ratio", clearance_ratio=ratio) for e, cube in cubes.items()}
            worse += found[hard] > found[soft]
            for e, cube in cubes.items():
                error = at(cube, "amplitude_error", clearance_ratio=ratio)
                section.rows.append(
                    Row(f"d = {length:g} mm, e = {e:g}", None, found[e], f"d/Z = {ratio:g} as labelled, r = 1",
                        error, contact)
                )  # fmt: skip
    histories = {
        (ratio, e): simulate(
            Design(known["damping_ratio"].value, 1.0, 0.0, Particle(ratio, e, known["mass_ratio"].value)),
            cycles=SHOWN_CYCLES,
            history=SHOWN_CYCLES,
        ).history
        for ratio in labels
        for e in (soft, hard)
    }
    section.figures["figure-8.png"] = draw_histories(histories)
    section.verdict = (
        f"The paper says that a harder wall is worse; this holds in {worse} of "
        f"{counted(3 * len(SOFT), 'pair')} of clearance and contact model."
    )
    section.words = [
        "The paper says that a higher restitution degrades the damper; it prints no number. In "
        f"{worse} of {counted(3 * len(SOFT), 'pair')} of a clearance and a contact model the harder wall is "
        "worse. So the better wall depends on the clearance too, not on the restitution alone.",
        f"The figure shows {SHOWN_CYCLES} cycles from rest with the contact model {INSTANT}.",
    ]
    return section
