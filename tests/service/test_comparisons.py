"""The tuned mass damper, follow-ups and work against precision over HTTP, on studies that the service computes."""

from typing import Any

import httpx
import numpy as np
import pytest
from tests.oracles import transmissibility, tuned_mass

STUDIES = "/api/v1/studies"

FRICTION: dict[str, Any] = {
    "name": "friction alone",
    "particle": False,
    "damping_ratio": 0.02,
    "axes": {
        "friction_ratio": {"start": 0.05, "stop": 1.05, "num": 11},
        "frequency_ratio": {"start": 0.8, "stop": 1.3, "num": 6},
    },
}


@pytest.fixture
def friction(service: Any, helpers: Any) -> dict[str, Any]:
    """The record of a finished study of friction alone."""
    with httpx.Client(base_url=service.url, timeout=300) as client:
        record: dict[str, Any] = client.post(STUDIES, json=FRICTION).raise_for_status().json()
        record = helpers.wait_for(client, record["id"], helpers.ended)
    assert record["state"] == "done"
    return record


def test_a_tuned_mass_damper_stands_beside_the_structure(client: httpx.Client, curve: dict[str, Any]) -> None:
    params = {"mass_ratio": "0.1", "criterion": "hinf"}
    answer = client.get(f"{STUDIES}/{curve['id']}/tmd-comparison", params=params).raise_for_status().json()
    r = np.array(answer["frequency_ratio"])
    tuning, damping, _ = tuned_mass.exact_optimum(0.1)
    np.testing.assert_allclose(
        answer["tmd"], tuned_mass.amplitude_ratio(r, 0.1, tuning, damping, 0.0038), rtol=1e-11
    )
    bare = [transmissibility.absolute_amplitude(0.0038, x) for x in r]
    np.testing.assert_allclose(answer["hybrid"], bare, rtol=1e-12)
    # both humps lie in the band 0.5 to 1.5
    peak = tuned_mass.peak(0.1, tuning, damping, 0.0038)
    assert answer["tmd_peak"] == pytest.approx(peak, rel=1e-11)
    assert answer["ratio"] == pytest.approx(max(bare) / peak, rel=1e-11)
    assert answer["columns"]["tmd"]["units"] == "1"
    assert "The masses differ" in answer["note"]


def _under_a_force(r: float, mass: float, tuning: float, damping: float, zeta: float) -> float:
    """|X| over the static deflection: both equations of motion, solved."""
    stiffness = mass * tuning * (tuning + 2j * damping * r)
    matrix = [[1.0 - r * r + 2j * zeta * r + stiffness, -stiffness], [-stiffness, stiffness - mass * r * r]]
    return float(abs(np.linalg.solve(matrix, [1.0, 0.0])[0]))


def test_a_tuned_mass_damper_under_a_force_answers_as_its_equations(
    client: httpx.Client, curve: dict[str, Any]
) -> None:
    params = {"mass_ratio": "0.1", "criterion": "hinf", "excitation": "force"}
    url = f"{STUDIES}/{curve['id']}/tmd-comparison"
    answer = client.get(url, params=params).raise_for_status().json()
    tuning, damping, _ = tuned_mass.exact_optimum(0.1)
    expected = [_under_a_force(r, 0.1, tuning, damping, 0.0038) for r in answer["frequency_ratio"]]
    np.testing.assert_allclose(answer["tmd"], expected, rtol=1e-11)
    refused = client.get(url, params=params | {"excitation": "wind"})
    assert refused.status_code == 422
    assert refused.json()["errors"][0]["field"] == "excitation"


def test_a_response_stands_beside_that_of_another_study(
    client: httpx.Client, curve: dict[str, Any], friction: dict[str, Any]
) -> None:
    url = f"{STUDIES}/{curve['id']}/frequency-response"
    answer = client.get(url, params={"with": curve["id"]}).raise_for_status().json()
    assert answer["studies"] == [curve["id"], curve["id"]]
    assert answer["other"] == answer["values"]
    assert (answer["apart"], sum(answer["differs"])) == ([], 0)
    others = client.get(url, params={"with": friction["id"]})
    assert others.status_code == 422
    assert (others.json()["errors"][0]["field"], "frequency_ratio" in others.text) == ("with", True)
    missing = client.get(url, params={"with": "0123456789ab"})
    assert missing.status_code == 404


def test_designs_outside_a_range_of_a_result_are_left_out(
    client: httpx.Client, friction: dict[str, Any]
) -> None:
    url = f"{STUDIES}/{friction['id']}/optimal-designs"
    every = client.get(url, params={"top": 100}).raise_for_status().json()["designs"]
    sliding = (
        client.get(url, params={"top": 100, "stick_fraction": "0,0.5"}).raise_for_status().json()["designs"]
    )
    assert 0 < len(sliding) < len(every)
    forces = [{design["friction_ratio"] for design in each} for each in (sliding, every)]
    assert forces[0] < forces[1]
    assert max(forces[0]) < max(forces[1])  # much friction is what sticks
    bad = client.get(url, params={"stick_fraction": "0.5,0"})
    assert bad.status_code == 422
    assert bad.json()["errors"][0]["field"] == "stick_fraction"


