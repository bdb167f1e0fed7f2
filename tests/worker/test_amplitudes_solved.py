"""A damper over base amplitudes has at every point the bits of the point alone."""

import json
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.studies.solving import LEAN
from tests.worker.forms import night

from damperlab.studies.definition import Study, parse_study
from damperlab.studies.plan import Block, make_plan
from damperlab.studies.store.export.export import columns
from damperlab.studies.units import ratios_beside
from damperlab.worker.block import solve_block
from damperlab.worker.dispatch.cost_model import seconds_per_point
from damperlab.worker.scenes import scenes

STRUCTURE = {"mass_kg": 1.605, "natural_frequency_hz": 2.5}
AMPLITUDES, CLEARANCES, FORCES, HERTZ = [0.0007, 0.002, 0.0045], [0.0075, 0.02], [0.1, 0.33], [2.3, 2.6]
STEADY = {"max_cycles": 300}


def study_of(physical: dict[str, Any], **more: Any) -> Study:
    study = parse_study({"physical": STRUCTURE | physical, "steady": STEADY, **more})
    assert isinstance(study, Study)
    return study


def solve(study: Study) -> dict[str, np.ndarray]:
    return solve_block(study, Block.whole(study.shape))


RAY = {
    "base_amplitude_m": AMPLITUDES,
    "clearance_m": CLEARANCES,
    "friction_force_n": FORCES,
    "excitation_frequency_hz": HERTZ,
}


@pytest.mark.parametrize(
    ("word", "order", "cavity"),
    [
        (None, 0, {}),
        ("velocity", 1, {}),
        ("acceleration", 2, {}),
        ("acceleration", 2, {"particle_friction_coefficient": 0.02}),
        night("acceleration", 2, {"particle_friction_coefficient": 0.02, "tilt_deg": 5}),
    ],
)
def test_each_point_has_the_bits_of_the_point_alone(
    word: str | None, order: int, cavity: dict[str, float]
) -> None:
    """Under the displacement that the base has at its frequency."""
    given = {"clearance_m": CLEARANCES, "friction_force_n": FORCES[:1], "excitation_frequency_hz": HERTZ}
    given |= cavity
    constant = {} if word is None else {"constant": word}
    lean = {"metrics": LEAN} if cavity else {}
    held = study_of(given | constant | {"base_amplitude_m": AMPLITUDES[1:]}, **lean)
    found = solve(held)
    for place in np.ndindex(*held.shape):
        c, _, a, r = place[3:]
        at = {
            "clearance_m": CLEARANCES[c],
            "friction_force_n": FORCES[0],
            "excitation_frequency_hz": HERTZ[r],
            **cavity,
        }
        ratio = HERTZ[r] / STRUCTURE["natural_frequency_hz"]
        alone = solve(study_of(at | {"base_amplitude_m": AMPLITUDES[1:][a] / ratio**order}, **lean))
        for name, values in found.items():
            if name != "run_time":
                assert values[place].tobytes() == alone[name].reshape(-1)[0].tobytes(), (name, place)


def test_blocks_cover_its_grid_and_need_the_kernels_of_its_scene() -> None:
    ray = study_of(RAY)
    plan = make_plan(ray, seconds_per_point)
    assert sum(plan.block(index).points for index in range(plan.count)) == 24
    assert plan.seconds > 0
    assert [scene.name for scene in scenes(ray)] == ["steady-friction-particle-instant"]
    free = study_of(
        {"base_amplitude_m": AMPLITUDES, "clearance_m": CLEARANCES, "excitation_frequency_hz": 2.5}
    )
    assert [scene.name for scene in scenes(free)] == ["steady-particle-instant"]


def test_the_ratios_of_a_cavity_stand_beside_those_of_the_damper() -> None:
    cavity = {"particle_friction_coefficient": 0.02, "tilt_deg": 5}
    study = study_of({**RAY, "constant": "acceleration", **cavity})
    cube = xr.Dataset(
        {"status": (tuple(study.coordinates), np.zeros(study.shape, "i1"))},
        study.coordinates,
        {"study": json.dumps(study.document())},
    )
    cube = cube.assign_coords(ratios_beside(cube))
    (piece,) = columns(cube)
    z, r = piece["base_amplitude_m"] / piece["frequency_ratio"] ** 2, 2 * np.pi * 2.5
    weight = 9.80665 / (r * r * z)
    assert piece["particle_friction_ratio"] == pytest.approx(0.02 * np.cos(np.radians(5)) * weight, rel=1e-14)
    assert piece["gravity_ratio"] == pytest.approx(np.sin(np.radians(5)) * weight, rel=1e-14)
