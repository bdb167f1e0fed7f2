"""A service whose storage fails it: a clear state and message, answers that still can be given, and it goes on by itself."""

import os
import sqlite3
import subprocess
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.service.conftest import CURVE, ended, long_study, wait_for, wait_until

from damperlab.studies.specification.reading import specification_document
from damperlab.studies.store.care.verify import verify
from damperlab.studies.store.store import Store

STUDIES = "/api/v1/studies"
LOCK_SECONDS = float(os.environ.get("FAULTS_LOCK_SECONDS", "8"))
"""How long another process holds the catalogue; `make faults` sets it to 30."""


def mount(*arguments: str) -> None:
    try:
        subprocess.run(["mount", *arguments], check=True, capture_output=True, timeout=20)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("mounting is for root alone: run the tests in a container with SYS_ADMIN")


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Path]:
    """A small disk of its own."""
    folder = tmp_path / "disk"
    folder.mkdir()
    mount("-t", "tmpfs", "-o", "size=32m", "tmpfs", str(folder))
    yield folder
    subprocess.run(["umount", "--lazy", str(folder)], check=True, timeout=20)


def run_times(store: Store, study_id: str) -> np.ndarray:
    """No two runs of a point take the same time to the last bit: equal ones were not run again."""
    return store.cube(study_id)["run_time"].values


def assert_kept(before: np.ndarray, after: np.ndarray) -> None:
    kept = ~np.isnan(before)
    assert kept.any()
    np.testing.assert_array_equal(before[kept], after[kept])


def test_a_full_disk_pauses_studies_and_nothing_else(own_service: Callable[..., Any], disk: Path) -> None:
    service = own_service(disk / "data")
    store = Store.open(disk / "data")
    with service.client() as client:
        other = client.post(STUDIES, json=CURVE).raise_for_status().json()["id"]
        assert wait_for(client, other, ended)["state"] == "done"
        study = client.post(STUDIES, json=long_study("paused")).raise_for_status().json()["id"]
        wait_for(client, study, lambda record: record["blocks_done"] > 1)
        with (disk / "ballast").open("wb") as file:
            # less than is kept for the catalogue, and still room for that
            file.truncate(0)
            file.write(bytes(22 * 2**20))
        paused = wait_for(client, study, lambda record: record["state"] != "running")
        assert paused["state"] == "queued"
        assert "is full" in paused["message"]
        assert "make room" in paused["message"]
        assert 0 < paused["blocks_done"] < paused["blocks_total"]
        before = run_times(store, study)
        wait_until(lambda: "is full" in str(client.get("/health/ready").json().get("cluster_message")))
        # other studies, and what there is of this one, are read as ever
        curve = client.get(f"{STUDIES}/{other}/frequency-response").raise_for_status().json()
        assert len(curve["values"]) == 11
        assert (
            client.get(f"{STUDIES}/{study}/frequency-response", params={"friction_ratio": 0.1}).status_code
            == 200
        )
        assert client.get(f"{STUDIES}/{other}/zarr/status/c.0.0.0.0.0.0").status_code == 200
        (disk / "ballast").unlink()
        more = wait_for(client, study, lambda record: record["blocks_done"] > paused["blocks_done"])
        assert (more["state"], more["message"]) in (("running", None), ("done", None)), more
        client.post(f"{STUDIES}/{study}/cancel").raise_for_status()
    assert_kept(before, run_times(store, study))
    assert list(verify(store, store.find(study))) == []
    store.close()


@pytest.mark.night
def test_a_locked_catalogue_delays_and_loses_nothing(own_service: Callable[..., Any], tmp_path: Path) -> None:
    service = own_service(DAMPERLAB_CATALOGUE_WAIT_SECONDS="2")
    file = tmp_path / "data" / "catalogue.sqlite"
    with (
        service.client() as client,
        closing(sqlite3.connect(file, isolation_level=None, timeout=20)) as other,
        ThreadPoolExecutor(60) as threads,
    ):
        study = client.post(STUDIES, json=long_study("locked")).raise_for_status().json()["id"]
        wait_for(client, study, lambda record: record["blocks_done"] > 1)
        other.execute("BEGIN EXCLUSIVE")
        began = time.monotonic()
        # more writers than the service has threads, and readers that do not wait for them
        posts = [
            threads.submit(client.post, STUDIES, json={**CURVE, "damping_ratio": 0.001 * number})
            for number in range(1, 51)
        ]
        while time.monotonic() < began + LOCK_SECONDS:
            look = client.get(f"{STUDIES}/{study}")
            assert look.status_code == 200
            assert client.get("/health/live").status_code == 200
            time.sleep(0.2)
        other.execute("ROLLBACK")
        codes = {answer.result().status_code for answer in posts}
        assert codes <= {201, 503}
        assert 503 in codes
        refused = next(answer.result() for answer in posts if answer.result().status_code == 503)
        assert "locked" in refused.json()["errors"][0]["found"]
        assert int(refused.headers["retry-after"]) > 0
        store = Store.open(tmp_path / "data")
        before = run_times(store, study)
        more = wait_for(client, study, lambda record: record["blocks_done"] > look.json()["blocks_done"])
        assert more["state"] in ("running", "done"), more
        client.post(f"{STUDIES}/{study}/cancel").raise_for_status()
        assert_kept(before, run_times(store, study))
        assert list(verify(store, store.find(study))) == []
        store.close()


@pytest.mark.night
@pytest.mark.parametrize("shelf", ["designs", "records"])
def test_a_folder_that_cannot_be_used_is_told_and_no_defect(
    own_service: Callable[..., Any], tmp_path: Path, shelf: str
) -> None:
    running = own_service()
    (tmp_path / "data" / shelf).write_bytes(b"")
    bodies = {
        "designs": specification_document("prototype"),
        "records": {"kanai_tajimi": {"seed": 1}},
    }
    with running.client() as client:
        refused = client.post(f"/api/v1/{shelf}", json=bodies[shelf])
        assert refused.status_code == 503
        assert str(tmp_path / "data" / shelf) in refused.json()["errors"][0]["message"]
    assert running.stop() == 0
