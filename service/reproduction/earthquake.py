"""Table A1 and Figure A2: the dampers under an earthquake."""

from collections.abc import Iterator

import numpy as np

from damperlab.service.figures.earthquake import draw_earthquake
from damperlab.service.histories import histories_of
from damperlab.service.reproduction.section import Row, Section, Solve
from damperlab.studies.choices import InstantContact
from damperlab.studies.ground.builtin import builtin_record
from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.ground.paper import (
    BASE_AMPLITUDES_M,
    CLEARANCES_M,
    SOURCE_NOTE,
    TABLE_A1,
    friction_force_n,
)
from damperlab.studies.ground.quantities import QUANTITIES
from damperlab.studies.ground.question import Earthquake
from damperlab.studies.paper import PaperNumber, paper_numbers
from damperlab.studies.tmd.tunings import den_hartog
from damperlab.studies.vocabulary import CASES
from damperlab.worker.ground.absorber import absorber_response
from damperlab.worker.ground.comparison import spread
from damperlab.worker.ground.design import Damper, Structure
from damperlab.worker.ground.measures import GroundResponse
from damperlab.worker.ground.response import ground_response

RECORD = "loma-prieta-000"
STARTS = 8


def table_a1(solve: Solve, quick: bool) -> Section:
    """Compute peak and rms with each damper, for all cavities and friction forces that the paper may mean."""
    section = Section("Table A1: dampers under an earthquake")
    known = paper_numbers()
    motion = builtin_record(RECORD)
    factor = _paper_factor(motion)
    peaks: dict[str, list[float]] = {}
    for case, assumption, found in _tried(motion, factor, 0 if quick else STARTS):
        values = {"peak": found.peak_relative_displacement_m, "rms": found.rms_relative_displacement_m}
        peaks.setdefault(case, []).append(values["peak"])
        section.rows += [
            Row(f"{CASES[case]}, {what} [m]", known[f"earthquake_{what}_{case}_m"], values[what], assumption,
                None, "instant" if case in ("pid", "hybrid") else "")
            for what in ("peak", "rms")
        ]  # fmt: skip

    def less(case: str) -> float:
        return 1 - min(peaks[case]) / peaks["tmd"][0]

    section.rows += [
        Row("relative reduction of the peak, best hybrid against tuned mass damper", known["earthquake_less_than_tmd"],
            less("hybrid"), "least peak over all cavities and forces tried", None, "instant"),
        Row("relative reduction of the peak, best friction damper against tuned mass damper",
            PaperNumber(
                1 - known["earthquake_peak_fd_m"].value / known["earthquake_peak_tmd_m"].value, "from Table A1"
            ),
            less("fd"), "least peak over all forces tried"),
    ]  # fmt: skip
    section.verdict = (
        "The paper states neither clearance, friction force nor scale of the record. Its record may not be "
        "redistributed; another record of the same earthquake replaces it."
    )
    section.words = [
        SOURCE_NOTE,
        f"Here the record is {motion.name}, multiplied by {factor:.4g}. With this factor, the peak without a "
        "damper equals the paper's. All amplitudes are relative to the base. Every cavity of the prototype "
        "was tried. The paper's labels d/Z imply several base amplitudes Z; for each, the friction force "
        "that gives X/Z = 16.22 was tried. If a change of the start by at most 0.0001 mm makes the response "
        f"diverge, the row also gives the range of the peak over {STARTS} such starts.",
    ]
    return section


def figure_a2(solve: Solve, quick: bool) -> Section:
    """Draw the displacement over time under the earthquake, with each damper and without a damper."""
    section = Section("Figure A2: displacement under an earthquake")
    known = paper_numbers()
    motion = builtin_record(RECORD)
    values = {name: default for name, (_, default) in QUANTITIES.items()} | {"scale": _paper_factor(motion)}
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
    section.verdict = (
        "The figure shows one damper of each kind. As in Table A1, another record of the same earthquake "
        "replaces the paper's."
    )
    section.words = [
        "The paper draws the displacement over time; our peaks are compared with its Table A1. The figure "
        "shows the displacement relative to the base for one damper of each kind, with "
        f"d = {cavity:g} mm and F_f = {force:g} N. Table A1 above has every cavity and friction force that "
        "the paper may have meant.",
    ]
    return section


def _tried(motion: GroundMotion, factor: float, starts: int) -> Iterator[tuple[str, str, GroundResponse]]:
    """Yield the damper, the reading of the paper and the response, for every damper of the table and every reading."""
    structure = Structure()
    mass = 0.1 * structure.mass_kg
    forces = {
        z: friction_force_n(z, structure.stiffness_n_per_m, structure.damping_ratio)
        for z in BASE_AMPLITUDES_M
    }
    none = f"the record multiplied by {factor:.4g}, so that the peak without a damper is the paper's"
    yield "none", none, ground_response(structure, Damper(), motion, factor)
    yield "tmd", "den_hartog, mass ratio 0.1", absorber_response(structure, den_hartog(0.1), motion, factor)
    tried = [("pid", f"d = {1e3 * d:g} mm", Damper(0.0, mass, d)) for d in CLEARANCES_M]
    tried += [
        ("fd", f"F_f = {force:.3g} N (Z = {1e3 * z:.3g} mm)", Damper(force)) for z, force in forces.items()
    ]
    tried += [
        ("hybrid", f"d = {1e3 * d:g} mm, F_f = {force:.3g} N", Damper(force, mass, d))
        for d in CLEARANCES_M
        for force in forces.values()
    ]
    for case, assumption, damper in tried:
        found = ground_response(structure, damper, motion, factor)
        if starts:
            over = spread(structure, damper, motion, found, factor, starts=starts)
            if over["sensitive"]:
                low, high = (over["peak_relative_displacement_m"][end] for end in ("lowest", "highest"))
                assumption += f"; nearby starts diverge, with peaks from {low:.4g} to {high:.4g} m"
        yield case, assumption, found


def _paper_factor(motion: GroundMotion) -> float:
    """Return the factor by which to scale a record so that the peak without a damper agrees with Table A1."""
    none = ground_response(Structure(), Damper(), motion)
    return TABLE_A1["none"][0] / none.peak_relative_displacement_m
