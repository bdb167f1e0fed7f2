"""Computes comparisons of dampers under a ground-motion record for all user interfaces, and limits their cost."""

from typing import Annotated, NotRequired

from damperlab.studies.brief import InShort
from damperlab.studies.faults import Fault, StudyFaults
from damperlab.studies.ground.brief import brief_of
from damperlab.studies.ground.paper import SOURCE_NOTE, TABLE_A1
from damperlab.studies.ground.question import Earthquake
from damperlab.studies.shapes import Measured, Says, Table
from damperlab.studies.vocabulary import CASES
from damperlab.worker.ground.compared import Comparison

MOST_WINDOWS = 3_000_000
"""Largest total number of integration steps of a comparison. A comparison of this size takes some seconds."""


class WithPaper(Comparison):
    """A comparison, and the corresponding results of the paper."""

    brief: InShort
    paper_table_a1: Annotated[dict[str, dict[str, Measured]], Says(propertyNames={"enum": list(CASES)})]
    note: str
    units: dict[str, str]


class ComparedDocument(WithPaper):
    """Answer to a request for a comparison, with time histories if requested."""

    histories: NotRequired[Annotated[dict[str, Table], Says(propertyNames={"enum": list(CASES)})]]


UNITS = {
    "m": "displacements and the length scale",
    "m/s": "speeds",
    "m/s2": "accelerations",
    "J": "energies",
    "N": "the friction force",
}


def answer_comparison(asked: Earthquake, samples: int = 0) -> WithPaper:
    """Compute a comparison.

    Parameters
    ----------
    asked : Earthquake
        The requested comparison.
    samples : int
        Largest number of samples of each time history; 0 for no time histories.

    Raises
    ------
    StudyFaults
        If the comparison would take more than `MOST_WINDOWS` integration steps.
    """
    from damperlab.worker.ground.comparison import (  # imported here, because it imports the compiler
        compare,
        structure_of,
    )

    motion = asked.motion
    omega = structure_of(asked).omega
    shortest = min(motion.step_s, 0.4 / omega)
    windows = (motion.duration_s + asked.values["tail_s"]) / shortest
    acting = sum(case not in ("none", "tmd") for case in asked.cases)
    runs = 1 + acting * (1 + asked.starts + (samples > 0))
    if windows * runs > MOST_WINDOWS:
        found = f"{runs} runs of about {windows:,.0f} steps"
        advice = "ask for fewer `starts` or `cases`, a shorter tail, or a lower natural frequency"
        raise StudyFaults(
            [
                Fault(
                    "starts",
                    found,
                    f"at most {MOST_WINDOWS:,} steps in all",
                    advice,
                    f"The comparison takes {found}; at most {MOST_WINDOWS:,} steps in all are allowed.",
                )
            ]
        )
    compared = compare(asked)
    paper = {case: {"peak_m": peak, "rms_m": rms} for case, (peak, rms) in TABLE_A1.items()}
    answer: WithPaper = {
        **compared,
        "brief": brief_of(compared).document(),
        "paper_table_a1": paper,
        "note": SOURCE_NOTE,
        "units": UNITS,
    }
    if not samples:
        return answer
    from damperlab.service.histories import sampled

    shown: ComparedDocument = {**answer, "histories": sampled(asked, samples)}
    return shown
