"""Maps, curves, rankings, exports and simulations over HTTP, against the closed form of the structure alone."""

import csv
import io
from math import sqrt
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
import xarray as xr

from damperlab import Client
from damperlab.studies.variables import DIMENSIONS

STUDIES = "/api/v1/studies"


def _closed_form(zeta: float, r: float) -> float:
    """X/Z of the structure alone, shaken through its base."""
    return sqrt((1 + (2 * zeta * r) ** 2) / ((1 - r * r) ** 2 + (2 * zeta * r) ** 2))


def test_frequency_response_is_the_closed_form(client: httpx.Client, curve: dict[str, Any]) -> None:
    answer = client.get(f"{STUDIES}/{curve['id']}/frequency-response").raise_for_status().json()
    assert (answer["units"], answer["complete"]) == ("1", 1.0)
    expected = [_closed_form(0.0038, r) for r in answer["frequency_ratio"]]
    # Both are a few roundings of the same formula, magnified at resonance by 1/(2 zeta) = 132.
    np.testing.assert_allclose(answer["values"], expected, rtol=1e-12)


def test_map_has_a_row_for_each_y_and_a_column_for_each_x(
    client: httpx.Client, curve: dict[str, Any]
) -> None:
    params = {"x": "frequency_ratio", "y": "damping_ratio"}
    answer = client.get(f"{STUDIES}/{curve['id']}/resonance-map", params=params).raise_for_status().json()
    assert (len(answer["x"]), len(answer["y"])) == (11, 1)
    assert np.shape(answer["values"]) == (1, 11)
    assert answer["meanings"]["status"]["0"] == "converged"


def test_nearest_grid_point_is_taken_and_said(client: httpx.Client, curve: dict[str, Any]) -> None:
    params = {"x": "friction_ratio", "y": "damping_ratio", "frequency_ratio": "0.97"}
    answer = client.get(f"{STUDIES}/{curve['id']}/resonance-map", params=params).raise_for_status().json()
    assert answer["at"]["frequency_ratio"] == 1.0
    assert "nearest to the 0.97 asked for" in answer["note"]
    assert answer["values"][0][0] == pytest.approx(_closed_form(0.0038, 1.0), rel=1e-12)


def test_map_reduced_over_frequency_holds_the_peak(client: httpx.Client, curve: dict[str, Any]) -> None:
    params = {"x": "friction_ratio", "y": "damping_ratio", "over": "frequency_ratio", "reduce": "max"}
    answer = client.get(f"{STUDIES}/{curve['id']}/resonance-map", params=params).raise_for_status().json()
    assert answer["values"][0][0] == pytest.approx(_closed_form(0.0038, 1.0), rel=1e-12)
    assert answer["frequency_ratio_at"] == [[1.0]]


@pytest.mark.parametrize("constant", ["velocity", "acceleration"])
def test_a_tuned_mass_damper_is_compared_where_the_base_amplitude_falls_with_the_frequency(
    client: httpx.Client, helpers: Any, constant: str
) -> None:
    study = {
        "particle": False,
        "damping_ratio": 0.05,
        "physical": {
            "mass_kg": 2.0,
            "natural_frequency_hz": 4.0,
            "base_amplitude_m": [0.002, 0.003],
            "constant": constant,
            "friction_force_n": [0.0, 0.1],
            "excitation_frequency_hz": [3.6, 4.0, 4.4],
        },
    }
    record = client.post(STUDIES, json=study).raise_for_status().json()
    helpers.wait_for(client, record["id"], helpers.ended)
    asked = {"friction_force_n": 0.0, "base_amplitude_m": 0.003, "mass_ratio": 0.05}
    answer = client.get(f"{STUDIES}/{record['id']}/tmd-comparison", params=asked).raise_for_status().json()
    np.testing.assert_allclose(
        answer["hybrid"], [_closed_form(0.05, f / 4.0) for f in (3.6, 4.0, 4.4)], rtol=1e-12
    )
    assert f"The {constant} of the base is the same at every frequency" in answer["note"]
    unnamed = client.get(f"{STUDIES}/{record['id']}/tmd-comparison", params={"friction_force_n": 0.0})
    assert unnamed.status_code == 422
    with Client(str(client.base_url)) as damperlab:
        found = damperlab.study(record["id"]).tmd_comparison(
            mass_ratio=0.05, friction_force_n=0.0, base_amplitude_m=0.003
        )
        np.testing.assert_array_equal(found["hybrid"], answer["hybrid"])


