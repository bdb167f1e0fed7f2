"""A service whose cubes lie in a bucket: it runs studies, pauses them while the bucket does not answer, and goes on."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import aiohttp
import httpx
import pytest
import xarray as xr
from tests.faults.processes import ObjectServer
from tests.object_store import BUCKET, SECRET, environment, proxy_before

from damperlab.studies.store.care.verify import verify
from damperlab.studies.store.store import Store

pytestmark = pytest.mark.night

STUDIES = "/api/v1/studies"


def test_a_bucket_that_does_not_answer_pauses_studies_and_loses_nothing(
    own_service: Callable[..., Any], helpers: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    server = ObjectServer(tmp_path / "objects")
    server.wait()
    try:
        with proxy_before(server.door) as proxy:
            variables = environment(proxy.address) | {"DAMPERLAB_STORE": f"s3://{BUCKET}/service"}
            service = own_service(tmp_path / "data", **variables)
            with httpx.Client(base_url=service.url, timeout=300) as client:
                _pause_and_go_on(client, proxy, helpers)
            url = f"{service.url}{STUDIES}"
            for name, value in server.environment.items():
                monkeypatch.setenv(name, value)
            store = Store.open(tmp_path / "data")  # the catalogue knows where its cubes are
            for record in store.page().records:
                assert list(verify(store, record)) == []
                over_http = _read(f"{url}/{record.id}/zarr", helpers)
                xr.testing.assert_equal(over_http, store.cube(record.id).load())
            used = {entry.key.partition("~")[2] for entry in store.shelf.entries() if "~" in entry.key}
            marked = {g for r in store.page().records for g in store.snapshot(r.id)[1].values()}
            assert used == marked  # no stray of the attempts that failed
            store.close()
            assert SECRET not in service.log.read_text()
    finally:
        server.kill()
    assert not list((tmp_path / "data" / "cubes").iterdir())


def _pause_and_go_on(client: httpx.Client, proxy: Any, helpers: Any) -> None:
    curve = _submitted(client, helpers.CURVE, helpers)
    assert helpers.wait_for(client, curve, helpers.ended)["state"] == "done"
    study = _submitted(client, helpers.long_study("paused", frequencies=100), helpers)
    running = helpers.wait_for(client, study, lambda record: record["blocks_done"] > 1)
    proxy.mode = "refuse"
    paused = helpers.wait_for(client, study, lambda record: record["state"] == "queued")
    assert "503 Service Unavailable" in paused["message"] or "503 Slow Down" in paused["message"]
    assert f"s3://{BUCKET}/service" in paused["message"]
    assert paused["blocks_done"] >= running["blocks_done"]
    for question in ("frequency-response", "zarr/amplitude_ratio/c.0.0.0.0.0.0"):
        answer = client.get(f"{STUDIES}/{curve}/{question}")
        assert answer.status_code == 503, question
        assert answer.json()["type"] == "urn:damperlab:problem:store-unavailable"
        assert "s3://" in answer.json()["errors"][0]["found"]
    assert client.post(STUDIES, json=helpers.long_study("refused", 0.01, frequencies=100)).status_code == 503
    assert client.get(f"{STUDIES}/{study}").status_code == 200  # the catalogue is elsewhere
    proxy.mode = "well"
    assert helpers.wait_for(client, study, helpers.ended)["state"] == "done"
    assert client.get(f"{STUDIES}/{study}").json()["message"] is None
    assert client.get(f"{STUDIES}/{curve}/frequency-response").status_code == 200


def _read(cube: str, helpers: Any) -> xr.Dataset:
    """Read a cube; zarr's client does not ask again after a 503, and on a busy machine the bucket may answer too late."""
    found: list[xr.Dataset] = []

    def read() -> bool:
        try:
            found.append(xr.open_zarr(cube, chunks=None).load())
        except aiohttp.ClientResponseError as error:
            if error.status != 503:
                raise
        return bool(found)

    helpers.wait_until(read)
    return found[0]


def _submitted(client: httpx.Client, study: dict[str, Any], helpers: Any) -> str:
    """Submit a study; on a busy machine the bucket may answer too late, and a 503 has kept nothing: it is asked again."""
    answers: list[httpx.Response] = []

    def taken() -> bool:
        answers.append(client.post(STUDIES, json=study))
        return answers[-1].status_code != 503

    helpers.wait_until(taken)
    found: str = answers[-1].raise_for_status().json()["id"]
    return found
