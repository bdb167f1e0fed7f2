"""Figures 11 and 12, and Table 3: the hybrid damper, compared with the particle alone and friction alone."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from damperlab.service.figures.reproduction import draw_responses
from damperlab.service.figures.resonance_map import draw_map
from damperlab.service.reproduction.readings import (
    CHOSEN_FRICTION,
    FRICTION_RATIOS,
    INSTANT,
    LABELS,
    SOFT,
    clearances,
)
from damperlab.service.reproduction.section import Row, Section, Solve, at, variant
from damperlab.studies.answers.frequency_response import frequency_response
from damperlab.studies.answers.optimal_designs import optimal_designs
from damperlab.studies.answers.resonance_map import resonance_map
from damperlab.studies.faults import listing
from damperlab.studies.paper import paper_numbers
from damperlab.studies.questions import Judging, Selection

SHOWN_READINGS = 8
BAND = {"start": 0.85, "stop": 1.15, "num": 61}
MEASURES = {
    "at r = 1, mean of the largest |x|/Z of each cycle": ("amplitude_ratio", False),
    "at r = 1, largest |x|/Z of all cycles": ("amplitude_ratio_max", False),
    "largest over r = 0.85 to 1.15, mean of the largest |x|/Z of each cycle": ("amplitude_ratio", True),
    "largest over r = 0.85 to 1.15, largest |x|/Z of all cycles": ("amplitude_ratio_max", True),
}
"""Possible meanings of "maximum vibration amplitude at resonance": a variable, and whether to take its largest value over
the band.
"""


@dataclass(frozen=True)
class Reading:
    """A reading (interpretation) of Table 3, with the resulting values."""

    base_amplitude: str
    contact: str
    friction_ratio: float
    measure: str
    particle: tuple[float, ...]
    hybrid: tuple[float, ...]
    factor: float  # exp of the root mean square of ln(our value / the paper's value)


def figure_11(solve: Solve, quick: bool) -> Section:
    """Map the amplitude at r = 1, as in the paper, and the largest amplitude over the band."""
    section = Section("Figure 11: hybrid damper over clearance and friction")
    resonance = section.solve(solve, variant("figure-11", "", quick))
    band = section.solve(solve, variant("figure-11-band", "", quick))
    known = paper_numbers()
    labelled = known["clearance_ratio_1"].value
    judged = {
        "figure-11.png": (resonance, "X/Z at r = 1"),
        "figure-11-band.png": (band, "largest X/Z over r = 0.8 to 1.25"),
    }
    for name, (cube, where) in judged.items():
        answer = resonance_map(cube, "clearance_ratio", "friction_ratio")
        section.figures[name] = draw_map(answer, "amplitude_ratio")
        best = optimal_designs(cube, Judging(exclude_locked=True), top=1)
        below = optimal_designs(
            cube, Judging(exclude_locked=True, ranges={"friction_ratio": (0.0, math.pi / 4)}), top=1
        )
        for found, what in ((best, "best design"), (below, "best design with γ_F below π/4")):
            design = found.isel(rank=0)
            section.rows.append(
                Row(f"{what}, {where}", None, float(design["value"]),
                    f"at d/Z = {float(design['clearance_ratio']):g}, γ_F = {float(design['friction_ratio']):.4g}; "
                    "without designs that friction locks to the base", float(design["error"]), INSTANT)
            )  # fmt: skip
        line = answer.sel(clearance_ratio=labelled, method="nearest")
        column = line["amplitude_ratio"].where(line["friction_ratio"] < math.pi / 4)
        place = int(np.nanargmin(column.values))
        section.rows.append(
            Row(f"best design at d/Z = {float(line['clearance_ratio']):g} with γ_F below π/4, {where}",
                known["hybrid_1"], float(column[place]),
                f"at γ_F = {float(column['friction_ratio'][place]):.4g}; the paper's value is measured",
                float(line["amplitude_error"][place]), INSTANT)
        )  # fmt: skip
    section.verdict = (
        "The paper draws its contours at r = 1 and prints none of their values. The best designs over "
        "r = 0.8 to 1.25 differ from those at r = 1."
    )
    section.words = [
        "The paper draws its contours only at resonance and prints none of their values; our values are "
        "compared with the lowest value of Table 3. Designs that look superb at r = 1 are poor over "
        "r = 0.8 to 1.25: a particle that stays at its wall moves the resonance to about r = 0.953. Compare "
        "the two maps.",
    ]
    return section


def figure_12(solve: Solve, quick: bool) -> Section:
    """Compute the frequency response of the hybrid damper for the three cavities and each possible friction ratio."""
    section = Section("Figure 12: frequency response, hybrid damper")
    known = paper_numbers()
    cubes = _cavities(section, solve, quick)
    panels = []
    for k, ratio in zip((1, 2, 3), clearances()[LABELS], strict=True):
        panel: dict[str, Any] = {
            "title": f"$d/Z$ = {ratio:g}",
            "curves": {},
            "level": known[f"hybrid_{k}"].value,
        }
        length = known[f"clearance_{k}_mm"].value
        for contact, cube in cubes.items():
            for g in FRICTION_RATIOS:
                curve = frequency_response(
                    cube, Selection(at={"clearance_ratio": ratio, "friction_ratio": g})
                )
                r, values = curve["frequency_ratio"].values, curve["amplitude_ratio"].values
                error, place = curve["amplitude_error"].values, int(np.nanargmax(values))
                if contact == INSTANT:
                    panel["curves"][f"$γ_F$ = {g:g}"] = (r, values, error)
                section.rows.append(
                    Row(f"d = {length:g} mm, γ_F = {g:g}, peak of the curve", known[f"hybrid_{k}"], float(values[place]),
                        f"largest over r = {r[0]:g} to {r[-1]:g}, at r = {r[place]:g}; d/Z = {ratio:g} as labelled",
                        float(error[place]), contact)
                )  # fmt: skip
        panels.append(panel)
    section.figures["figure-12.png"] = draw_responses(panels)
    section.verdict = (
        "The paper prints neither values of its curves nor their friction; our peaks are compared with the "
        "hybrid's entries of Table 3."
    )
    section.words = [
        "The paper draws measured curves for several compressions of the friction spring and prints none of "
        "their values. Our peak is compared with the hybrid's entry in Table 3 for the same cavity. The "
        f"friction ratio of a compression is not printed either, so {listing(f'{g:g}' for g in FRICTION_RATIOS)} "
        f"are shown. The figure is for the contact model {INSTANT}; the shading shows ± one error.",
    ]
    return section


def _cavities(section: Section, solve: Solve, quick: bool) -> dict[str, xr.Dataset]:
    """Compute the responses over a band for every reading of Table 3; return a cube per contact model."""
    axes = {
        "clearance_ratio": sorted({ratio for reading in clearances().values() for ratio in reading}),
        "friction_ratio": [0.0, *FRICTION_RATIOS],
        "mass_ratio": paper_numbers()["mass_ratio"].value,
    }
    frequencies: object = [0.9, 0.95, 1.0, 1.05] if quick else BAND
    return {
        contact: section.solve(
            solve, variant("table-3", contact, quick, contact=model, frequency_ratio=frequencies, **axes)
        )
        for contact, model in SOFT.items()
    }


def table_3(solve: Solve, quick: bool) -> Section:
    """Compare seven entries of Table 3, and two derived reductions, with computed values under every reading."""
    section = Section("Table 3: particle, friction, and both")
    known = paper_numbers()
    cubes = _cavities(section, solve, quick)
    alone = section.solve(
        solve, variant("figure-9", "friction of table-3", quick, friction_ratio=list(FRICTION_RATIOS),
                       frequency_ratio=1.0)
    )  # fmt: skip
    for g in FRICTION_RATIOS:
        section.rows.append(
            Row("friction alone", known["friction_alone"], at(alone, "amplitude_ratio", friction_ratio=g),
                f"γ_F = {g:g}, r = 1", at(alone, "amplitude_error", friction_ratio=g))
        )  # fmt: skip
    for k, ratio in zip((1, 2, 3), clearances()[LABELS], strict=True):
        for kind, g in (("particle", 0.0), ("hybrid", CHOSEN_FRICTION)):
            for contact, cube in cubes.items():
                point = {"clearance_ratio": ratio, "friction_ratio": g, "frequency_ratio": 1.0}
                with_friction = f", γ_F = {g:g}" if g else ""
                section.rows.append(
                    Row(f"{'hybrid' if g else 'particle alone'}, d = {known[f'clearance_{k}_mm'].value:g} mm",
                        known[f"{kind}_{k}"], at(cube, "amplitude_ratio", **point),
                        f"d/Z = {ratio:g} as labelled{with_friction}, r = 1", at(cube, "amplitude_error", **point), contact)
                )  # fmt: skip
    section.rows += _by_the_papers_method(section, solve, quick)
    readings = sorted(every_reading(cubes), key=lambda reading: reading.factor)
    default = next(
        reading
        for reading in readings
        if (reading.base_amplitude, reading.contact, reading.friction_ratio, reading.measure)
        == (LABELS, INSTANT, CHOSEN_FRICTION, next(iter(MEASURES)))
    )
    friction = at(alone, "amplitude_ratio", friction_ratio=CHOSEN_FRICTION)
    for which, reading in (("default interpretation", default), ("closest interpretation", readings[0])):
        assumed = f"{which}: {reading.base_amplitude}, γ_F = {reading.friction_ratio:g}, {reading.measure}"
        section.rows += [
            Row("relative reduction of X/Z, best hybrid against friction alone", known["less_than_friction"],
                1 - min(reading.hybrid) / friction, assumed, None, reading.contact),
            Row("relative reduction of X/Z, best hybrid against best particle alone", known["less_than_particle"],
                1 - min(reading.hybrid) / min(reading.particle), assumed, None, reading.contact),
        ]  # fmt: skip
    head = (
        "Base amplitude assumed", "Contact model", "γ_F", "Definition of X/Z", "X/Z of the particle alone",
        "X/Z of the hybrid", "Factor between our values and the paper's",
    )  # fmt: skip
    shown = [*readings[:SHOWN_READINGS], *([] if default in readings[:SHOWN_READINGS] else [default])]
    section.tables = [(head, [_cells(reading) for reading in shown])]
    printed = {
        kind: ", ".join(f"{known[f'{kind}_{k}'].value:g}" for k in (1, 2, 3))
        for kind in ("particle", "hybrid")
    }
    ahead = readings.index(default) + 1
    section.verdict = (
        f"Without friction of the particle, none of {len(readings)} interpretations explains the table; the "
        f"nearest is off by a factor of {readings[0].factor:.3g}."
    )
    section.words = [
        "The paper leaves open the contact, the friction ratio of the 4 mm compression, and the base amplitude Z. The labels "
        "d/Z = 5, 10 and 15 for d = 7.5, 22.5 and 37.5 mm imply three different amplitudes Z. The paper also leaves open "
        "whether \"at resonance\" means r = 1 or the peak of the curve. If a response does not repeat, \"amplitude\" may mean "
        "its usual or its largest peak.",
        f"All {len(readings)} combinations were computed. The second table lists the {SHOWN_READINGS} "
        f"nearest to the paper's six numbers with a particle (alone: {printed['particle']}; hybrid: "
        f"{printed['hybrid']}). It also lists the default ({LABELS}, instant, γ_F = {CHOSEN_FRICTION:g}, "
        f"r = 1, mean), which comes {ahead}th. The factor in the last column is exp of the root mean square "
        "of ln(our value / the paper's value). The nearest combination has the factor "
        f"{readings[0].factor:.3g}. The paper's numbers are measured on a prototype.",
    ]  # fmt: skip
    return section


def _by_the_papers_method(section: Section, solve: Solve, quick: bool) -> list[Row]:
    """Compute the entries with a particle by the paper's Runge-Kutta method, with impacts only at step ends."""
    known = paper_numbers()
    steps = round(1 / (known["natural_frequency_hz"].value * known["time_step_s"].value))
    labels = clearances()[LABELS]
    study = variant(
        "table-3",
        "Runge-Kutta",
        quick,
        metrics=["amplitude_ratio", "amplitude_error"],
        solver={"method": "rk4", "steps_per_cycle": steps},
        clearance_ratio=list(labels),
        friction_ratio=[0.0, CHOSEN_FRICTION],
        mass_ratio=known["mass_ratio"].value,
        frequency_ratio=1.0,
    )
    cube = section.solve(solve, study)
    rows = []
    for k, ratio in zip((1, 2, 3), labels, strict=True):
        for kind, g in (("particle", 0.0), ("hybrid", CHOSEN_FRICTION)):
            point = {"clearance_ratio": ratio, "friction_ratio": g}
            with_friction = f", γ_F = {g:g}" if g else ""
            rows.append(
                Row(f"{'hybrid' if g else 'particle alone'}, d = {known[f'clearance_{k}_mm'].value:g} mm",
                    known[f"{kind}_{k}"], at(cube, "amplitude_ratio", **point),
                    f"the paper's method, Runge-Kutta with {steps} steps a cycle; d/Z = {ratio:g} as "
                    f"labelled{with_friction}, r = 1", at(cube, "amplitude_error", **point), INSTANT)
            )  # fmt: skip
    return rows


