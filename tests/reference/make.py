"""Renew `states.json`: end states from rest in 40 digits, with how sensitive each is.

Run from the root of the repository: ``python -m tests.reference.make [--only SCENE]``.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

from tests.reference.numbers import ExtendedNumbers, Real
from tests.reference.points import Point, point_of
from tests.reference.simulator import simulate
from tests.reference.state import State

STATES = Path(__file__).with_name("states.json")
DIGITS = 40
NUDGE = ExtendedNumbers(DIGITS).convert("1e-12")
NAMES = ("u", "u_rate", "p", "p_rate")
INPUTS = Point._fields
COUNTS = ("impacts", "turns", "sticks", "attachments", "releases")
CHAOTIC = 1e8  # an error of one rounding then costs half of the digits of a double

HOW = (
    "States of the model after whole excitation cycles from rest in the absolute frame, computed in "
    f"{DIGITS} decimal digits by tests/reference/simulator.py (instantaneous contact); made by "
    "python -m tests.reference.make. Parameters are the binary doubles printed. Impacts, and the turns and "
    "sticks that they cause on a stuck mass, are counted until a chatter's rebound is below 1e-15; the other "
    "counts do not depend on that. amplification: largest change of the end state (maximum norm) per change "
    "of u, u' or p by 1e-12 at the start or half way. chaotic: amplification above 1e8."
)


def distance(one: dict[str, Any], other: dict[str, Any]) -> Real:
    """Return the maximum norm of the difference of two end states."""
    return max(abs(one[name] - other[name]) for name in NAMES)


def nudged(state: State, attached: bool, has_particle: bool) -> list[State]:
    """Return the state with u, u', and, for a free particle, p moved by `NUDGE`."""
    moves = [
        replace(state, v=state.v + NUDGE, gap=state.gap + (0 if attached else NUDGE)),
        replace(state, v_rate=state.v_rate + NUDGE),
    ]
    if has_particle and not attached:
        moves.append(replace(state, gap=state.gap - NUDGE))
    return moves


def measure(point: Point) -> dict[str, Any]:
    """Return the record of one design point."""
    numbers = ExtendedNumbers(DIGITS)
    scene = (point.damping_ratio, point.frequency_ratio, point.friction_ratio, point.particle)
    truth = simulate(*scene, cycles=point.cycles, digits=DIGITS)
    zero = numbers.convert(0)
    rest = State(zero, zero, -numbers.convert(point.frequency_ratio), zero, zero)
    half = point.cycles // 2
    half_way = simulate(*scene, cycles=half, digits=DIGITS)["end"]
    worst = zero
    for start, cycles in ((rest, point.cycles), (half_way, point.cycles - half)):
        for state in nudged(start, bool(start.wall), point.particle is not None):
            other = simulate(*scene, cycles=cycles, digits=DIGITS, start=state)
            worst = max(worst, distance(truth, other) / NUDGE)
    record = inputs(point)
    record["state"] = {name: numbers.text(truth[name]) for name in NAMES}
    record["events"] = {name: truth[name] for name in COUNTS}
    record["amplification"] = float(f"{float(worst):.3g}")
    record["chaotic"] = bool(worst > CHAOTIC)
    return record


def key(record: dict[str, Any]) -> str:
    """Return what identifies a record: its scene, parameters and cycles."""
    return json.dumps([value for name, value in record.items() if name in INPUTS])


def inputs(point: Point) -> dict[str, Any]:
    """Return the part of a record that says what was asked."""
    names = ("clearance_ratio", "restitution", "mass_ratio")
    asked = point._asdict()
    asked["particle"] = point.particle and dict(zip(names, point.particle, strict=True))
    return asked


def main() -> None:
    """Compute every record of the file, or those of one scene, anew: a new one holds a point alone."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", help="compute the points of this scene; keep the other records")
    only = parser.parse_args().only
    records = []
    for record in json.loads(STATES.read_text())["points"]:
        begun = time.perf_counter()
        records.append(measure(point_of(record)) if only in (None, record["scene"]) else record)
        print(f"{time.perf_counter() - begun:6.1f} s", json.dumps(records[-1]), flush=True)
    rows = ",\n".join(map(json.dumps, records))
    STATES.write_text(f'{{"how": {json.dumps(HOW)},\n"points": [\n{rows}\n]}}\n')


if __name__ == "__main__":
    main()
