"""Ground motions over HTTP: records, spectra, comparisons of dampers, and suites, which are studies like any other."""

from typing import Any

import httpx
import numpy as np
import pytest
from tests.service.conftest import ended, wait_for

from damperlab.studies.ground.motion import GroundMotion
from damperlab.worker.ground.response_spectrum import response_spectrum

RECORDS = "/api/v1/records"
COMPARE = "/api/v1/earthquake-comparisons"
# samples that no other test and no example puts up: the same ones would be known already
COLUMNS = "time (s), acceleration (g)\n0, 0\n0.01, 0.1\n0.02, -0.06\n0.03, 0\n"


def test_a_record_goes_up_and_is_used(client: httpx.Client) -> None:
    table = {"content-type": "text/csv"}
    answer = client.post(RECORDS, content=COLUMNS, headers=table, params={"name": "mine"})
    assert answer.status_code == 201
    record_id = answer.json()["id"]
    assert answer.json()["peak_acceleration_g"] == pytest.approx(0.1, rel=1e-12)
    again = client.post(RECORDS, content=COLUMNS, headers=table)
    assert (again.status_code, again.json()["id"]) == (200, record_id)
    listed = {one["id"]: one for one in client.get(RECORDS).json()["records"]}
    assert {record_id, "el-centro-180", "northridge-090", "san-fernando-164"} <= set(listed)
    loma = listed["loma-prieta-000"]
    assert (loma["step_s"], loma["samples"]) == (0.005, 7997)
    assert loma["peak_acceleration_m_s2"] == pytest.approx(9.80665 * loma["peak_acceleration_g"], rel=1e-12)
    found = client.post(COMPARE, json={"record": record_id, "cases": ["none", "tmd"], "tail_s": 1.0})
    assert found.raise_for_status().json()["cases"]["none"]["peak_relative_displacement_m"] > 0.0


def test_a_record_is_generated_from_what_describes_it(client: httpx.Client) -> None:
    """Every kind of description is read in `tests/studies/ground`."""
    recipe = {"shock": {"shape": "trapezoid", "peak_g": 2, "duration_ms": 20}}
    made = client.post(RECORDS, json=recipe)
    assert made.status_code == 201
    assert client.post(RECORDS, json=recipe).json()["id"] == made.json()["id"]


@pytest.mark.parametrize(
    ("body", "kind", "units", "refused"),
    [
        ("0 0\n" * 2_000_000, "text/csv", "g", (413, "body")),
        ("x", "image/png", "g", (415, "Content-Type")),
        ('{"seed": 1}', "application/json", "g", (422, "seed")),
        (COLUMNS, "text/csv", "furlong", (422, "units")),
        (COLUMNS.replace("-0.06", "five"), "text/csv", "g", (422, "line 4")),
    ],
)
def test_uploads_are_bounded_and_typed(
    client: httpx.Client, body: str, kind: str, units: str, refused: tuple[int, str]
) -> None:
    answer = client.post(RECORDS, content=body, headers={"content-type": kind}, params={"units": units})
    assert refused in [(answer.status_code, each["field"]) for each in answer.json()["errors"]], answer.text


def test_the_histories_of_a_comparison_have_its_peaks(client: httpx.Client) -> None:
    asked = {"record": "northridge-360", "cases": ["none", "tmd", "hybrid"], "starts": 0, "tail_s": 2.0}
    plain = client.post(COMPARE, json=asked).raise_for_status().json()
    assert "histories" not in plain
    whole = client.post(COMPARE, json=asked, params={"samples": 50_000}).raise_for_status().json()
    assert whole["cases"] == plain["cases"]
    few = client.post(COMPARE, json=asked, params={"samples": 300}).raise_for_status().json()
    assert list(whole["histories"]) == ["none", "tmd", "hybrid"]
    for case, history in whole["histories"].items():
        time, x = history["time_s"], history["relative_displacement_m"]
        assert not history["thinned"]
        assert len(time) == len(x)
        assert time[-1] == pytest.approx(plain["record"]["duration_s"] + 2.0, abs=0.02)
        # a window turns the motion by at most 0.4, so between two samples it rises by less than 1 - cos 0.2 = 2 %
        largest = max(map(abs, x))
        peak = plain["cases"][case]["peak_relative_displacement_m"]
        assert 0.98 * peak <= largest <= peak * (1 + 1e-12)
        thin = few["histories"][case]
        assert thin["thinned"]
        assert len(thin["time_s"]) <= 300
        assert max(map(abs, thin["relative_displacement_m"])) == largest
        assert set(zip(thin["time_s"], thin["relative_displacement_m"], strict=True)) <= set(
            zip(time, x, strict=True)
        )
    assert all(value is None for value in whole["histories"]["none"]["particle_displacement_m"])
    assert client.post(COMPARE, json=asked, params={"samples": 50_001}).status_code == 422


