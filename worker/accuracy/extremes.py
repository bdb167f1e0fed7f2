"""Extreme cases: designs at the limits of the allowed ranges, and events that coincide to the last bit."""

from dataclasses import dataclass
from math import pi

import numpy as np

from damperlab.worker.accuracy.march import march_from_rest
from damperlab.worker.physics.compliant_wall import contact_time_of_stiffness, wall_constants
from damperlab.worker.point import Design
from damperlab.worker.simulate import simulate
from damperlab.worker.solver.events import ATTACHMENTS
from damperlab.worker.solver.particle import Particle, Wall

ZETA = 0.0038
PAPER = Particle(10.0, 0.47, 0.1)
LONG_RUN_CYCLES = 1_000_000
_BISECTIONS = 80


@dataclass(frozen=True)
class Extreme:
    """An extreme case: a design, and the length of an integration from rest.

    Parameters
    ----------
    name : str
        Text that describes the design.
    design : Design
        The design point.
    cycles : int
        Number of excitation cycles from rest.
    residual_limit : float
        Largest allowed energy residual.
    """

    name: str
    design: Design
    cycles: int = 200
    residual_limit: float = 1e-9


def extreme_cases(long_run_cycles: int = LONG_RUN_CYCLES) -> list[Extreme]:
    """Return all cases of the stability report.

    Parameters
    ----------
    long_run_cycles : int
        Number of cycles of the long runs. A quick test may use a smaller number.
    """
    hybrid = Particle(2.0, 0.47, 0.1)
    quarter = pi / 4.0
    cases = [
        Extreme("ζ = 0, hybrid", Design(0.0, 1.0, 0.4, Particle(5.0, 0.47, 0.1))),
        Extreme("ζ = 0, particle, r = 1", Design(0.0, 1.0, 0.0, PAPER)),
        Extreme("ζ = 0.99, hybrid", Design(0.99, 1.0, 0.2, Particle(0.5, 0.47, 0.1))),
        Extreme("e = 0, particle", Design(ZETA, 1.0, 0.0, PAPER._replace(restitution=0.0))),
        Extreme("e = 0, hybrid", Design(ZETA, 1.0, 0.6, hybrid._replace(restitution=0.0))),
        Extreme("e = 1, particle", Design(ZETA, 1.0, 0.0, PAPER._replace(restitution=1.0))),
        Extreme("e = 1, hybrid", Design(ZETA, 1.0, 0.6, hybrid._replace(restitution=1.0))),
        Extreme(
            "e = 1, friction that stops the mass between impacts",
            Design(ZETA, 0.5, 1.3, Particle(0.02, 1.0, 0.1)),
        ),
        Extreme("β = 1e-9", Design(ZETA, 1.0, 0.4, Particle(5.0, 0.47, 1e-9))),
        Extreme("β = 1e3", Design(ZETA, 1.0, 0.4, Particle(5.0, 0.47, 1e3))),
        Extreme("d/Z = 1e-6", Design(ZETA, 1.0, 0.4, Particle(1e-6, 0.47, 0.1))),
        Extreme("d/Z = 1e6", Design(ZETA, 1.0, 0.4, Particle(1e6, 0.47, 0.1))),
        Extreme("r = 1e-4, linear", Design(ZETA, 1e-4), 3),
        Extreme("r = 1e-4, hybrid", Design(ZETA, 1e-4, 1e-9, Particle(0.5, 0.47, 0.1)), 3),
        Extreme("r = 1e4, hybrid", Design(ZETA, 1e4, 0.4, Particle(1e-9, 0.47, 0.1))),
        Extreme("γ_F = 0, particle", Design(ZETA, 1.0, 0.0, PAPER)),
        Extreme("γ_F = 1e-300", Design(ZETA, 1.0, 1e-300, PAPER)),
        Extreme("γ_F = π/4 − 1e-9, ζ = 0", Design(0.0, 1.0, quarter - 1e-9)),
        Extreme("γ_F = π/4, ζ = 0", Design(0.0, 1.0, quarter)),
        Extreme("γ_F = π/4 + 1e-9, ζ = 0", Design(0.0, 1.0, quarter + 1e-9)),
        Extreme("γ_F = π/4 + 1e-9, hybrid", Design(0.0, 1.0, quarter + 1e-9, hybrid)),
        Extreme("γ_F = 10", Design(ZETA, 1.0, 10.0)),
        Extreme("γ_F = 10, particle", Design(ZETA, 1.0, 10.0, Particle(0.5, 0.47, 0.1))),
        Extreme("γ_F = r², tie of stick", Design(0.5, 0.7, 0.7 * 0.7)),
    ]
    cases += _grazing()
    cases += [
        Extreme("impacts during stick", Design(ZETA, 0.9, 1.2, Particle(0.5, 0.47, 0.1))),
        Extreme("impacts during stick, e = 0", Design(ZETA, 0.5, 0.2, Particle(0.5, 0.0, 0.1))),
        Extreme("chatter and stick", Design(ZETA, 0.9, 0.8, Particle(0.3, 0.1, 0.1))),
    ]
    cases += _contact_times()
    cases += _stiffnesses()
    cases += _chatter_until_release()
    cases += _turn_with_impact()
    cases += [
        Extreme("long run, friction", Design(ZETA, 1.0, 0.6), long_run_cycles, 1e-6),
        Extreme("long run, particle", Design(ZETA, 1.0, 0.0, PAPER), long_run_cycles, 1e-6),
        Extreme("long run, hybrid", Design(ZETA, 1.0, 0.4, Particle(5.0, 0.47, 0.1)), long_run_cycles, 1e-6),
    ]
    return cases


