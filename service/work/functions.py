"""Functions that a separate process calls to answer requests. The solver is imported when a function is called."""

import numpy as np
from typing_extensions import TypedDict

from damperlab.service.documents import Document
from damperlab.service.earthquakes import answer_comparison
from damperlab.service.simulation import compute
from damperlab.service.simulation_request import Asked
from damperlab.studies.fit.history.question import HistoryQuestion
from damperlab.studies.fit.question import FitQuestion
from damperlab.studies.ground.files import Layout, read_record
from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.ground.question import Earthquake
from damperlab.studies.ground.shelf import Shelf
from damperlab.studies.shapes import Number, Numbers
from damperlab.studies.specification.reading import load_specification, parse_specification
from damperlab.studies.specification.specification import Specification
from damperlab.studies.text import Format, load_text
from damperlab.studies.understood import unusual_specification
from damperlab.worker.scenes import Scene


def simulation_body(asked: Asked, cycles_limit: int) -> bytes:
    """Compute a design point, and return the motion with its forces and harmonics as JSON."""
    from damperlab.service.motions import forces_on, harmonics_of

    found = compute(asked, cycles_limit)
    if found["history"]:
        found["forces"] = forces_on(found["history"], asked.design)
        found["spectrum"] = harmonics_of(found["history"], asked.design.frequency_ratio)
    return bytes(Document(found).body)


def comparison_body(asked: Earthquake, samples: int = 0) -> bytes:
    """Compare dampers in an earthquake; return the answer as JSON."""
    return bytes(Document(answer_comparison(asked, samples)).body)


def fit_asked(body: bytes) -> tuple[FitQuestion | HistoryQuestion, list[Scene]]:
    """Read the request for a fit, and return it with the scenes that must be compiled for the answer."""
    from damperlab.studies.fit.document import read_fit
    from damperlab.worker.fit.history.march import scenes_of as scenes_of_history
    from damperlab.worker.fit.model import scenes_of

    question = read_fit(load_text(body, "json"))
    if isinstance(question, HistoryQuestion):
        return question, scenes_of_history(question)
    return question, scenes_of(question)


def fit_body(question: FitQuestion | HistoryQuestion) -> bytes:
    """Estimate the parameters of a prototype; return the answer as JSON."""
    from damperlab.service.fit_report import fit_document
    from damperlab.service.history_report import history_document
    from damperlab.worker.fit.estimate import fit_response
    from damperlab.worker.fit.history.estimate import fit_history

    if isinstance(question, HistoryQuestion):
        return bytes(Document(history_document(fit_history(question))).body)
    return bytes(Document(fit_document(fit_response(question))).body)


def uploaded(body: bytes, layout: Layout, name: str, units: str | None) -> GroundMotion:
    """Read an uploaded record."""
    return read_record(body, layout, name, units)


class Look(TypedDict):
    """Samples of a record, and its response spectrum."""

    time_s: Numbers
    acceleration_m_s2: Numbers
    damping_ratio: Number
    period_s: Numbers
    pseudo_acceleration_m_s2: Numbers


def looked_at(motion: GroundMotion, most: int) -> Look:
    """Return a preview of a record: at most `most` samples, including the extremes, and the response spectrum."""
    from damperlab.worker.ground.response_spectrum import response_spectrum

    a = motion.acceleration_m_s2
    rows = np.arange(a.size)
    if a.size > most:
        even = np.linspace(0, a.size - 1, max(2, most - 2)).astype(int)
        rows = np.unique([*even, int(a.argmax()), int(a.argmin())])
    spectrum = response_spectrum(motion)
    return {
        "time_s": (rows * motion.step_s).tolist(),
        "acceleration_m_s2": a[rows].tolist(),
        "damping_ratio": spectrum.damping_ratio,
        "period_s": spectrum.period_s.tolist(),
        "pseudo_acceleration_m_s2": spectrum.pseudo_acceleration_m_s2.tolist(),
    }


def specified(body: bytes, written_in: Format, records: Shelf) -> tuple[Specification, int, list[str]]:
    """Read a specification. Return the specification, the budget in points, and messages about unusual values."""
    from damperlab.service.design_budget import budget_of
    from damperlab.studies.design.design import designing

    asked = parse_specification(load_specification(body, written_in), records)
    budget = budget_of(asked)
    next(designing(asked, budget))
    return asked, budget, unusual_specification(asked)


def prepare() -> None:
    """Import in advance all modules that the functions of this module need."""
    import damperlab.service.fit_report
    import damperlab.service.history_report
    import damperlab.service.questions.needed
    import damperlab.studies.design.design
    import damperlab.worker.attractors
    import damperlab.worker.fit.estimate
    import damperlab.worker.fit.history.estimate
    import damperlab.worker.ground.comparison
    import damperlab.worker.ground.response_spectrum
    import damperlab.worker.simulate  # noqa: F401
