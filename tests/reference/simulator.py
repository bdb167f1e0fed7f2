"""Event-driven reference simulator of the hybrid damper, in as many digits as wanted.

It shares no code with the solver under test. Between events the state is the exact closed form
(`tests.reference.motion`); events are found by a dense scan that isolates extrema first
(`tests.reference.roots`). Slow and plain on purpose.

The model, dimensionless: v'' + 2 zeta v' + v + gamma Sgn(v') = r^2 sin(r tau), u = v + sin(r tau), p'' = 0,
|u - p| <= delta, with Newton's impact law (restitution e, mass ratio beta) at the walls. A force on the structure has
sin(r tau) on the right, and u = v.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from tests.reference.march import Simulation
from tests.reference.numbers import DoubleNumbers, ExtendedNumbers, Numbers
from tests.reference.observers import AccelerationObserver, Observer, PeakObserver
from tests.reference.state import State


def simulate(
    zeta: object,
    r: object,
    gamma: object,
    particle: tuple[Any, Any, Any] | None = None,
    cycles: int = 10,
    *,
    digits: int | None = 40,
    start: State | None = None,
    peaks: bool = False,
    acceleration: bool = False,
    forced: bool = False,
) -> dict[str, Any]:
    """Simulate the hybrid damper from rest and return its state after whole excitation cycles.

    Parameters
    ----------
    zeta, r, gamma
        Damping, frequency and friction ratio. Floats are taken as the binary number that they hold.
    particle
        (clearance ratio delta, restitution e, mass ratio beta), or None.
    cycles
        Number of excitation periods 2 pi / r.
    digits
        Decimal digits of the arithmetic; None for double precision.
    start
        State at phase 0 to go on from (the result's ``end``); None for rest in the absolute frame.
    peaks
        Also return ``peaks``: the true extrema (max |u|, max |v|) of every cycle.
    forced
        A force F0 sin(r tau) on the structure instead of a shaken base; lengths are over F0/k.
    acceleration
        Also return ``acceleration_peak``, the largest |u''| between events, and ``acceleration_square``, its integral squared.

    Returns
    -------
    dict
        ``u, u_rate, p, p_rate`` (absolute, dimensionless; p = p' = 0 without a particle), ``impacts, turns,
        sticks, attachments, releases`` (counts; a turn is v' = 0 in a scene with friction, whether the mass
        sticks or not; in a chatter, impacts, and the turns that they cause, are counted until it is cut),
        ``stuck_time``, ``end`` (a `State`).
    """
    numbers: Numbers = DoubleNumbers() if digits is None else ExtendedNumbers(digits)
    seen_peaks, seen_acceleration = PeakObserver(numbers), AccelerationObserver(numbers)
    observers: tuple[Observer, ...] = (seen_peaks,) * peaks + (seen_acceleration,) * acceleration
    run = Simulation(numbers, zeta, r, gamma, particle, observers, forced)
    if start is not None:
        convert = numbers.convert
        run.state = replace(
            start,
            time=run.zero,
            v=convert(start.v),
            v_rate=convert(start.v_rate),
            gap=convert(start.gap),
            p_rate=convert(start.p_rate),
        )
    for _ in range(cycles):
        run.run_cycle()
    u, u_rate, p, p_rate = run.absolute()
    result: dict[str, Any] = {
        "u": u,
        "u_rate": u_rate,
        "p": p,
        "p_rate": p_rate,
        "impacts": run.impacts,
        "turns": run.turns,
        "sticks": run.sticks,
        "attachments": run.attachments,
        "releases": run.releases,
        "stuck_time": run.stuck_time,
        "end": replace(run.state),
    }
    if peaks:
        result["peaks"] = seen_peaks.cycles
    if acceleration:
        result |= {
            "acceleration_peak": seen_acceleration.peak,
            "acceleration_square": seen_acceleration.square,
        }
    return result