def _contact_times() -> list[Extreme]:
    """Return cases with contact times from almost 0 to longer than a cycle, some with chatter, e = 0 or e = 1."""
    times = (1e-3, 1e-6, 1e-9, 7.0, 1e3)
    hybrid = Particle(2.0, 0.47, 0.1)
    cases = [
        Extreme(f"contact time {time:g}, hybrid", Design(ZETA, 1.0, 0.6, hybrid._replace(contact_time=time)))
        for time in times
    ]
    for name, restitution in (("e = 0", 0.0), ("chatter", 0.1), ("e = 1", 1.0)):
        particle = Particle(0.3, restitution, 0.1, 1e-9)
        cases.append(Extreme(f"contact time 1e-09, {name}", Design(ZETA, 0.9, 0.8, particle)))
    return cases


def _stiffnesses() -> list[Extreme]:
    """Return cases with compliant walls from soft to stiff, some with chatter, e near 0 or e = 1."""

    def walled(clearance: float, restitution: float, contact_time: float) -> Particle:
        wall = Wall(*wall_constants(restitution, contact_time, 0.1))
        return Particle(clearance, restitution, 0.1, None, wall)

    def stiff(clearance: float, restitution: float, stiffness: float) -> Particle:
        return walled(clearance, restitution, contact_time_of_stiffness(restitution, stiffness, 0.1))

    cases = [
        Extreme(f"contact stiffness {k:g} k, {name}", Design(ZETA, 1.0, friction, stiff(2.0, 0.47, k)))
        for k in (1e2, 1e4, 1e6, 1e8, 1e10, 1e12)
        for name, friction in (("particle", 0.0), ("hybrid", 0.6))
    ]
    cases += [
        Extreme(f"compliant, contact time {time:g}", Design(ZETA, 1.0, 0.6, walled(2.0, 0.47, time)))
        for time in (1e-3, 1e-6, 1e-9)
    ]
    cases += [
        Extreme(f"compliant 1e+08 k, {name}", Design(ZETA, 0.9, 0.8, stiff(0.3, e, 1e8)), 20)
        for name, e in (("chatter and stick", 0.1), ("e = 1e-3", 1e-3), ("e = 1", 1.0))
    ]
    return cases


def _grazing() -> list[Extreme]:
    """Return cases of grazing impacts: the clearance is almost equal to the largest displacement within ten cycles."""
    cycles = 10
    peak = simulate(Design(ZETA, 1.0, 0.6), cycles).metrics["amplitude_ratio_max"]
    return [
        Extreme(
            f"grazing impact, d/Z = peak{name}",
            Design(ZETA, 1.0, 0.6, Particle(clearance, 0.47, 0.1)),
            cycles,
        )
        for name, clearance in (
            (" (1 − 1e-6)", peak * (1.0 - 1e-6)),
            (" (1 − 1e-13)", peak * (1.0 - 1e-13)),
            ("", peak),
            (" (1 + 1e-13)", peak * (1.0 + 1e-13)),
        )
    ]


def _chatter_until_release() -> list[Extreme]:
    """Return two cases of a locked mass, in which a chatter and the release of the particle nearly coincide.

    In the first case, the chatter ends just before the release; in the second case, just after the release. The locked
    mass moves with the base. A larger e gives a longer chatter. Above a certain e, the particle is released before the
    chatter ends, which changes the number of attachments in the first half cycle. Bisection finds the two neighbouring
    values of e between which this number changes.
    """

    def attachments(restitution: float) -> int:
        design = Design(ZETA, 1.0, 10.0, Particle(0.4, restitution, 0.1))
        _end, _outcome, counts, _ = march_from_rest(
            design.damping_ratio, design.frequency_ratio, 10.0, design.particle, 1, None
        )
        return int(counts[ATTACHMENTS])

    low, high = 0.0, 0.9
    most = attachments(low)
    if attachments(high) == most:
        return []
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        if attachments(middle) == most:
            low = middle
        else:
            high = middle
    return [
        Extreme(
            f"chatter ending {side} release", Design(ZETA, 1.0, 10.0, Particle(0.4, restitution, 0.1)), 10
        )
        for side, restitution in (("just before", low), ("just after", high))
    ]


def _turn_with_impact() -> list[Extreme]:
    """Return cases in which a velocity reversal and an impact coincide within rounding.

    The clearance is the displacement of the mass at a reversal.
    """
    history = simulate(Design(ZETA, 1.0, 0.6), 2, history=2).history
    turns = np.flatnonzero((history["v_rate"] == 0.0) & (history["time"] > 0.0))
    if turns.size == 0:
        return []
    # The displacement at this reversal is the largest so far, so that no impact happens earlier.
    u = np.abs(history["u"])
    first = next((int(i) for i in turns if u[i] >= 0.999 * u[: i + 1].max() and u[i] > 0.1), int(turns[0]))
    clearance = float(u[first])
    return [
        Extreme(f"turn and impact at once{name}", Design(ZETA, 1.0, 0.6, Particle(value, 0.47, 0.1)), 10)
        for name, value in (
            ("", clearance),
            (", one bit less", float(np.nextafter(clearance, 0.0))),
            (", one bit more", float(np.nextafter(clearance, np.inf))),
        )
    ]