def test_a_study_in_units_is_asked_and_exported_in_units(client: httpx.Client, helpers: Any) -> None:
    hertz = [3.6, 4.0, 4.4]
    study = {
        "particle": False,
        "damping_ratio": 0.05,
        "axes": {"friction_ratio": 0.0},
        "physical": {
            "mass_kg": 2.0,
            "natural_frequency_hz": 4.0,
            "base_amplitude_m": 0.003,
            "excitation_frequency_hz": hertz,
        },
    }
    record = client.post(STUDIES, json=study).raise_for_status().json()
    helpers.wait_for(client, record["id"], helpers.ended)
    asked = {"x": "frequency_hz", "y": "friction_force_n"}
    answer = client.get(f"{STUDIES}/{record['id']}/resonance-map", params=asked).raise_for_status().json()
    assert (answer["x_dimension"], answer["columns"]["frequency_hz"]["units"]) == ("frequency_hz", "Hz")
    np.testing.assert_allclose(answer["x"], hertz, rtol=1e-15)
    # the name that the study's physical block has for it
    paths = (
        f"{STUDIES}/{record['id']}/optimal-designs?{name}=3.9,4.1"
        for name in ("frequency_hz", "excitation_frequency_hz")
    )
    one, other = (client.get(path).raise_for_status().json() for path in paths)
    assert one == other
    truth = [_closed_form(0.05, f / 4.0) for f in hertz]
    np.testing.assert_allclose(answer["values"][0], truth, rtol=1e-12)
    exported = client.get(f"{STUDIES}/{record['id']}/export", params={"format": "csv"}).raise_for_status()
    rows = list(csv.DictReader(io.StringIO(exported.text)))
    np.testing.assert_allclose([float(row["frequency_hz"]) for row in rows], hertz, rtol=1e-15)
    np.testing.assert_allclose(
        [float(row["amplitude_m"]) for row in rows], 0.003 * np.array(truth), rtol=1e-12
    )
    with Client(str(client.base_url)) as damperlab:
        cube = damperlab.study(record["id"]).cube()
        assert cube["frequency_hz"].dims == ("frequency_ratio",)
        np.testing.assert_allclose(cube["amplitude_m"].values.ravel(), 0.003 * np.array(truth), rtol=1e-12)


def test_ranking_is_in_the_order_of_the_response(client: httpx.Client, helpers: Any) -> None:
    study = {
        "particle": False,
        "damping_ratio": [0.02, 0.05, 0.1],
        "axes": {"frequency_ratio": [0.9, 1.0, 1.1]},
    }
    record = client.post(STUDIES, json=study).raise_for_status().json()
    helpers.wait_for(client, record["id"], helpers.ended)
    params = {"objective": "peak", "band": "0.95,1.05", "damping_ratio": "0,0.06"}
    answer = client.get(f"{STUDIES}/{record['id']}/optimal-designs", params=params).raise_for_status().json()
    assert [design["damping_ratio"] for design in answer["designs"]] == [0.05, 0.02]
    values = [design["value"] for design in answer["designs"]]
    assert values == pytest.approx([_closed_form(0.05, 1.0), _closed_form(0.02, 1.0)], rel=1e-12)
    assert answer["designs"][0]["response_class"] == "linear"


