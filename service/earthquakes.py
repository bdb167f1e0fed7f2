"""What both doors answer about earthquakes: a comparison with its units, bounded in what it costs."""

from typing import Any

from damperlab.studies.faults import Fault, StudyFaults
from damperlab.studies.ground.brief import brief_of
from damperlab.studies.ground.paper import SOURCE_NOTE, TABLE_A1
from damperlab.studies.ground.question import Earthquake

MOST_WINDOWS = 3_000_000
"""Windows that one comparison may march through, all starts together: some seconds."""

UNITS = {
    "m": "displacements and the length scale",
    "m/s": "speeds",
    "m/s2": "accelerations",
    "J": "energies",
    "N": "the friction force",
}


def answer_comparison(asked: Earthquake, samples: int = 0) -> dict[str, Any]:
    """Compute a comparison, bounded in what it may cost.

    Parameters
    ----------
    asked : Earthquake
        The comparison.
    samples : int
        Most samples of the time history of each case; 0 for no histories.

    Raises
    ------
    StudyFaults
        Where it would take too long.
    """
    from damperlab.worker.ground.comparison import compare, structure_of

    motion = asked.motion
    omega = structure_of(asked).omega
    shortest = min(motion.step_s, 0.4 / omega)
    windows = (motion.duration_s + asked.values["tail_s"]) / shortest
    acting = sum(case not in ("none", "tmd") for case in asked.cases)
    runs = 1 + acting * (1 + asked.starts + (samples > 0))
    if windows * runs > MOST_WINDOWS:
        found = f"{runs} runs of about {windows:,.0f} steps"
        advice = "ask for fewer `starts` or `cases`, a shorter tail, or a slower structure"
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
    answer = compare(asked)
    paper = {case: {"peak_m": peak, "rms_m": rms} for case, (peak, rms) in TABLE_A1.items()}
    if samples:
        from damperlab.service.histories import sampled

        answer["histories"] = sampled(asked, samples)
    brief = brief_of(answer).document()
    return {**answer, "brief": brief, "paper_table_a1": paper, "note": SOURCE_NOTE, "units": UNITS}
