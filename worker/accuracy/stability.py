"""Integration of each extreme case with the solver and with the paper's method, and checks of the results."""

from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from math import isfinite, nan
from time import perf_counter
from typing import Any

import numpy as np

from damperlab.studies.variables import Status
from damperlab.worker.accuracy.extremes import Extreme
from damperlab.worker.accuracy.march import march_from_rest
from damperlab.worker.accuracy.methods import paper_march
from damperlab.worker.point import Design
from damperlab.worker.simulate import simulate
from damperlab.worker.solver.events import ARRIVED, ATTACHMENTS, IMPACTS, TURNS
from damperlab.worker.solver.observe.meter import METERS, Meter

STEPS = 400
"""Number of steps per cycle in the paper's method."""
SAMPLED_CYCLES = 10
"""The time history of this number of cycles from rest is checked for penetration and for loss of momentum."""
_SLOWEST_SAMPLED = 0.01
"""Frequency ratio below which only one cycle is checked, because such a cycle contains very many natural periods."""


@dataclass(frozen=True)
class Row:
    """A row of the stability report.

    Parameters
    ----------
    name : str
        Name of the case.
    cycles : int
        Number of excitation cycles from rest.
    status : str
        "arrived", or a sentence that describes the failure.
    impacts, turns, attachments : int
        Numbers of impacts, velocity reversals and attachments.
    energy_residual, residual_limit : float
        |work in − losses − change of stored energy| relative to the largest energy, and the limit on this residual.
    penetration : float or None
        Largest excess of |u − p| over d/Z in the checked cycles, relative to d/Z + max |u| + 1, where 1 is the
        amplitude of the base; None without a particle. Rounding errors of the excess are proportional to this sum.
    momentum_error : float or None
        Largest change of u' + β p' across an impact, relative to |u'| + β |p'| + (1 + β) r before the impact; None
        without an impact.
    microseconds : float
        Run time per cycle [µs], including energies and peaks.
    paper : str
        Outcome of the paper's method with 400 steps per cycle.
    passed : bool
        Whether the integration reached its end time, every value is finite, the residual is within its limit,
        and penetration and momentum error are at most 1e-12.
    """

    name: str
    cycles: int
    status: str
    impacts: int
    turns: int
    attachments: int
    energy_residual: float
    residual_limit: float
    penetration: float | None
    momentum_error: float | None
    microseconds: float
    paper: str
    passed: bool

    def document(self) -> dict[str, Any]:
        """Return the row as JSON-able data."""
        return asdict(self)


def stability_table(
    cases: Iterable[Extreme], on_case: Callable[[str], None] = lambda name: None
) -> list[Row]:
    """Integrate and check every case."""
    rows = []
    for case in cases:
        on_case(case.name)
        rows.append(run_case(case))
    return rows


def run_case(case: Extreme) -> Row:
    """Integrate one case from rest and check the result."""
    design = case.design
    friction = design.friction_ratio if design.friction_ratio > 0.0 else None
    arguments = (design.damping_ratio, design.frequency_ratio, friction, design.particle)
    march_from_rest(*arguments, 1, Meter(np.zeros(METERS)))  # this compiles or loads the kernel of the scene
    began = perf_counter()
    state, outcome, counts, (residual, _largest, _mean) = march_from_rest(
        *arguments, case.cycles, Meter(np.zeros(METERS))
    )
    seconds = perf_counter() - began
    penetration, momentum = _sampled(design, case.cycles)
    arrived = outcome == ARRIVED
    good = arrived and all(isfinite(x) for x in (*state, residual)) and residual <= case.residual_limit
    within = (penetration or 0.0) <= 1e-12 and (momentum or 0.0) <= 1e-12
    return Row(
        case.name,
        case.cycles,
        "arrived" if arrived else Status(int(outcome)).sentence,
        int(counts[IMPACTS]),
        int(counts[TURNS]),
        int(counts[ATTACHMENTS]),
        float(residual) if arrived else nan,
        case.residual_limit,
        penetration,
        momentum,
        seconds / case.cycles * 1e6,
        _paper(design, case.cycles, state if arrived else None),
        bool(good and within),
    )


def _sampled(design: Design, cycles: int) -> tuple[float | None, float | None]:
    """Return penetration and momentum error, computed from the time history of the first cycles."""
    if design.particle is None:
        return None, None
    sampled = 1 if design.frequency_ratio < _SLOWEST_SAMPLED else min(cycles, SAMPLED_CYCLES)
    history = simulate(design, sampled, history=sampled).history
    if not history:
        return None, None
    beta, clearance = design.particle.mass_ratio, design.particle.clearance_ratio
    beyond = np.abs(history["u"] - history["p"]) - clearance
    penetration = float(np.max(beyond, initial=0.0) / (1.0 + clearance + np.abs(history["u"]).max()))
    if design.particle.wall is not None:
        penetration = 0.0  # penetrating a compliant wall is no error
    before = np.flatnonzero(history["impact"][:-1] == 1.0)
    # A row with the time of the impact follows, unless the impact is at the end of a half cycle.
    before = before[history["time"][before + 1] - history["time"][before] <= 1e-9]
    if before.size == 0:
        return penetration, None
    u_rate, p_rate = history["u_rate"], history["p_rate"]
    change = (u_rate[before + 1] - u_rate[before]) + beta * (p_rate[before + 1] - p_rate[before])
    scale = np.abs(u_rate[before]) + beta * np.abs(p_rate[before]) + design.frequency_ratio * (1.0 + beta)
    return penetration, float(np.max(np.abs(change) / scale))


def _paper(design: Design, cycles: int, state: tuple[float, ...] | None) -> str:
    """Describe the outcome of the paper's method in a few words."""
    if design.particle is not None and design.particle.contact_time is not None:
        return "supports no contact time"
    found = paper_march(design, min(cycles, 10_000), STEPS)
    if found is None:
        return "not finite"
    if state is None or cycles > 10_000:
        return "finite"
    difference = max(abs(a - b) for a, b in zip(found, state, strict=True))
    scale = max(1e-300, *(abs(x) for x in state))
    if max(abs(x) for x in found) > 1e6 * max(1.0, scale):
        return "grows without bound"
    return f"state off by {difference / scale:.1g}"
