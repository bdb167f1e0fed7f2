"""Workers that leave when they are told to, and clusters that only those with a certificate can reach."""

import asyncio
import os
import signal
import socket
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import psutil
import pytest
from distributed import Security
from tests.worker.dask_processes import scheduler_process, worker_process
from tests.worker.dispatch.test_window import pump

from damperlab.studies.store.record import BlockOutcome
from damperlab.worker.cluster.certificates import make_certificates, security
from damperlab.worker.cluster.cluster import _probe, connect
from damperlab.worker.dispatch.window import Window
from damperlab.worker.outcomes import ClusterUnusable, Failure

GONE_SECONDS = 120.0


def begun(folder: Path) -> dict[int, int]:
    """How often each block was begun."""
    names = [int(path.name.split("-")[0]) for path in folder.iterdir() if path.name[0].isdigit()]
    return {index: names.count(index) for index in names}


def test_worker_that_is_told_to_leave_ends_its_block_and_the_next_one_goes_on(tmp_path: Path) -> None:
    """Two in a row are told so, each while it computes; no block is computed twice."""

    def task(index: int) -> BlockOutcome:
        (tmp_path / f"{index}-{time.monotonic_ns()}").touch()
        time.sleep(1.0)
        return BlockOutcome(index, 1, 0, 0.0, 0.0)

    with scheduler_process() as (address, _), connect(scheduler=address) as client, ExitStack() as stack:
        window = Window(client, lambda index, key: (task, index), range(4))
        ended: list[BlockOutcome | Failure] = []
        for _ in range(2):
            process = stack.enter_context(worker_process(address))
            before = sum(begun(tmp_path).values())
            while sum(begun(tmp_path).values()) == before:
                window.fill()
                ended.extend(window.collect(0.1))
            process.send_signal(signal.SIGTERM)
            while process.poll() is None:
                window.fill()
                ended.extend(window.collect(0.1))
            assert process.returncode == 0
        stack.enter_context(worker_process(address))
        ended.extend(pump(window))
    assert sorted(each.index for each in ended) == list(range(4))
    assert all(isinstance(each, BlockOutcome) for each in ended)
    assert begun(tmp_path) == dict.fromkeys(range(4), 1)


@pytest.mark.night
@pytest.mark.parametrize(("scheduler", "status"), [("gives it nothing", 0), ("is lost", 1), ("never was", 1)])
def test_worker_without_work_leaves_in_time(scheduler: str, status: int) -> None:
    with ExitStack() as stack:
        if scheduler == "never was":
            # nobody listens there while it is held
            silent = stack.enter_context(socket.socket())
            silent.bind(("127.0.0.1", 0))
            address = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
        else:
            address, process = stack.enter_context(scheduler_process())
        worker = stack.enter_context(worker_process(address, "--leave-idle=8"))
        if scheduler == "is lost":
            with connect(scheduler=address) as client:
                client.wait_for_workers(1, timeout=GONE_SECONDS)
            process.kill()
        assert worker.wait(GONE_SECONDS) == status


@pytest.mark.night
@pytest.mark.parametrize("how", ["notice", "lifetime"])
def test_block_that_takes_longer_than_there_is_time_is_given_back(tmp_path: Path, how: str) -> None:
    notice = tmp_path / "notice"

    def task(index: int) -> BlockOutcome:
        (tmp_path / f"{index}-{time.monotonic_ns()}").touch()
        if begun(tmp_path)[index] == 1:
            time.sleep(600.0)
        return BlockOutcome(index, 1, 0, 0.0, 0.0)

    options = {"notice": f"--notice={notice}", "lifetime": "--lifetime=60"}[how]
    with scheduler_process() as (address, _), connect(scheduler=address) as client, ExitStack() as stack:
        window = Window(client, lambda index, key: (task, index), range(1))
        process = stack.enter_context(worker_process(address, "--leave-within=1", options))
        while not begun(tmp_path):
            window.fill()
            assert list(window.collect(0.1)) == []
        notice.touch()
        assert process.wait(GONE_SECONDS) == 0
        stack.enter_context(worker_process(address))
        assert [each.index for each in pump(window)] == [0]
        assert window.workers.retries == 1


