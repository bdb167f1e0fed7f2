"""Ground-motion suites over HTTP: a study like any other, from its submission to its cube on another machine."""

import io
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
import xarray as xr

from damperlab.studies.ground.builtin import builtin_record
from damperlab.worker.ground.design import Damper, Structure
from damperlab.worker.ground.response import ground_response

STUDIES = "/api/v1/studies"
COLUMNS = "time (s), acceleration (g)\n" + "".join(f"{0.02 * i:.2f}, {(-1) ** i * 0.1}\n" for i in range(60))
PEAK = "peak_relative_displacement_m"


def test_it_is_kept_once_and_says_what_it_is(client: httpx.Client, suite: dict[str, Any]) -> None:
    assert suite["shape"] == [2, 1, 1, 2, 1, 1, 3, 2]
    assert suite["dimensions"][0] == "record"
    assert [one["id"] for one in suite["definition"]["records"]] == ["northridge-090", "northridge-360"]
    # its own definition is the same study again, and so is what it was made of
    again = client.post(STUDIES, json=suite["definition"])
    assert (again.status_code, again.json()["id"]) == (200, suite["id"])
    estimate = client.post(f"{STUDIES}?dry_run=true", json=suite["definition"]).json()
    assert estimate["points"] == 24
    assert 0 < estimate["seconds"] < 10
    listed = client.get(STUDIES, params={"name": "two earthquakes"}).json()["studies"]
    assert suite["id"] in [one["id"] for one in listed]
    assert "event: end" in client.get(f"{STUDIES}/{suite['id']}/events").text
    axes = client.get(f"{STUDIES}/{suite['id']}/axes").json()["axes"]
    assert axes["record"] == ["northridge-090", "northridge-360"]


def test_its_cube_is_the_single_runs_bit_for_bit(service: Any, suite: dict[str, Any]) -> None:
    cube = xr.open_zarr(f"{service.url}{STUDIES}/{suite['id']}/zarr", chunks=None).load()
    assert cube[PEAK].dims == tuple(suite["dimensions"])
    assert cube[PEAK].attrs["units"] == "m"
    assert list(cube["record"].values) == ["northridge-090", "northridge-360"]
    for record in cube["record"].values.tolist():
        for scale in cube["scale"].values:
            for clearance in cube["clearance_m"].values:
                one = cube.sel(
                    record=record, scale=scale, clearance_m=clearance, friction_force_n=0.2
                ).squeeze()
                damper = Damper(0.2, 0.1605, float(clearance))
                alone = ground_response(Structure(), damper, builtin_record(record), float(scale))
                for name, value in alone.values().items():
                    assert float(one[name]) == value, name
    assert (cube["peak_relative_displacement_lowest_m"] <= cube["peak_relative_displacement_highest_m"]).all()


@pytest.mark.parametrize("form", ["netcdf", "csv", "parquet"])
def test_it_is_exported_with_its_records_by_name(
    service: Any, client: httpx.Client, suite: dict[str, Any], tmp_path: Path, form: str
) -> None:
    content = (
        client.get(f"{STUDIES}/{suite['id']}/export", params={"format": form}).raise_for_status().content
    )
    cube = xr.open_zarr(f"{service.url}{STUDIES}/{suite['id']}/zarr", chunks=None).load()
    if form == "netcdf":
        (tmp_path / "cube.nc").write_bytes(content)
        with xr.open_dataset(tmp_path / "cube.nc", engine="h5netcdf") as read:
            assert list(read["record"].values) == list(cube["record"].values)
            np.testing.assert_array_equal(read[PEAK], cube[PEAK])
        return
    if form == "csv":
        head, *rows = content.decode().splitlines()
        names = head.split(",")
        columns = {name: [row.split(",")[i] for row in rows] for i, name in enumerate(names)}
    else:
        import pyarrow.parquet

        columns = pyarrow.parquet.read_table(io.BytesIO(content)).to_pydict()
    assert columns["record"] == ["northridge-090"] * 12 + ["northridge-360"] * 12
    np.testing.assert_array_equal(np.array(columns[PEAK], float), cube[PEAK].values.reshape(-1))