def every_reading(cubes: dict[str, xr.Dataset]) -> list[Reading]:
    """Evaluate Table 3 for every combination of contact model, measure, base amplitude and friction ratio."""
    known = paper_numbers()
    paper = np.array([known[f"{kind}_{k}"].value for kind in ("particle", "hybrid") for k in (1, 2, 3)])
    found = []
    for contact, cube in cubes.items():
        for measure, (variable, over_band) in MEASURES.items():
            values = cube[variable]
            values = (
                values.max("frequency_ratio")
                if over_band
                else values.sel(frequency_ratio=1.0, method="nearest")
            )
            values = values.squeeze(drop=True)
            for name, ratios in clearances().items():
                rows = values.sel(clearance_ratio=list(ratios), method="nearest")
                particle = tuple(rows.sel(friction_ratio=0.0, method="nearest").values.tolist())
                for g in FRICTION_RATIOS:
                    hybrid = tuple(rows.sel(friction_ratio=g, method="nearest").values.tolist())
                    off = np.log(np.array(particle + hybrid) / paper)
                    factor = float(np.exp(np.sqrt(np.mean(off**2))))
                    found.append(Reading(name, contact, g, measure, particle, hybrid, factor))
    return found


def _cells(reading: Reading) -> tuple[object, ...]:
    three = [", ".join(f"{value:.3g}" for value in values) for values in (reading.particle, reading.hybrid)]
    return (
        reading.base_amplitude, reading.contact, f"{reading.friction_ratio:g}", reading.measure, *three,
        f"{reading.factor:.3g}",
    )  # fmt: skip
