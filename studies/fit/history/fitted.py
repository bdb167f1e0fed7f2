"""The result of a fit of a time history, and the study of the fitted prototype over a band around resonance."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import pi
from typing import Any

import numpy as np

from damperlab.studies.faults import Fault, StudyFaults
from damperlab.studies.fit.fitted import CURVE_VALUES, Outcome
from damperlab.studies.fit.history.question import RELEASE, Column, History, HistoryQuestion
from damperlab.studies.fit.question import study_document
from damperlab.studies.spelling import spelled

BAND = 0.8, 1.25
"""Band of the study, as multiples of the natural frequency. The band includes the resonance of M + m for m/M ≤ 0.5."""


@dataclass(frozen=True, kw_only=True)
class FittedHistory(Outcome):
    """The result of a fit of a time history.

    Parameters
    ----------
    question : HistoryQuestion
        The definition of the fit.
    rows : int
        Number of samples that are used: the longest initial part with a predictable response.
    model_m : ndarray, shape (rows of the measurement,)
        Displacement with the best parameters [m].
    deviation_m : ndarray, shape (rows of the measurement,)
        Standard deviation of the measurement [m]; an estimate if none was given.
    correlated : float
        Upper bound of the factor by which intervals are widened because residuals are correlated from sample to sample.
    """

    question: HistoryQuestion
    rows: int
    model_m: Column = field(repr=False)
    deviation_m: Column = field(repr=False)
    correlated: float = 1.0

    def study(self) -> dict[str, Any]:
        """Write the prototype as a study over a band around the natural frequency; see `harmonic_document`."""
        return harmonic_document(self.question, self.values)

    @property
    def chosen(self) -> str:
        """Sentence about the base amplitude in `study`, which was neither given nor measured."""
        amplitude = spelled(self.study()["physical"]["base_amplitude_m"], "m", 3)
        return (
            f"`base_amplitude_m` ({amplitude}) was not given: with it the prototype moves about as much as in the "
            "measurement. Replace it by the excitation that you want to know."
        )

    @property
    def stretch_s(self) -> float:
        """Duration of the part that is used [s]."""
        return (self.rows - 1) * self.question.measured.step_s

    @property
    def whole(self) -> bool:
        """Whether the complete history is used."""
        return self.rows == self.question.measured.rows

    @property
    def residual(self) -> Column:
        """Measured minus computed in standard deviations, for the samples that are used, shape (rows,)."""
        off = self.question.measured.displacement_m - self.model_m
        return np.asarray((off / self.deviation_m)[: self.rows])

    @property
    def probability(self) -> float | None:
        """p-value of the chi-square test; None if the measurement states no standard deviations."""
        if self.question.measured.deviation_m is None:
            return None
        from scipy.special import chdtrc

        return float(chdtrc(self.freedom, self.chi_square))


def harmonic_document(question: HistoryQuestion, values: Mapping[str, float]) -> dict[str, Any]:
    """Write the prototype as a study over frequency.

    Parameters
    ----------
    question : HistoryQuestion
        The definition of the fit, with the known values.
    values : mapping of float
        The estimated parameters.

    Returns
    -------
    dict
        The definition of the study over `BAND`, with the base amplitude from `base_amplitude_m`.

    Raises
    ------
    StudyFaults
        If no base amplitude can be determined; see `base_amplitude_m`.
    """
    given = {name: value for name, value in question.given(values).items() if name != RELEASE}
    if given.get("friction_force_n") == 0.0:
        # a friction of 0 can be given as a ratio, which needs no mass
        del given["friction_force_n"]
        given["friction_ratio"] = 0.0
    given["base_amplitude_m"] = base_amplitude_m(question.measured, given)
    settings: dict[str, Any] = {"name": f"{question.measured.name}, fitted"}
    if not question.particle:
        settings["particle"] = False
    else:
        settings["contact"] = question.contact.model_dump(mode="json")
    band = {"start": BAND[0], "stop": BAND[1], "num": CURVE_VALUES}
    return study_document(settings, given, band)


def check_study(question: HistoryQuestion) -> None:
    """Check before the computation that the result of a fit can be written as a study.

    Raises
    ------
    StudyFaults
        If no base amplitude can be determined; see `base_amplitude_m`.
    """
    harmonic_document(question, question.values(np.full(len(question.free), 0.5)))


def base_amplitude_m(measured: History, given: Mapping[str, float]) -> float:
    """Return a base amplitude under which the prototype moves about as much as in the measurement.

    If the base moved, the result is the amplitude of a sine motion at the natural frequency. The sine and the
    measured base motion have the same largest acceleration. After a release at X, the result is the base amplitude
    under which the structure vibrates with the amplitude X at resonance, if the particle has no effect. At
    resonance, the base leads the structure by a quarter of a cycle, and supplies the energy πkZX per cycle. Damping
    dissipates 2πζkX² and friction 4FX, so Z = 2ζX + 4F/(πk).

    Parameters
    ----------
    measured : History
        The measurement.
    given : mapping of float
        Values of the prototype, by the names of a study.

    Raises
    ------
    StudyFaults
        If only a particle dissipates the energy of the released structure.
    """
    omega = 2.0 * pi * given["natural_frequency_hz"]
    if measured.base_m_s2 is not None:
        return float(abs(measured.base_m_s2).max()) / omega**2
    mass = given.get("mass_kg", 1.0)
    damping = given.get("damping_ratio", given.get("damping_n_s_per_m", 0.0) / (2.0 * mass * omega))
    friction = 4.0 * given.get("friction_force_n", 0.0) / (pi * mass * omega**2)
    base_m = 2.0 * damping * measured.largest_m + friction
    if base_m == 0.0:
        told = (
            "Without damping and friction of the structure, the decay does not determine a base amplitude "
            "for the fitted study."
        )
        advice = "give the damping ratio, or estimate it; or measure with a base that moves"
        raise StudyFaults([Fault("damping_ratio", "0", "damping or friction", advice, told)])
    return base_m
