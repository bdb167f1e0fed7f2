"""Readiness answers even while a store hangs, and says what is wrong; none that waits is lost."""

import asyncio
import shutil
import signal
import subprocess
import threading
import time
from collections.abc import Iterator
from contextlib import closing, suppress
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import psutil
import pytest
from tests.faults.processes import Database
from tests.service.conftest import serving, wait_until

from damperlab.service.edge import silence
from damperlab.service.readiness import PROBE, Readiness
from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.files.bucket import open_bucket
from damperlab.studies.store.store import Store
from damperlab.worker.run.background import Background


@pytest.fixture
def server(tmp_path: Path) -> Iterator[tuple[str, list[psutil.Process]]]:
    """A PostgreSQL of our own: its address, and its processes."""
    with closing(Database(tmp_path / "postgresql")) as running:
        first = psutil.Process(int((tmp_path / "postgresql" / "postmaster.pid").read_text().split()[0]))
        yield running.address, [first, *first.children(recursive=True)]


@pytest.mark.night
def test_service_says_that_its_database_hangs_and_recovers(server, tmp_path):
    address, processes = server
    with (
        serving(tmp_path, DAMPERLAB_CATALOGUE=address) as running,
        running.client() as client,  # what takes longer hangs
    ):
        wait_until(lambda: client.get("/health/ready").status_code == 200)
        assert client.get("/api/v1/studies").status_code == 200
        stopped = {each for one in processes for each in (one, *one.children(recursive=True))}
        for process in stopped:
            process.send_signal(signal.SIGSTOP)
        try:
            wait_until(lambda: client.get("/health/ready").status_code == 503)
            answer = client.get("/health/ready")
            assert client.get("/health/live").status_code == 200
            # whose answer needs the database is refused, however many wait; the client's limit is longer
            refused = client.get("/api/v1/studies")
            assert (refused.status_code, refused.headers["Retry-After"]) == (503, "10")
        finally:
            for process in stopped:
                process.send_signal(signal.SIGCONT)
        assert "has not answered within" in answer.json()["detail"]
        wait_until(lambda: client.get("/health/ready").status_code == 200)
        wait_until(lambda: client.get("/api/v1/studies").status_code == 200)


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    with closing(Store.open(tmp_path / "data")) as store:
        yield store


def told(readiness: Readiness) -> str:
    """What is wrong once it has been looked at, in one text."""
    readiness._look()
    problem = readiness.problem()
    if problem is None:
        return ""
    assert problem.status == 503
    return " ".join([problem.kind, problem.detail, *(str(fault) for fault in problem.faults)])


def test_who_asks_waits_for_no_store(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("damperlab.service.readiness.STALE_SECONDS", 0.05)
    looked, answers = threading.Event(), threading.Event()

    def page(limit: int) -> None:
        looked.set()
        assert answers.wait(300)

    monkeypatch.setattr(store, "page", page)
    readiness = Readiness(store, ())
    readiness.background.start()
    try:
        assert looked.wait(300)
        while (problem := readiness.problem()) is None:
            answers.wait(0.01)
        assert not answers.is_set()
        assert "has not answered within" in problem.detail
    finally:
        answers.set()
        readiness.background.close()


def test_a_data_folder_that_was_moved_is_not_ready(store: Store) -> None:
    readiness = Readiness(store, ())
    assert told(readiness) == ""
    elsewhere = store.data_dir.with_name("elsewhere")
    store.data_dir.rename(elsewhere)
    assert str(store.data_dir) in told(readiness)
    # another folder in its place is not the one that holds the studies
    (store.data_dir / "cubes").mkdir(parents=True)
    (store.data_dir / "cubes" / "damperlab.json").touch()
    assert "is not the folder that was opened" in told(readiness)
    shutil.rmtree(store.data_dir)
    elsewhere.rename(store.data_dir)
    assert told(readiness) == ""


def test_a_disk_without_a_free_byte_is_not_ready(tmp_path: Path) -> None:
    disk = tmp_path / "disk"
    disk.mkdir()
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=4m", "tmpfs", str(disk)], check=False)
    if mounted.returncode:
        pytest.skip("mounting is for root alone: run the tests in a container with SYS_ADMIN")
    try:
        with closing(Store.open(disk / "data")) as store:
            readiness = Readiness(store, ())
            assert told(readiness) == ""
            with (disk / "ballast").open("wb", buffering=0) as file, suppress(OSError):
                while True:
                    file.write(bytes(4096))
            assert "No space left on device" in told(readiness)
            (disk / "ballast").unlink()
            assert told(readiness) == ""
            assert not list(disk.rglob(PROBE))
    finally:
        subprocess.run(["umount", "--lazy", str(disk)], check=True)


def test_a_thread_that_is_down_is_not_ready(store: Store) -> None:
    well = threading.Event()

    def work() -> None:
        if not well.is_set():
            raise ValueError("a defect")

    background = Background("dispatch", work, 0.01)
    readiness = Readiness(store, (background,))
    assert told(readiness) == ""
    background.start()
    try:
        while "background-down" not in (found := told(readiness)):
            well.wait(0.01)
        assert "The thread dispatch is down: ValueError: a defect" in found
        well.set()
        while told(readiness):
            threading.Event().wait(0.01)
    finally:
        background.close()


def test_no_keys_are_asked_for_unless_told_to(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("obstore")
    for name in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY", "AWS_EC2_METADATA_DISABLED"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("AWS_REGION", "us-east-1")
    with pytest.raises(StoreFault, match="no keys for the object store"):
        open_bucket("s3://bucket/prefix")
    monkeypatch.setenv("AWS_ACCESS_KEY_ID", "half")
    with pytest.raises(StoreFault, match="AWS_SECRET_ACCESS_KEY"):
        open_bucket("s3://bucket/prefix")
    monkeypatch.delenv("AWS_ACCESS_KEY_ID")
    for asked in (
        {"AWS_ACCESS_KEY_ID": "half", "AWS_SECRET_ACCESS_KEY": "whole"},
        {"AWS_EC2_METADATA_DISABLED": "false"},
    ):
        with monkeypatch.context() as patch:
            for name, value in asked.items():
                patch.setenv(name, value)
            assert open_bucket("s3://bucket/prefix").address == "s3://bucket/prefix"


def test_requests_that_wait_at_once_are_all_served(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(silence, "PATIENCE_SECONDS", 0.002)
    catalogue = SimpleNamespace(is_file=False, greet=lambda: time.sleep(0.001))
    state = SimpleNamespace(service=SimpleNamespace(store=SimpleNamespace(catalogue=catalogue)))
    scope = {"type": "http", "path": "/api/v1/studies", "app": SimpleNamespace(state=state)}

    async def app(scope: Any, receive: Any, send: Any) -> None:
        await asyncio.sleep(0.2)
        await send({"type": "http.response.start", "status": 200, "headers": []})

    async def served() -> list[int]:
        statuses: list[int] = []

        async def send(message: Any) -> None:
            statuses.append(message["status"])

        async def receive() -> Any:
            raise AssertionError("nothing is read")

        async def one(place: int) -> None:
            await asyncio.sleep(0.0003 * place)
            await edge(scope, receive, send)

        edge = silence.Silence(app)
        await asyncio.gather(*map(one, range(200)))
        return statuses

    assert asyncio.run(served()) == [200] * 200