def test_a_ranking_without_an_objective_is_over_the_band(
    client: httpx.Client, friction: dict[str, Any]
) -> None:
    answer = client.get(f"{STUDIES}/{friction['id']}/optimal-designs").raise_for_status().json()
    assert (answer["objective"], answer["frequencies"]) == ("peak", 6)
    assert [entry["dimension"] for entry in answer["flatness"]] == ["friction_ratio"]


def test_a_follow_up_is_queued_run_and_ranked_with_its_study(
    client: httpx.Client, friction: dict[str, Any], helpers: Any
) -> None:
    address = f"{STUDIES}/{friction['id']}/refine"
    planned = client.post(address, params={"dry_run": "true"}).raise_for_status().json()
    assert not planned["known"]
    answer = client.post(address)
    assert answer.status_code == 201
    follow_up = answer.json()["follow_up"]
    assert answer.headers["location"] == f"{STUDIES}/{follow_up['id']}"
    follow_ups = answer.json()["follow_ups"]
    assert follow_ups[0] == follow_up
    points = sum(each["points_total"] for each in follow_ups)
    assert points == planned["points"] == answer.json()["points"]
    assert client.post(address).status_code == 200
    assert helpers.wait_for(client, follow_up["id"], helpers.ended)["state"] == "done"
    merged = (
        client.get(f"{STUDIES}/{friction['id']}/optimal-designs", params={"with": follow_up["id"]})
        .raise_for_status()
        .json()
    )
    alone = client.get(f"{STUDIES}/{friction['id']}/optimal-designs").raise_for_status().json()
    assert merged["designs"][0]["value"] <= alone["designs"][0]["value"]
    assert {design["study"] for design in merged["designs"]} <= {friction["id"], follow_up["id"]}
    further = (
        client.post(address, params={"with": follow_up["id"], "dry_run": "true"}).raise_for_status().json()
    )
    assert further["steps"]["friction_ratio"] < planned["steps"]["friction_ratio"]


def test_a_race_between_periodic_responses_is_over_before_it_starts(
    client: httpx.Client, friction: dict[str, Any]
) -> None:
    answer = client.post(f"{STUDIES}/{friction['id']}/race").raise_for_status().json()
    # periodic responses are known to rounding, so the first look decides
    assert answer["known"]
    assert answer["as_good"] == 0
    assert answer["chance_of_another"] == 0
    assert answer["spent"]["points"] == 66
    assert "follow_ups" not in answer
    assert answer["note"].startswith("With 95% confidence no design that was judged is better")
    refused = client.post(f"{STUDIES}/{friction['id']}/race", params={"confidence": "1"})
    assert refused.status_code == 422
    assert refused.json()["errors"][0]["field"] == "confidence"


def test_a_class_boundary_is_planned_and_a_line_without_one_is_refused(
    client: httpx.Client, friction: dict[str, Any], curve: dict[str, Any]
) -> None:
    params = {"along": "friction_ratio", "frequency_ratio": "0.9", "friction_ratio": "0.8", "dry_run": "true"}
    answer = (
        client.post(f"{STUDIES}/{friction['id']}/refine-boundary", params=params).raise_for_status().json()
    )
    low, high = answer["found"]["low"], answer["found"]["high"]
    # locked where the friction bears the largest inertia force, r²
    assert low < 0.81 < high
    assert answer["found"]["above"] == "locked"
    refused = client.post(f"{STUDIES}/{curve['id']}/refine-boundary", params={"along": "frequency_ratio"})
    assert refused.status_code == 422
    assert refused.json()["errors"][0]["field"] == "boundary"


def test_work_and_precision_of_every_point(client: httpx.Client, friction: dict[str, Any]) -> None:
    answer = client.get(f"{STUDIES}/{friction['id']}/work-precision").raise_for_status().json()
    assert answer["points"] == 66
    assert 0 < sum(answer["number"]) <= 66 - answer["points_failed"]
    assert len(answer["run_time"]) == len(answer["error_median"])
    assert answer["columns"]["run_time"]["units"] == "s"


def test_robust_friction_holds_over_a_range_of_amplitudes(
    client: httpx.Client, friction: dict[str, Any]
) -> None:
    params = {"amplitudes": "0.8,1.25", "top": "3"}
    answer = client.get(f"{STUDIES}/{friction['id']}/robust-designs", params=params).raise_for_status().json()
    values = [design["value"] for design in answer["designs"]]
    assert values == sorted(values)
    assert all(design["best_case"] <= design["value"] for design in answer["designs"])
    assert answer["amplitudes"][0] == pytest.approx(0.8)
