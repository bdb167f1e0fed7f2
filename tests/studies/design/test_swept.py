"""A design under a sweep with the real solver, from a specification to words; and sweeps beside a band."""

import json
from typing import Any

import numpy as np
import pytest
from tests.studies.design.test_design import pursued
from tests.studies.design.test_records import peaks_m

from damperlab.service.design_report import design_report
from damperlab.studies.design.answer import answer_document
from damperlab.studies.design.found import Found

UP = {"start_hz": 2, "stop_hz": 3, "rate_hz_per_s": 0.25, "base_amplitude_m": 0.003}
DOWN = {"start_hz": 3, "stop_hz": 2, "rate_octaves_per_minute": 10, "base_amplitude_m": 0.003}
SWEPT: dict[str, Any] = {
    "structure": {"mass_kg": 40.0, "natural_frequency_hz": 2.5, "damping_ratio": 0.02},
    "excitation": {"sweep": UP},
    "choose": {"clearance_m": {"start": 0.004, "stop": 0.03}},
    "friction_force_n": 8.0,
    "particle_mass_kg": 4.0,
    "restitution": 0.5,
    "limits": {"acceleration_m_per_s2": 20},
}
BUDGET = 400


@pytest.fixture(scope="module")
def swept() -> Found:
    return pursued(SWEPT, BUDGET, front=False)[0]


def under_sweep_m(sweep: dict[str, Any], clearances_m: list[float], scale: float = 1.0) -> np.ndarray:
    return peaks_m({"records": [{"sweep": sweep}], "scales": scale}, clearances_m, 8.0).values.ravel()


def test_a_sweep_is_called_one_in_words_json_and_report(swept: Found) -> None:
    answer = answer_document(swept)
    called = "sweep from 2 to 3 Hz at 0.25 Hz/s"
    told = " ".join(answer["words"])
    assert "Swept" in told
    assert "record" not in told
    assert [each["record_name"] for each in (answer["worst"], *answer["cases"])] == [called] * 2
    assert answer["specification"]["excitation"] == {"sweep": UP, "scales": [1.0], "tail_s": 0.0}
    assert f"<td>{called}</td>" in design_report(swept)
    json.dumps(answer, allow_nan=False)


def test_a_run_down_beside_a_run_up_and_a_band() -> None:
    band = {"name": "running", "base_amplitude_m": 0.001, "frequency_hz": 2.2}
    document = {
        "excitation": [band, {"name": "up", "sweep": UP}, {"name": "down", "sweep": DOWN, "scales": 0.5}],
        "measure": "worst_relative_displacement",
        "limits": {"displacement_m": 1.0},
    }
    found, _ = pursued(SWEPT | document, BUDGET, front=False)
    clearance = [found.build.clearance_m]
    up, down = (each.value for each in found.under_records)
    assert up == pytest.approx(under_sweep_m(UP, clearance)[0], rel=1e-9)
    assert down == pytest.approx(under_sweep_m(DOWN, clearance, 0.5)[0], rel=1e-9)
    assert found.nominal.value == max(up, down, found.under[0].value)
    answer = answer_document(found)
    assert [each["excitation"] for each in answer["excitations"]] == ["running", "up", "down"]
    assert answer["worst"]["excitation"] == "up"
    assert design_report(found).count("Under each excitation") == 1


def test_every_draw_and_the_shock_is_a_case_and_the_worst_of_them_is_judged() -> None:
    random = {"frequency_hz": [1, 10], "psd_m2_per_s3": [0.2, 0.1], "duration_s": 15}
    shock = {"shape": "half_sine", "peak_g": 1, "duration_ms": 40}
    excitation = [
        {"name": "road", "random_vibration": random | {"seeds": 3}},
        {"name": "kerb", "shock": shock},
    ]
    found = pursued(SWEPT | {"excitation": excitation}, 120, front=False)[0]
    records = [{"random_vibration": random | {"seeds": 3}}, {"shock": shock}]
    alone = peaks_m({"records": records}, found.build.clearance_m, 8.0)
    cases = answer_document(found)["cases"]
    assert {each["record"]: each["value"] for each in cases} == pytest.approx(
        dict(zip(alone["record"].values.tolist(), alone.values.ravel().tolist(), strict=True)), rel=1e-9
    )
    assert found.nominal.value == pytest.approx(float(alone.max()), rel=1e-9)
    assert "Under each record" in design_report(found)
