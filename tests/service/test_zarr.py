"""The cube over HTTP as Zarr clients read it: equal bits, honest errors, ranges and tags."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
import xarray as xr
from tests.filling import enter, make_plan_of, values_of, write

from damperlab.studies.definition import Study, parse_study
from damperlab.studies.plan import Block, Plan
from damperlab.studies.store.export.export import without_names
from damperlab.studies.store.store import Store

STUDIES = "/api/v1/studies"


def _study(points: int) -> Study:
    axes = {"friction_ratio": [0.0, 0.1], "frequency_ratio": {"start": 0.5, "stop": 1.5, "num": points}}
    return parse_study({"name": "by hand", "damping_ratio": 0.01, "particle": False, "axes": axes})


def _write(store: Store, study: Study, block: Block, generation: str) -> None:
    """Write a block whose values are all above zero, its status aside."""
    values = {name: column + (name != "status") for name, column in values_of(study, block).items()}
    write(store, study.digest[:12], block, values, generation)


@pytest.fixture(scope="module")
def stopped(store: Store) -> tuple[Store, str, Study, Plan]:
    """A study beside the service's own: blocks 0 to 2 of 8 are done, and somebody cancelled it."""
    study = _study(40)
    plan = make_plan_of(study, (1, 1, 1, 1, 1, 10))
    record = enter(store, study, plan.chunk)
    assert store.claim(record.id, "the test")
    store.set_state(record.id, "cancelled")
    for index in range(3):
        _write(store, study, plan.block(index), "first")
    return store, record.id, study, plan


def test_blocks_that_an_ended_study_lacks_read_as_not_computed(
    service: Any, client: httpx.Client, stopped: tuple[Store, str, Study, Plan]
) -> None:
    store, study_id, _, _ = stopped
    remote = xr.open_zarr(f"{service.url}{STUDIES}/{study_id}/zarr", chunks=None).load()
    xr.testing.assert_identical(remote, without_names(store.cube(study_id).load()))
    assert (remote["status"] == -1).sum() == 50


def test_blocks_that_are_still_coming_are_no_fill_values(
    service: Any, client: httpx.Client, stopped: tuple[Store, str, Study, Plan]
) -> None:
    store, study_id, study, plan = stopped
    store.set_state(study_id, "running")
    try:
        url = f"{STUDIES}/{study_id}/zarr"
        answer = client.get(f"{url}/status/c.0.0.0.0.1.3")
        assert (answer.status_code, answer.headers["cache-control"]) == (409, "no-store")
        revision = store.find(study_id).revision
        assert f"@{revision}/" in answer.json()["detail"]
        remote = xr.open_zarr(f"{service.url}{url}", chunks=None)
        assert (remote["status"].isel(friction_ratio=0, frequency_ratio=slice(30)) == 0).all()
        with pytest.raises(Exception, match="409"):
            remote["status"].load()
        # at a revision the study stands still, whatever becomes done between two reads
        pinned = xr.open_zarr(f"{service.url}{url}/@{revision}", chunks=None)
        status = pinned["status"].load()
        _write(store, study, plan.block(4), "later")
        cycles = pinned["cycles"].load()
        np.testing.assert_array_equal(status == 0, cycles > 0)
        assert (status == 0).sum() == 30
    finally:
        store.set_state(study_id, "cancelled")


def test_a_deleted_study_is_gone_and_no_fill_values(service: Any, client: httpx.Client, store: Store) -> None:
    study = parse_study(
        {"particle": False, "damping_ratio": 0.02, "axes": {"frequency_ratio": [0.5, 0.7, 1.1]}}
    )
    plan = make_plan_of(study, (1, 1, 1, 1, 1, 2))
    record = enter(store, study, plan.chunk)
    assert store.claim(record.id, "the test")
    for index in range(plan.count):
        _write(store, study, plan.block(index), "first")
    store.set_state(record.id, "done")
    store.release(record.id, "the test")
    url = f"{STUDIES}/{record.id}/zarr"
    remote = xr.open_zarr(f"{service.url}{url}", chunks=None)
    assert (remote["cycles"].isel(frequency_ratio=slice(2)) == 1).all()
    client.delete(f"{STUDIES}/{record.id}").raise_for_status()
    with pytest.raises(Exception, match="410"):
        remote["cycles"].load()
    gone = client.get(f"{url}/cycles/c.0.0.0.0.0.0")
    assert (gone.status_code, gone.headers["cache-control"]) == (410, "no-store")
    assert gone.json()["type"] == "urn:damperlab:problem:study-gone"
    # there is nothing to open any more
    assert client.get(f"{url}/zarr.json").status_code == 404