def test_files_say_who_may_take_part(tmp_path: Path) -> None:
    pytest.importorskip("cryptography")
    make_certificates(tmp_path / "ours")
    make_certificates(tmp_path / "theirs")
    assert (tmp_path / "ours" / "key.pem").stat().st_mode & 0o777 == 0o600
    assert not any("authority" in path.name for path in (tmp_path / "ours").iterdir())
    with pytest.raises(FileExistsError):
        make_certificates(tmp_path / "ours")
    (tmp_path / "theirs" / "key.pem").rename(tmp_path / "theirs" / "elsewhere")
    with pytest.raises(ClusterUnusable, match=r"holds no key\.pem that can be read"):
        security(tmp_path / "theirs")
    make_certificates(tmp_path / "ended", days=0)
    with pytest.raises(ClusterUnusable, match=r"ca\.pem ended on .* by the clock of this machine"):
        security(tmp_path / "ended")
    (tmp_path / "ours" / "cert.pem").write_text("nothing")
    with pytest.raises(ClusterUnusable, match=r"cert\.pem holds no certificate"):
        security(tmp_path / "ours")


@contextmanager
def certified(ours: Path, theirs: Path) -> Iterator[str]:
    """Address of a scheduler with certificates of an authority; those of another one lie beside them."""
    pytest.importorskip("cryptography")
    make_certificates(ours)
    make_certificates(theirs)
    shown = ("--protocol=tls", f"--tls-ca-file={ours / 'ca.pem'}", f"--tls-cert={ours / 'cert.pem'}")
    with scheduler_process(*shown, f"--tls-key={ours / 'key.pem'}") as (address, _):
        yield address


def test_cluster_with_certificates_computes_for_those_who_have_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ours, theirs = tmp_path / "ours", tmp_path / "theirs"
    with certified(ours, theirs) as address:
        assert address.startswith("tls://")
        with worker_process(address, f"--tls={ours}"):
            monkeypatch.setenv("DAMPERLAB_CLUSTER_TLS", str(ours))
            with connect(scheduler=address) as client:
                window = Window(client, lambda index, key: (_one, index), range(3))
                assert [each.points for each in pump(window)] == [1, 1, 1]
                monkeypatch.setattr("damperlab.worker.cluster.cluster.SCHEDULER_TIMEOUT_SECONDS", 2.0)
                # the certificate of another authority, none at all, and no encryption
                monkeypatch.setenv("DAMPERLAB_CLUSTER_TLS", str(theirs))
                with pytest.raises(ClusterUnusable), connect(scheduler=address):
                    pass
                monkeypatch.delenv("DAMPERLAB_CLUSTER_TLS")
                with (
                    pytest.raises(ClusterUnusable, match="DAMPERLAB_CLUSTER_TLS"),
                    connect(scheduler=address),
                ):
                    pass
                with pytest.raises(ClusterUnusable), connect(scheduler=address.replace("tls:", "tcp:")):
                    pass
                # a worker of theirs cannot join either
                with worker_process(address, f"--tls={theirs}") as stranger:
                    assert len(client.nthreads()) == 1
                    assert stranger.poll() is None or stranger.returncode != 0


def _one(index: int) -> BlockOutcome:
    return BlockOutcome(index, 1, 0, 0.0, 0.0)


def _environment() -> dict[str, str]:
    return dict(os.environ)


@pytest.mark.night
@pytest.mark.usefixtures("anew")
def test_embedded_cluster_is_reached_by_its_own_process_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("cryptography")
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "a secret of the store")
    monkeypatch.setenv("DAMPERLAB_CATALOGUE", "postgresql://a:secret@of.the/database")
    with connect(workers=1) as client:
        address = client.scheduler.address
        assert address.startswith("tls://127.0.0.1:")
        (worker,) = client.nthreads()
        assert worker.startswith("tls://")
        scheduler = client.run_on_scheduler(os.getpid)
        assert scheduler not in (os.getpid(), *client.run(os.getpid).values())
        known = " ".join(client.run_on_scheduler(_environment).values())
        assert "secret" not in known
        # a worker needs the keys of the store
        assert client.run(_environment)[worker]["AWS_SECRET_ACCESS_KEY"] == "a secret of the store"
        listening = [
            connection.laddr.port
            for process in (psutil.Process(), *psutil.Process().children(recursive=True))
            for connection in process.net_connections()
            if connection.status == psutil.CONN_LISTEN
        ]
        assert len(listening) >= 2
        monkeypatch.setattr("damperlab.worker.cluster.cluster.SCHEDULER_TIMEOUT_SECONDS", 2.0)
        for port in listening:
            for protocol, shown in (("tcp", Security()), ("tls", Security.temporary())):
                with pytest.raises(OSError):  # noqa: PT011  (not a word of Dask's comes back)
                    asyncio.run(_probe(f"{protocol}://127.0.0.1:{port}", shown))
    assert not psutil.pid_exists(scheduler)