def test_what_is_not_computed_is_null_and_counted(client: httpx.Client, helpers: Any) -> None:
    """A study that waits has a cube without a single value; once it is cancelled, only resuming it helps."""
    blockers = [
        client.post(STUDIES, json=helpers.long_study("block", 0.05 + 0.01 * n)).json() for n in range(2)
    ]
    study = {"name": "never", "particle": False, "damping_ratio": 0.04, "axes": {"frequency_ratio": [1, 2]}}
    record = client.post(STUDIES, json=study).json()
    try:
        answer = client.get(f"{STUDIES}/{record['id']}/frequency-response").raise_for_status().json()
        assert (answer["values"], answer["complete"]) == ([None, None], 0.0)
        assert client.post(f"{STUDIES}/{record['id']}/cancel").json()["state"] == "cancelled"
        for question in (
            "frequency-response",
            "resonance-map?x=frequency_ratio&y=friction_ratio",
            "optimal-designs",
            "optimal-designs?pareto=amplitude,mass",
            "tmd-comparison?mass_ratio=0.1",
            "work-precision",
        ):
            refused = client.get(f"{STUDIES}/{record['id']}/{question}")
            assert refused.status_code == 409, question
            assert refused.headers["content-type"] == "application/problem+json"
            assert f"POST /api/v1/studies/{record['id']}/resume" in refused.json()["detail"]
    finally:
        for blocker in blockers:
            client.post(f"{STUDIES}/{blocker['id']}/cancel")
            client.delete(f"{STUDIES}/{blocker['id']}").raise_for_status()


@pytest.mark.parametrize(
    ("query", "field"),
    [
        ("resonance-map?x=frequency_ratio", "y"),
        ("resonance-map?x=foo&y=frequency_ratio", "x"),
        ("resonance-map?x=frequency_ratio&y=frequency_ratio", "y"),
        ("resonance-map?x=frequency_ratio&y=damping_ratio&reduce=max", "reduce"),
        ("resonance-map?x=frequency_ratio&x=friction_ratio&y=damping_ratio", "x"),
        ("frequency-response?metric=beauty", "metric"),
        ("frequency-response?damping_ratio=nan", "damping_ratio"),
        ("frequency-response?damping_ratio=1e999", "damping_ratio"),
        ("frequency-response?dampingratio=1", "dampingratio"),
        ("frequency-response?frequency_ratio=1", "frequency_ratio"),
        ("resonance-map?x=frequency_ratio&y=clearance_m", "y"),
        ("frequency-response?metric=growth", "metric"),
        ("frequency-response?metric=", "metric"),
        ("optimal-designs?objective=", "objective"),
        ("tmd-comparison?frequency_ratio=1", "frequency_ratio"),
        ("optimal-designs?frequency_ratio=0.9,1.1", "frequency_ratio"),
        ("optimal-designs?band=2,1", "band"),
        ("optimal-designs?band=0.9", "band"),
        ("optimal-designs?band=nan,nan", "band"),
        ("optimal-designs?top=0", "top"),
        ("optimal-designs?objective=peak&band=7,8", "band"),
        ("optimal-designs?pareto=amplitude", "pareto"),
        ("optimal-designs?pareto=amplitude,beauty", "pareto"),
        ("optimal-designs?pareto=amplitude,mass&with=abc", "with"),
        (
            "resonance-map?x=friction_ratio&y=damping_ratio&interpolate=true&over=frequency_ratio",
            "interpolate",
        ),
        ("tmd-comparison?clearance=3&mass_ratio=0.1", "clearance"),
        ("tmd-comparison", "mass_ratio"),
        ("tmd-comparison?mass_ratio=0", "mass_ratio"),
        ("tmd-comparison?mass_ratio=0.1&criterion=best", "criterion"),
        ("tmd-comparison?mass_ratio=0.1&detuning=-2", "detuning"),
        ("robust-designs", "amplitudes"),
        ("robust-designs?amplitudes=2,1", "amplitudes"),
        ("robust-designs?amplitudes=0,1", "amplitudes"),
        ("robust-designs?amplitudes=0.5,2&friction=1,2", "friction"),
        ("robust-designs?amplitudes=0.5,2&friction_ratio=7,8", "friction_ratio"),
        ("work-precision?metric=status", "metric"),
        ("export?format=docx", "format"),
    ],
)
def test_bad_parameter_is_named(client: httpx.Client, curve: dict[str, Any], query: str, field: str) -> None:
    answer = client.get(f"{STUDIES}/{curve['id']}/{query}")
    assert answer.status_code == 422
    assert answer.headers["content-type"] == "application/problem+json"
    assert field in {fault["field"] for fault in answer.json()["errors"]}


