"""Write `worker/accuracy/references.json`: end states of the scenes that methods are compared on, in 40 digits.

Run from the root of the repository: ``python -m tests.reference.make_accuracy``. A scene that is also a point of
`states.json` takes its record from there; others are computed, in minutes.
"""

import json
from pathlib import Path

import worker.accuracy
from tests.reference.make import DIGITS, STATES, inputs, key, measure
from tests.reference.points import Point
from worker.accuracy.scenes import SCENES, Scene

TARGET = Path(worker.accuracy.__file__).with_name("references.json")
HOW = (
    f"End states from rest after whole excitation cycles, {DIGITS} decimal digits, closed form between events; made by "
    "python -m tests.reference.make_accuracy with tests/reference/simulator.py, which shares no code with the solver. "
    "Parameters are the binary doubles of worker/accuracy/scenes.py. amplification: change of the end state per "
    "change of the start, as in tests/reference/states.json."
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


def main() -> None:
    """Look up or compute every scene, and write the file."""
    known = {
        key(record | {"scene": ""}): record
        for record in json.loads(STATES.read_text(encoding="utf-8"))["points"]
    }
    scenes = {}
    for scene in SCENES:
        point = point_of(scene)
        record = known.get(key(inputs(point))) or measure(point)
        scenes[scene.name] = {"state": record["state"], "amplification": record["amplification"]}
        print(scene.name, json.dumps(scenes[scene.name]), flush=True)
    TARGET.write_text(json.dumps({"how": HOW, "scenes": scenes}, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