def test_a_record_is_shown_with_its_spectrum(client: httpx.Client) -> None:
    whole = client.get("/api/v1/records/northridge", params={"samples": 400_000}).raise_for_status().json()
    assert len(whole["time_s"]) == whole["samples"]
    assert np.abs(whole["acceleration_m_s2"]).max() == pytest.approx(whole["peak_acceleration_m_s2"])
    thin = client.get(f"/api/v1/records/{whole['id']}", params={"samples": 50}).raise_for_status().json()
    assert len(thin["time_s"]) <= 50
    for end in (min, max):
        assert end(thin["acceleration_m_s2"]) == end(whole["acceleration_m_s2"])
    motion = GroundMotion("shown", whole["step_s"], np.array(whole["acceleration_m_s2"]))
    spectrum = response_spectrum(motion, np.array(whole["period_s"]), whole["damping_ratio"])
    for shown in (whole, thin):
        np.testing.assert_allclose(
            shown["pseudo_acceleration_m_s2"], spectrum.pseudo_acceleration_m_s2, rtol=1e-12
        )


def test_a_record_that_is_not_there_is_not_shown(client: httpx.Client) -> None:
    assert client.get("/api/v1/records/nowhere").status_code == 404
    assert client.get("/api/v1/records/northridge", params={"samples": 1}).status_code == 422


STUDIES = "/api/v1/studies"
SAMPLES = "time (s), acceleration (g)\n" + "".join(f"{0.02 * i:.2f}, {(-1) ** i * 0.1}\n" for i in range(60))


def test_it_is_kept_once_and_says_what_it_is(client: httpx.Client, suite: dict[str, Any]) -> None:
    assert suite["shape"] == [2, 1, 1, 2, 1, 1, 3, 2]
    assert [one["id"] for one in suite["definition"]["records"]] == ["northridge-090", "northridge-360"]
    # its own definition is the same study again, and so is what it was made of
    again = client.post(STUDIES, json=suite["definition"])
    assert (again.status_code, again.json()["id"]) == (200, suite["id"])
    estimate = client.post(f"{STUDIES}?dry_run=true", json=suite["definition"]).json()
    assert estimate["points"] == 24
    assert 0 < estimate["seconds"] < 10
    assert "event: end" in client.get(f"{STUDIES}/{suite['id']}/events").text
    axes = client.get(f"{STUDIES}/{suite['id']}/axes").json()["axes"]
    assert axes["record"] == ["northridge-090", "northridge-360"]


def test_an_uploaded_record_stays_with_its_study(service: Any, client: httpx.Client) -> None:
    headers = {"content-type": "text/csv"}
    record_id = client.post("/api/v1/records", content=SAMPLES, headers=headers).json()["id"]
    asked = {"name": "mine", "records": [record_id], "axes": {"scale": [1, 2]}}
    first = client.post(STUDIES, json=asked).raise_for_status().json()
    kept = wait_for(client, first["id"], ended)
    assert (kept["state"], kept["points_done"]) == ("done", 2)
    files = list((service.log.parent / "data" / "records").glob(f"{record_id}.*"))
    assert len(files) == 2
    for file in files:
        file.unlink()
    refused = client.post(STUDIES, json={**asked, "axes": {"scale": 5}})
    assert (refused.status_code, refused.json()["errors"][0]["field"]) == (422, "records[0]")
    assert client.get(f"{STUDIES}/{kept['id']}/optimal-designs").status_code == 200
