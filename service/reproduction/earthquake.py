"""Table A1: the dampers under an earthquake."""

from functools import partial
from typing import Any

import numpy as np

from damperlab.service.figures.earthquake import draw_earthquake
from damperlab.service.histories import histories_of
from damperlab.service.reproduction.section import Row, Section, Solve
from damperlab.studies.choices import InstantContact
from damperlab.studies.ground.builtin import builtin_record
from damperlab.studies.ground.paper import SOURCE_NOTE
from damperlab.studies.ground.quantities import QUANTITIES
from damperlab.studies.ground.question import Earthquake
from damperlab.studies.paper import PaperNumber, paper_numbers
from damperlab.studies.vocabulary import CASES
from damperlab.worker.ground.comparison import paper_factor
from damperlab.worker.ground.comparison import table_a1 as compute

RECORD = "loma-prieta-000"
STARTS = 8


def table_a1(solve: Solve, quick: bool) -> Section:
    """Peak and rms with each damper, for each cavity and each friction force that the paper may have meant."""
    section = Section("Table A1: dampers under an earthquake")
    known = paper_numbers()
    motion = builtin_record(RECORD)
    factor = paper_factor(motion)
    table = compute(motion, factor, starts=0 if quick else STARTS)
    for row in table["rows"]:
        case = row["damper"]
        assumed = [row["assumption"]] if row["assumption"] else []
        if row.get("sensitive"):
            assumed.append(
                f"sensitive to its start: peak {row['peak_lowest_m']:.4g} to {row['peak_highest_m']:.4g} m"
            )
        assumption = "; ".join(assumed) or f"the record times {factor:.4g}, so that this peak is the paper's"
        section.rows += [
            Row(f"{CASES[case]}, {what} [m]", known[f"earthquake_{what}_{case}_m"], row[f"{what}_m"], assumption,
                None, "instant" if case in ("pid", "hybrid") else "")
            for what in ("peak", "rms")
        ]  # fmt: skip
    rows = table["rows"]
    less = partial(_least_below_absorber, rows)
    section.rows += [
        Row("best hybrid's peak below the tuned mass damper's, share", known["earthquake_less_than_tmd"],
            less("hybrid"), "least peak over all cavities and forces tried", None, "instant"),
        Row("best friction's peak below the tuned mass damper's, share",
            PaperNumber(
                1 - known["earthquake_peak_fd_m"].value / known["earthquake_peak_tmd_m"].value, "from Table A1"
            ),
            less("fd"), "least peak over all forces tried"),
    ]  # fmt: skip
    section.verdict = (
        "The paper says neither clearance, friction force nor scale of that run, and its record is not free; another record of "
        "the same earthquake stands in for it."
    )
    section.words = [
        SOURCE_NOTE,
        f"Here the record is {motion.name}, multiplied by {factor:.4g}, which gives the structure without a damper the "
        "paper's peak against its base; every cavity of the prototype, and the friction force that gives the 16.22 of "
        "Table 3 for each base amplitude that its labels may mean, were tried. Amplitudes are those against the base. A "
        "response that depends on its start in the seventh digit has the range of its peak over "
        f"{STARTS} such starts beside it.",
    ]
    return section


def figure_a2(solve: Solve, quick: bool) -> Section:
    """Displacement over time under the earthquake, with each damper and without one."""
    section = Section("Figure A2: displacement under an earthquake")
    known = paper_numbers()
    motion = builtin_record(RECORD)
    values = {name: default for name, (_, default) in QUANTITIES.items()} | {"scale": paper_factor(motion)}
    asked = Earthquake(RECORD, motion, values, "den_hartog", tuple(CASES), 0, 0, InstantContact())
    for case, history in histories_of(asked).items():
        x = history["relative_displacement_m"]
        place = int(np.abs(x).argmax())
        section.rows.append(
            Row(f"{CASES[case]}, largest displacement [m]", known[f"earthquake_peak_{case}_m"], float(np.abs(x[place])),
                f"in the curve drawn, at {history['time_s'][place]:.3g} s", None,
                "instant" if case in ("pid", "hybrid") else "")
        )  # fmt: skip
    section.figures["figure-a2.png"] = draw_earthquake(asked)
    cavity, force = 1e3 * values["clearance_m"], values["friction_force_n"]
    section.verdict = "As Table A1: one damper of each kind, under the other record."
    section.words = [
        "The paper draws the displacement over time; the numbers beside ours are those of its Table A1. Drawn here is one "
        f"damper of each kind, d = {cavity:g} mm and F_f = {force:g} N, against the base; Table A1 above has every cavity "
        "and friction force that the paper may have meant.",
    ]
    return section


def _least_below_absorber(rows: list[dict[str, Any]], case: str) -> float:
    peak = {
        name: float(min(row["peak_m"] for row in rows if row["damper"] == name)) for name in (case, "tmd")
    }
    return 1 - peak[case] / peak["tmd"]
