"""Ground-motion suites over HTTP: a study like any other, from its submission to its cube on another machine."""

from typing import Any

import httpx
import numpy as np
import xarray as xr

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