def test_a_map_is_the_worst_record_or_the_one_that_is_named(
    client: httpx.Client, service: Any, suite: dict[str, Any]
) -> None:
    cube = xr.open_zarr(f"{service.url}{STUDIES}/{suite['id']}/zarr", chunks=None)[PEAK].squeeze().load()
    path = f"{STUDIES}/{suite['id']}/resonance-map"
    asked: dict[str, Any] = {"x": "clearance_m", "y": "friction_force_n", "scale": 3}
    worst = client.get(path, params=asked).raise_for_status().json()
    at_three = cube.sel(scale=3).transpose("record", "friction_force_n", "clearance_m")
    np.testing.assert_array_equal(worst["values"], at_three.max("record"))
    assert (worst["metric"], worst["units"], worst["over"]) == (PEAK, "m", "record")
    np.testing.assert_array_equal(worst["record_at"], at_three["record"].values[at_three.values.argmax(0)])
    one = client.get(path, params={**asked, "record": "northridge"}).json()
    np.testing.assert_array_equal(one["values"], at_three.sel(record="northridge-090"))
    assert one["at"]["record"] == "northridge-090"
    assert np.shape(one["growth"]) == (2, 3)
    both = client.get(path, params={"x": "clearance_m", "y": "friction_force_n", "over": "scale"}).json()
    every = cube.transpose("scale", "record", "friction_force_n", "clearance_m")
    np.testing.assert_array_equal(both["values"], every.max(("scale", "record")))
    assert (both["over"], both["worst_over"]) == ("scale", "record")
    assert set(np.ravel(both["record_at"])) <= set(cube["record"].values)
    assert "record" not in both["at"]
    mean = client.get(path, params={**asked, "over": "record", "reduce": "mean", "metric": "impacts"}).json()
    assert mean["units"] == "1"
    scales = client.get(path, params={"x": "scale", "y": "clearance_m", "metric": "status"}).json()
    assert scales["values"] == [[0, 0]] * 3


def test_dampers_are_ranked_by_their_worst_case(
    client: httpx.Client, service: Any, suite: dict[str, Any]
) -> None:
    cube = xr.open_zarr(f"{service.url}{STUDIES}/{suite['id']}/zarr", chunks=None)[PEAK].squeeze().load()
    path = f"{STUDIES}/{suite['id']}/optimal-designs"
    answer = client.get(path, params={"top": 3}).raise_for_status().json()
    worst = np.sort(cube.max(("record", "scale")).values, axis=None)
    assert [one["value"] for one in answer["designs"]] == worst[:3].tolist()
    assert answer["designs_total"] == 6
    best = answer["designs"][0]
    where = {name: best[name] for name in ("record", "scale", "clearance_m", "friction_force_n")}
    assert float(cube.sel(where)) == best["value"]
    assert best["growth"] >= 0
    some = {"record": "northridge-360", "scale": "1,1", "clearance_m": "0.002,1", "metric": "impacts"}
    answer = client.get(path, params=some).raise_for_status().json()
    assert {(one["record"], one["scale"]) for one in answer["designs"]} == {("northridge-360", 1.0)}
    assert answer["designs_total"] == 4
    first, short = (
        client.get(path, params={"record": name}).raise_for_status().json()
        for name in ("northridge-090", "northridge")
    )
    assert short == first


