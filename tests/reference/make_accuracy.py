"""Write `worker/accuracy/references.json`: end states of the scenes that methods are compared on, in 40 digits.

Run from the root of the repository: ``python -m tests.reference.make_accuracy``. A scene that is also a point of
`states.json` takes its record from there; others are computed, in minutes.
"""

import json
from pathlib import Path
from typing import Any

import mpmath
from tests.oracles.compliant_wall import Numbers, end_state
from tests.oracles.compliant_wall import Scene as Walls
from tests.reference.make import DIGITS, STATES, inputs, key, measure
from tests.reference.points import Point

import damperlab.worker.accuracy
from damperlab.worker.accuracy.cases import SCENES, Scene

_SHIFT = "1e-12"
TARGET = Path(damperlab.worker.accuracy.__file__).with_name("references.json")
HOW = (
    f"End states from rest after whole excitation cycles, {DIGITS} decimal digits, closed form between events; made by "
    "python -m tests.reference.make_accuracy with tests/reference/simulator.py, and between compliant walls with "
    "tests/oracles/compliant_wall.py (Taylor's method); neither shares code with the solver. Parameters are the binary "
    "doubles of worker/accuracy/cases.py. amplification: change of the end state per change of the start, as in "
    "tests/reference/states.json."
)


def point_of(scene: Scene) -> Point:
    """Return the scene as a point of the reference simulator; the name tells the computations apart, no more."""
    design = scene.design
    particle = None
    if design.particle is not None:
        one = design.particle
        particle = (one.clearance_ratio, one.restitution, one.mass_ratio)
    return Point(
        "", design.damping_ratio, design.frequency_ratio, design.friction_ratio, particle, scene.cycles
    )


def walled(scene: Scene) -> dict[str, Any]:
    """Compute a scene between compliant walls with the plain march in extended precision; its start moved for the change."""
    design = scene.design
    particle = design.particle
    assert particle is not None
    assert particle.wall is not None
    plain = Walls(
        design.damping_ratio,
        design.frequency_ratio,
        design.friction_ratio,
        particle.clearance_ratio,
        particle.mass_ratio,
        *particle.wall,
    )
    with mpmath.workdps(DIGITS):
        numbers = Numbers(mpmath.mpf, mpmath.sin, mpmath.cos, mpmath.pi, 26, 4 * DIGITS)
        state, _ = end_state(plain, scene.cycles, numbers)
        moved = []
        for index in range(4):
            shift = [mpmath.mpf(0)] * 4
            shift[index] = mpmath.mpf(_SHIFT)
            other, _ = end_state(plain, scene.cycles, numbers, shift)
            moved.append(max(abs(a - b) for a, b in zip(other, state, strict=True)) / shift[index])
        names = ("u", "u_rate", "p", "p_rate")
        digits = {name: mpmath.nstr(value, 25) for name, value in zip(names, state, strict=True)}
        return {"state": digits, "amplification": float(mpmath.nstr(max(moved), 3))}


def main() -> None:
    """Look up or compute every scene, and write the file."""
    known = {
        key(record | {"scene": ""}): record
        for record in json.loads(STATES.read_text(encoding="utf-8"))["points"]
    }
    scenes = {}
    for scene in SCENES:
        if scene.design.particle is not None and scene.design.particle.wall is not None:
            record = walled(scene)
        else:
            point = point_of(scene)
            record = known.get(key(inputs(point))) or measure(point)
        scenes[scene.name] = {"state": record["state"], "amplification": record["amplification"]}
        print(scene.name, json.dumps(scenes[scene.name]), flush=True)
    TARGET.write_text(json.dumps({"how": HOW, "scenes": scenes}, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