def test_a_design_without_a_particle_is_compared_with_a_mass_of_its_own(
    client: httpx.Client, curve: dict[str, Any]
) -> None:
    asked = {"mass_ratio": 0, "tmd_mass_ratio": 0.1}
    answer = client.get(f"{STUDIES}/{curve['id']}/tmd-comparison", params=asked).raise_for_status().json()
    assert answer["tmd_mass_ratio"] == 0.1


def test_a_refusal_names_what_this_kind_of_study_has(client: httpx.Client, curve: dict[str, Any]) -> None:
    def faults(question: str, method: str = "GET") -> list[dict[str, str]]:
        answer = client.request(method, f"{STUDIES}/{curve['id']}/{question}")
        assert answer.status_code == 422
        errors: list[dict[str, str]] = answer.json()["errors"]
        return errors

    dimensions = ", ".join(DIMENSIONS)
    for fault, field in zip(faults("resonance-map"), ("x", "y"), strict=True):
        assert (fault["field"], fault["allowed"]) == (field, f"one of {dimensions}")
    for question, method in (
        ("resonance-map?x=foo&y=friction_ratio", "GET"),
        ("refine-boundary", "POST"),
        ("refine-boundary?along=clearance_m", "POST"),
    ):
        assert faults(question, method)[0]["allowed"] == f"one of {dimensions}"
    assert "peak_relative_displacement_m" not in faults("frequency-response?metric=beauty")[0]["allowed"]
    for question in ("frequency-response", "tmd-comparison"):
        (fault,) = faults(f"{question}?frequency_ratio=1")
        assert fault["allowed"] == "nothing: the curve runs along frequency_ratio"
        assert fault["advice"].startswith("leave it out")
    assert "`band`" in faults("optimal-designs?frequency_ratio=0.9,1.1")[0]["advice"]


def test_what_a_study_does_not_store_is_unknown_or_refused(client: httpx.Client, helpers: Any) -> None:
    study = {
        "particle": False,
        "damping_ratio": 0.03,
        "axes": {"frequency_ratio": [0.9, 1.0]},
        "metrics": ["amplitude_ratio"],
    }
    record = client.post(STUDIES, json=study).raise_for_status().json()
    helpers.wait_for(client, record["id"], helpers.ended)
    path = f"{STUDIES}/{record['id']}"
    (design,) = client.get(f"{path}/optimal-designs").raise_for_status().json()["designs"]
    assert (design["error"], design["response_class"], design["locked_share"]) == (None, "unknown", None)
    tmd = client.get(f"{path}/tmd-comparison?mass_ratio=0.1").raise_for_status().json()
    assert tmd["hybrid_peak_error"] is None
    for question in (
        "optimal-designs?",
        "robust-designs?amplitudes=1,1&",
        "optimal-designs?pareto=amplitude,mass&",
    ):
        answer = client.get(f"{path}/{question}exclude_locked=true")
        assert answer.status_code == 422, question
        (fault,) = answer.json()["errors"]
        assert fault == {
            "field": "exclude_locked",
            "found": "a study that does not store response_class",
            "allowed": "a study that stores it",
            "advice": "add response_class to `metrics` and submit again, or leave exclude_locked out",
            "message": "The study does not store response_class, which `exclude_locked` needs.",
        }


