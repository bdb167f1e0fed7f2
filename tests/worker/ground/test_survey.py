"""Surveys over records, scales and designs, and the spread over perturbed starts."""

from pathlib import Path

import numpy as np
import pytest

from studies.faults import StudyFaults
from studies.ground.builtin import builtin_record
from studies.ground.shelf import Shelf
from studies.ground.survey import AXES, read_survey
from worker.ground.comparison import CHAOTIC, spread, table_a1
from worker.ground.design import Damper, Structure
from worker.ground.response import ground_response
from worker.ground.survey import best_designs, run_survey

ASKED = {
    "records": ["northridge", "northridge-360"],
    "scale": [1, 3],
    "natural_frequency_hz": [1.5, 2.5],
    "clearance_m": {"start": 0.001, "stop": 0.004, "num": 3},
    "friction_force_n": [0.05, 0.2],
}


def test_a_survey_holds_what_single_runs_give(tmp_path: Path) -> None:
    survey = read_survey(ASKED, Shelf(tmp_path))
    seen: list[tuple[int, int]] = []
    answer = run_survey(survey, lambda done, points: seen.append((done, points)), threads=2)
    assert answer["status"].dims == ("record", *AXES)
    assert answer["status"].shape == (2, 2, 2, 1, 1, 1, 3, 2)
    assert seen[-1] == (48, 48)
    assert answer["peak_relative_displacement_m"].attrs["units"] == "m"
    assert answer["peak_absolute_acceleration_m_s2"].attrs["units"] == "m s-2"
    one = answer.sel(
        record="northridge-360", scale=3, natural_frequency_hz=1.5, clearance_m=0.0025, friction_force_n=0.2
    ).squeeze()
    alone = ground_response(
        Structure(1.605, 1.5, 0.0038), Damper(0.2, 0.1605, 0.0025), builtin_record("northridge-360"), 3.0
    )
    for name, value in alone.values().items():
        assert float(one[name]) == value, name
    assert float(answer["energy_residual"].max()) < 1e-9
    serial = run_survey(survey, threads=1)
    assert serial.equals(answer)


def test_the_best_design_is_the_least_worst_case(tmp_path: Path) -> None:
    answer = run_survey(read_survey(ASKED, Shelf(tmp_path)))
    best = best_designs(answer, top=2)
    worst = answer["peak_relative_displacement_m"].max(
        ("record", "scale", "natural_frequency_hz", "damping_ratio")
    )
    assert float(best["worst"][0]) == float(worst.min())
    chosen = worst.sel(clearance_m=best["clearance_m"][0], friction_force_n=best["friction_force_n"][0])
    assert float(chosen.squeeze()) == float(best["worst"][0])
    assert float(best["worst"][1]) >= float(best["worst"][0])


def test_scaled_with_its_design_a_survey_repeats(tmp_path: Path) -> None:
    """The point of scale 3 with three times the clearance and the force is the point of scale 1, three times as large."""
    asked = {
        "records": "el-centro",
        "scale": [1, 3],
        "clearance_m": [0.005, 0.015],
        "friction_force_n": [0.3, 0.9],
    }
    answer = run_survey(read_survey(asked, Shelf(tmp_path)))["peak_relative_displacement_m"].squeeze()
    one = float(answer.sel(scale=1, clearance_m=0.005, friction_force_n=0.3))
    three = float(answer.sel(scale=3, clearance_m=0.015, friction_force_n=0.9))
    assert three == pytest.approx(3 * one, rel=1e-12)


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"records": []}, "records"),
        ({"records": ["loma-prieta", "loma-prieta-000"]}, "records[1]"),
        ({"records": ["nowhere"]}, "records[0]"),
        ({"scale": [1, -1]}, "scale[1]"),
        ({"clearance": 1}, "clearance"),
        ({"mass_kg": 0}, "mass_kg"),
        ({"clearance_m": {"start": 0.001, "stop": 1, "num": 900_000}, "scale": [1, 2]}, "survey"),
        ({"natural_frequency_hz": 1000}, "natural_frequency_hz"),
    ],
)
def test_bad_surveys_are_refused(tmp_path: Path, change: dict[str, object], field: str) -> None:
    with pytest.raises(StudyFaults) as caught:
        read_survey({"records": ["loma-prieta"], **change}, Shelf(tmp_path))
    assert field in [fault.field for fault in caught.value.faults]


def test_spread_is_small_without_a_particle_and_large_in_chaos() -> None:
    motion = builtin_record("el-centro-180")
    structure = Structure()
    still, rattling = Damper(0.41), Damper(0.0, 0.1605, 0.0075)
    calm = spread(structure, still, motion, ground_response(structure, still, motion), starts=4)
    wild = spread(structure, rattling, motion, ground_response(structure, rattling, motion), starts=4)
    # friction contracts: no two of its motions part (the equation is monotone)
    assert calm["growth"] <= 1.0 + 1e-6
    assert not calm["sensitive"]
    assert wild["growth"] > CHAOTIC
    peak = wild["peak_relative_displacement_m"]
    assert peak["lowest"] <= peak["mean"] <= peak["highest"]
    again = spread(structure, rattling, motion, ground_response(structure, rattling, motion), starts=4)
    assert again == wild


def test_table_a1_says_the_paper_and_ours_side_by_side() -> None:
    table = table_a1(builtin_record("loma-prieta-000"), starts=1)
    rows = table["rows"]
    assert {row["damper"] for row in rows} == {"none", "tmd", "pid", "fd", "hybrid"}
    none = rows[0]
    assert (none["paper_peak_m"], none["paper_rms_m"]) == (0.1671, 0.0335)
    assert none["peak_share"] == none["rms_share"] == 1.0
    for row in rows:
        assert row["peak_share"] == pytest.approx(row["peak_m"] / none["peak_m"], rel=1e-15)
        assert row["energy_residual"] < 1e-9
        assert row["status"] == 0
    assert np.ptp([row["peak_m"] for row in rows if row["damper"] == "hybrid"]) > 0