@pytest.mark.parametrize(
    "damaged",
    [None, lambda content: content[:3] + bytes([content[3] ^ 1]) + content[4:]],
    ids=["lost", "flipped"],
)
def test_damaged_blocks_are_errors(
    service: Any,
    client: httpx.Client,
    stopped: tuple[Store, str, Study, Plan],
    damaged: Callable[[bytes], bytes] | None,
) -> None:
    store, study_id, _, _ = stopped
    file = Path(store.cube_path(study_id), "blocks", "1~first")
    content = file.read_bytes()
    try:
        file.unlink() if damaged is None else file.write_bytes(damaged(content))
        answer = client.get(f"{STUDIES}/{study_id}/zarr/amplitude_ratio/c.0.0.0.0.0.1")
        assert answer.status_code == 503
        assert answer.json()["type"] == "urn:damperlab:problem:block-damaged"
        assert "damperlab store verify --repair" in answer.json()["errors"][0]["advice"]
        with pytest.raises(Exception, match="503"):
            xr.open_zarr(f"{service.url}{STUDIES}/{study_id}/zarr", chunks=None)["amplitude_ratio"].load()
        question = client.get(f"{STUDIES}/{study_id}/frequency-response", params={"friction_ratio": 0})
        assert question.status_code == 503
    finally:
        file.write_bytes(content)


def test_a_block_is_sent_in_parts_and_not_again(
    client: httpx.Client, stopped: tuple[Store, str, Study, Plan]
) -> None:
    url = f"{STUDIES}/{stopped[1]}/zarr/amplitude_ratio/c.0.0.0.0.0.0"
    whole = client.get(url)
    tag, size = whole.headers["etag"], len(whole.content)
    assert "first" in tag
    for asked, start, stop in (
        ("-4", size - 4, size), ("1-2", 1, 3), ("5-", 5, size), (f"5-{10 * size}", 5, size),
    ):  # fmt: skip
        part = client.get(url, headers={"Range": f"bytes={asked}", "If-Range": tag})
        assert (part.status_code, part.content) == (206, whole.content[start:stop])
        assert part.headers["content-range"] == f"bytes {start}-{stop - 1}/{size}"
    for beyond in (f"bytes={size}-", "bytes=5-2"):
        assert client.get(url, headers={"Range": beyond}).status_code == 416, beyond
    ignored = ("bytes=0-1,5-6", "bytes=-", "bytes=" + "9" * 400 + "-")
    # a part of what is not there any more is not handed out
    for headers in (*({"Range": each} for each in ignored), {"Range": "bytes=0-1", "If-Range": '"x"'}):
        answer = client.get(url, headers=headers)
        assert (answer.status_code, answer.content) == (200, whole.content)
    assert client.get(url, headers={"If-None-Match": f'"x", {tag}'}).status_code == 304
    head = client.head(url)
    assert (head.status_code, head.content, int(head.headers["content-length"])) == (200, b"", size)
    metadata = f"{STUDIES}/{stopped[1]}/zarr/zarr.json"
    known = {"If-None-Match": client.get(metadata).headers["etag"]}
    assert client.get(metadata, headers=known).status_code == 304


@pytest.mark.parametrize(
    "key",
    [
        "",
        "nothing",
        "%2e%2e/%2e%2e/catalogue.sqlite",
        "status/%2e%2e/%2e%2e/catalogue.sqlite",
        "status/c.0",
        "status/c.0.0.0.0.0.99",
        "status/c.0.0.0.0.0.-1",
        "status/c.0.0.0.0.0.0~first",
        "c/0",
        "status",
        "@1",
        "%00",
        "period/c.0.0.0.0.0.\u00b2",
    ],
)
def test_nothing_else_is_there(
    client: httpx.Client, stopped: tuple[Store, str, Study, Plan], key: str
) -> None:
    assert client.get(f"{STUDIES}/{stopped[1]}/zarr/{key}").status_code == 404


def test_an_etag_changes_with_the_generation_and_old_revisions_are_gone(
    client: httpx.Client, store: Store
) -> None:
    study = _study(20)
    plan = make_plan_of(study, (1, 1, 1, 1, 1, 20))
    study_id = store.submit(study, plan, {})[0].id
    assert store.claim(study_id, "the test")
    store.set_state(study_id, "cancelled")
    _write(store, study, plan.block(0), "first")
    url = f"{STUDIES}/{study_id}/zarr"
    revision = store.find(study_id).revision
    first = client.get(f"{url}/@{revision}/status/c.0.0.0.0.0.0")
    store.release(study_id, "the test")
    store.forget(study_id, [0], "for this test")
    store.set_state(study_id, "cancelled")
    _write(store, study, plan.block(0), "second")
    second = client.get(f"{url}/status/c.0.0.0.0.0.0", headers={"If-None-Match": first.headers["etag"]})
    assert second.status_code == 200
    assert second.headers["etag"] != first.headers["etag"]
    assert client.get(f"{url}/@{revision}/status/c.0.0.0.0.0.0").status_code == 410
    assert client.get(f"{url}/@99/zarr.json").status_code == 410
    store.delete(study_id)
    assert client.get(f"{url}/zarr.json").status_code == 404