@pytest.mark.parametrize(
    ("method", "what", "asked"),
    [
        ("GET", "frequency-response", {}),
        ("GET", "tmd-comparison", {}),
        ("GET", "work-precision", {}),
        ("GET", "robust-designs", {"amplitudes": "0.5,2"}),
        ("POST", "refine", {}),
        ("POST", "refine-boundary", {"along": "clearance_m"}),
        ("GET", "resonance-map", {"x": "record", "y": "scale"}),
        ("GET", "resonance-map", {"x": "clearance_ratio", "y": "scale"}),
        ("GET", "resonance-map", {"x": "clearance_m", "y": "scale", "record": "loma-prieta"}),
        ("GET", "resonance-map", {"x": "clearance_m", "y": "scale", "metric": "amplitude_ratio"}),
        ("GET", "resonance-map", {"x": "clearance_m", "y": "scale", "interpolate": True}),
        ("GET", "resonance-map", {"x": "clearance_m", "y": "scale", "frequency_ratio": 1}),
        ("GET", "optimal-designs", {"objective": "peak"}),
        ("GET", "optimal-designs", {"record": "nowhere"}),
        ("GET", "optimal-designs", {"clearance_m": "5,6"}),
        ("GET", "optimal-designs", {"metric": "status"}),
    ],
)
def test_what_it_cannot_answer_is_said(
    client: httpx.Client, suite: dict[str, Any], method: str, what: str, asked: dict[str, Any]
) -> None:
    answer = client.request(method, f"{STUDIES}/{suite['id']}/{what}", params=asked)
    assert answer.status_code == 422, answer.text
    assert answer.headers["content-type"].startswith("application/problem+json")
    (fault,) = answer.json()["errors"]
    assert fault["found"]
    assert fault["allowed"]
    if what not in ("resonance-map", "optimal-designs"):
        assert "a ground-motion suite" in fault["found"]
        assert "ask for a map over two of its dimensions" in fault["advice"]


def test_a_harmonic_study_knows_nothing_of_suites(client: httpx.Client, curve: dict[str, Any]) -> None:
    path = f"{STUDIES}/{curve['id']}"
    asked = {"x": "friction_ratio", "y": "mass_ratio", "record": "loma-prieta"}
    assert client.get(f"{path}/resonance-map", params=asked).json()["errors"][0]["field"] == "record"
    refused = client.get(f"{path}/optimal-designs", params={"scale": "1,2"})
    assert (refused.status_code, refused.json()["errors"][0]["field"]) == (422, "scale")


def test_an_uploaded_record_stays_with_its_study(service: Any, client: httpx.Client, helpers: Any) -> None:
    headers = {"content-type": "text/csv"}
    record_id = client.post("/api/v1/records", content=COLUMNS, headers=headers).json()["id"]
    asked = {"name": "mine", "records": [record_id], "axes": {"scale": [1, 2]}}
    first = client.post(STUDIES, json=asked).raise_for_status().json()
    kept = helpers.wait_for(client, first["id"], helpers.ended)
    assert (kept["state"], kept["points_done"]) == ("done", 2)
    files = list((service.log.parent / "data" / "records").glob(f"{record_id}.*"))
    assert len(files) == 2
    for file in files:
        file.unlink()
    refused = client.post(STUDIES, json={**asked, "axes": {"scale": 5}})
    assert (refused.status_code, refused.json()["errors"][0]["field"]) == (422, "records[0]")
    assert client.get(f"{STUDIES}/{kept['id']}/optimal-designs").status_code == 200


def test_contact_is_asked_for(client: httpx.Client) -> None:
    compare = "/api/v1/earthquake-comparisons"
    asked = {"record": "northridge", "cases": ["hybrid"], "starts": 0, "scale": 3, "clearance_m": 0.001}
    instant = client.post(compare, json=asked).raise_for_status().json()
    contact = {"model": "dwell", "contact_time": 0.3}
    dwelling = client.post(compare, json={**asked, "contact": contact}).raise_for_status().json()
    assert dwelling["contact"] == contact
    assert dwelling["cases"]["hybrid"]["impacts"] < instant["cases"]["hybrid"]["impacts"]
    assert dwelling["cases"]["hybrid"]["energy_residual"] < 1e-9
    pushes = []
    for contact_time in (0.3, 0.003):
        contact = {"model": "compliant", "contact_time": contact_time}
        pressed = client.post(compare, json={**asked, "contact": contact}).raise_for_status().json()
        assert pressed["contact"] == contact
        assert pressed["cases"]["hybrid"]["energy_residual"] < 1e-9
        pushes.append(pressed["cases"]["hybrid"]["peak_absolute_acceleration_m_s2"])
    assert pushes[1] > 10 * pushes[0]  # mostly the wall's push, which goes as one over the contact time
    refused = client.post(compare, json={**asked, "contact": contact, "restitution": 0})
    (fault,) = refused.json()["errors"]
    assert (refused.status_code, fault["field"], fault["found"]) == (422, "restitution", "0")