def test_csv_has_one_row_for_each_point(client: httpx.Client, curve: dict[str, Any]) -> None:
    answer = client.get(f"{STUDIES}/{curve['id']}/export", params={"format": "csv"}).raise_for_status()
    assert answer.headers["content-type"].startswith("text/csv")
    assert "attachment" in answer.headers["content-disposition"]
    rows = list(csv.DictReader(io.StringIO(answer.text)))
    assert len(rows) == 11
    for row in rows:
        expected = _closed_form(0.0038, float(row["frequency_ratio"]))
        assert float(row["amplitude_ratio"]) == pytest.approx(expected, rel=1e-12)


def test_netcdf_opens_as_the_cube(client: httpx.Client, curve: dict[str, Any], tmp_path: Path) -> None:
    path = tmp_path / "cube.nc"
    with client.stream("GET", f"{STUDIES}/{curve['id']}/export", params={"format": "netcdf"}) as answer:
        answer.raise_for_status()
        path.write_bytes(answer.read())
    with xr.open_dataset(path, engine="h5netcdf") as cube:
        assert cube.attrs["digest"] == curve["digest"]
        peak = float(cube["amplitude_ratio"].sel(frequency_ratio=1.0).squeeze())
    assert peak == pytest.approx(_closed_form(0.0038, 1.0), rel=1e-12)


def test_answers_are_compressed_on_request(client: httpx.Client, curve: dict[str, Any]) -> None:
    address = f"{STUDIES}/{curve['id']}"
    squeezed = client.get(address, headers={"accept-encoding": "gzip"})
    plain = client.get(address, headers={"accept-encoding": "identity"})
    assert squeezed.headers.get("content-encoding") == "gzip"
    assert "content-encoding" not in plain.headers
    assert squeezed.json() == plain.json()


def test_no_other_origin_may_read(client: httpx.Client) -> None:
    answer = client.get(STUDIES, headers={"origin": "http://elsewhere.example"})
    assert not [name for name in answer.headers if name.startswith("access-control")]


def test_simulation_gives_the_steady_response_of_the_structure(client: httpx.Client) -> None:
    point = {"particle": False, "damping_ratio": 0.05, "frequency_ratio": 1.2, "history": 3, "samples": 50}
    answer = client.post("/api/v1/simulate", json=point).raise_for_status().json()
    assert answer["metrics"]["amplitude_ratio"] == pytest.approx(_closed_form(0.05, 1.2), rel=1e-12)
    history = answer["history"]
    assert 2 <= len(history["time"]) <= 50
    assert history["time"] == sorted(history["time"])
    assert set(answer["events"]) == {"impacts", "turns", "attachments"}
    assert answer["state"]["p"] is None


def test_decimated_history_keeps_the_extremes(client: httpx.Client) -> None:
    point = {"particle": False, "damping_ratio": 0.05, "frequency_ratio": 1.0, "cycles": 20, "history": 20}
    full = client.post("/api/v1/simulate", json=point | {"samples": 20_000}).json()["history"]["u"]
    thin = client.post("/api/v1/simulate", json=point | {"samples": 40}).json()["history"]["u"]
    assert len(thin) <= 40 < len(full)
    assert (max(thin), min(thin)) == (max(full), min(full))


def test_every_fault_of_a_simulation_is_named(client: httpx.Client) -> None:
    point = {"frequency_ratio": 0, "restitution": "high", "cycles": -1, "history": 1e9, "clearence_ratio": 3}
    answer = client.post("/api/v1/simulate", json=point)
    assert answer.status_code == 422
    fields = {fault["field"] for fault in answer.json()["errors"]}
    assert fields == {
        "frequency_ratio",
        "restitution",
        "cycles",
        "history",
        "clearence_ratio",
        "clearance_ratio",
    }
