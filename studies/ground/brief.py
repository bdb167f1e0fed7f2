"""Short comparison of dampers under one record: the best damper, and how certain this choice is."""

from collections.abc import Mapping
from typing import Any

from damperlab.studies.brief import Brief, Damper
from damperlab.studies.cavity import cavity_of
from damperlab.studies.ground.motion import doubt_of
from damperlab.studies.spelling import quantity

SAME = 0.02
"""Relative difference below which peaks count as equal. Among dampers with equal peaks, the simplest
damper is recommended.
"""
HELD = 1.0 - 1e-6
"""Share of the time from which friction counts as holding the structure throughout; the stored share is rounded."""
PEAK, SHAKEN = "peak_relative_displacement_m", "peak_absolute_acceleration_m_s2"
DAMPERS: dict[str, Damper] = {
    "none": "no_damper",
    "fd": "friction_alone",
    "tmd": "tuned_mass_damper",
    "pid": "particle_alone",
    "hybrid": "hybrid",
}
"""Name of the damper in each case of a comparison; cases with few parts come first."""


def brief_of(answer: Mapping[str, Any]) -> Brief:
    """Recommend the damper with the smallest displacement of the structure relative to its base under a record.

    Parameters
    ----------
    answer : mapping
        Answer of a comparison, with `cases`, `record` and `design`.
    """
    cases = {case: answer["cases"][case] for case in DAMPERS if case in answer["cases"]}
    least = min(float(values[PEAK]) for values in cases.values())
    best = next(case for case, values in cases.items() if float(values[PEAK]) <= least * (1 + SAME))
    scale = float(answer["design"]["scale"])
    under = answer["record"]["name"] + ("" if scale == 1.0 else f" × {scale:g}")
    moves = quantity(PEAK, cases[best][PEAK], 3)
    if cases[best].get("stick_fraction", 0.0) >= HELD:
        most = quantity(SHAKEN, cases[best][SHAKEN], 3)
        held = f"Under {under} {cases[best]['label']} holds the structure to its base throughout"
        told = f"{held}: it moves with the ground, at up to {most}, and nothing is damped"
    elif len(cases) == 1:
        told = f"Under {under} the structure moves {moves} against the base ({cases[best]['label']})"
    elif best == "none":
        told = f"Under {under} no damper is worth building: without one the structure moves {moves} against the base"
    else:
        least_of_all = float(cases[best][PEAK]) == least
        by = "moves least" if least_of_all else f"moves as little as any, within {100 * SAME:.0f} %,"
        told = f"Under {under} the structure with {cases[best]['label']} {by} against the base: {moves}"
        if "none" in cases:
            share = 1 - float(cases[best][PEAK]) / float(cases["none"][PEAK])
            told += f", {100 * share:.0f} % less than without damper"
    spread = cases[best].get("spread")
    doubts = [doubt_of(float(answer["record"]["peak_displacement_m"]))]
    if spread and spread["sensitive"]:
        low, high = (quantity(PEAK, spread[PEAK][end], 3) for end in ("lowest", "highest"))
        doubts.append(f"The peak depends on the start: {low} to {high} over {spread['starts']} starts.")
    rows = tuple(
        (
            values["label"],
            quantity(PEAK, values[PEAK], 3),
            f"with up to {quantity(SHAKEN, values[SHAKEN], 3)}",
        )
        for values in cases.values()
    )
    if {"pid", "hybrid"} & cases.keys():
        cavity = cavity_of(answer["design"])
        rows += (("given" if cavity.acts else "assumed", cavity.words, ""),)
    following = "several records and scales as a suite, with `damperlab run`; one record decides little."
    return Brief(DAMPERS[best], (f"{told}.", " ".join(filter(None, doubts))), rows, following)
