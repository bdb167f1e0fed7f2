"""docker-compose.yml without Docker: each service's own command as a process, and a study through all of them.

What Docker would provide is put in its place by one substitution over commands and environments: names of hosts become
the loopback address, ports become free ones, volumes become folders. The object store is started by its own command; of the
database's image, which is not here, only the server: a real one, whose address stands in the place of the image's.
"""

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest
import yaml
from tests.faults.processes import Database
from tests.ports import free_port

from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.files.places import open_shelf

ROOT = Path(__file__).parents[2]
START_SECONDS = 300.0
WORK_SECONDS = 600.0
STORE_ROLES = ("master", "volume", "filer", "s3", "admin")
"""Parts of the object store that listen, each at two ports."""


def _compose() -> dict[str, Any]:
    document: dict[str, Any] = yaml.safe_load((ROOT / "docker-compose.yml").read_text())
    return document


def _wait(true: Callable[[], bool], process: subprocess.Popen[bytes], log: Path, seconds: float) -> None:
    give_up = time.monotonic() + seconds
    while not true():
        assert process.poll() is None, log.read_text()
        assert time.monotonic() < give_up, log.read_text()
        time.sleep(0.2)


@pytest.fixture
def stack(tmp_path: Path) -> Iterator[str]:
    """The address of the service, once every part is healthy by its own check."""
    compose = _compose()
    scheduler_port, service_port, store_port = (str(free_port()) for _ in range(3))
    database = Database(tmp_path / "database")
    folders = ("certificates", "database-key", "store-key", "objects", "data", "tmp")
    for folder in folders:
        (tmp_path / folder).mkdir()

    def here(text: str) -> str:
        text = re.sub(r"\bscheduler:8786\b", f"127.0.0.1:{scheduler_port}", text)
        text = text.replace('"scheduler"', '"127.0.0.1"').replace("0.0.0.0", "127.0.0.1")
        text = text.replace("objects:8333", "127.0.0.1:8333")
        for port, free in (("8786", scheduler_port), ("8000", service_port), ("8333", store_port)):
            text = re.sub(rf"\b{port}\b", free, text)
        text = re.sub(rf"(?<![\w/])/({'|'.join(folders)})\b", rf"{tmp_path}/\1", text)
        return text.replace("postgresql://damperlab@database/damperlab", database.address).replace("$$", "$")

    path = {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}

    # what is made once, at the first start
    command = [here(word) for word in compose["services"]["keys"]["command"]]
    made = []
    for _ in range(2):
        subprocess.run(command, check=True, env={**os.environ, **path}, timeout=START_SECONDS)
        kept = [
            *(f"certificates/{name}.pem" for name in ("ca", "cert", "key")),
            *("database-key/password", "database-key/pgpass", "store-key/env"),
        ]
        made.append([(tmp_path / name).read_text() for name in kept])
    assert made[0] == made[1]
    assert len(set(made[0])) == len(kept)
    assert (tmp_path / "database-key" / "pgpass").stat().st_mode & 0o777 == 0o600
    password = made[0][kept.index("database-key/password")].strip()
    assert len(password) == 48
    assert made[0][kept.index("database-key/pgpass")] == f"database:5432:damperlab:damperlab:{password}\n"

    started: list[tuple[str, subprocess.Popen[bytes]]] = []
    try:
        for name in ("objects", "scheduler", "worker", "service"):
            part = compose["services"][name]
            command = [here(word) for word in (*part.get("entrypoint", ()), *part["command"])]
            if name == "objects":
                # a container has all ports to itself
                flags = [f"{role}.port{kind}" for role in STORE_ROLES for kind in ("", ".grpc")]
                command[-1] += "".join(f" -{flag}={free_port()}" for flag in flags if flag != "s3.port")
            environment = {key: here(value) for key, value in part.get("environment", {}).items()}
            log = tmp_path / f"{name}.log"
            with log.open("wb") as out:
                process = subprocess.Popen(
                    command,
                    cwd=tmp_path,
                    env={**os.environ, **path, **environment},
                    stdout=out,
                    stderr=subprocess.STDOUT,
                )
            started.append((name, process))
            check = [here(word) for word in part["healthcheck"]["test"][1:]]

            def healthy(check: list[str] = check) -> bool:
                done = subprocess.run(
                    check, env={**os.environ, **path}, capture_output=True, timeout=30, check=False
                )
                return done.returncode == 0

            _wait(healthy, process, log, START_SECONDS)
        yield f"http://127.0.0.1:{service_port}"
        service = started.pop()[1]
        service.send_signal(signal.SIGTERM)
        assert service.wait(START_SECONDS) == 0, (tmp_path / "service.log").read_text()
    finally:
        for _, process in reversed(started):
            process.terminate()
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        database.close()


@pytest.mark.night
def test_study_runs_through_all_parts(stack: str, tmp_path: Path) -> None:
    study = {
        "name": "composed",
        "particle": False,
        "damping_ratio": 0.0038,
        "axes": {"friction_ratio": [0.0, 0.2, 0.6], "frequency_ratio": [0.9, 1.0, 1.1]},
    }
    with httpx.Client(base_url=f"{stack}/api/v1", timeout=60) as client:
        record = client.post("/studies", json=study).raise_for_status().json()
        give_up = time.monotonic() + WORK_SECONDS
        while record["state"] not in ("done", "failed", "cancelled"):
            assert time.monotonic() < give_up, record
            time.sleep(0.2)
            record = client.get(f"/studies/{record['id']}").raise_for_status().json()
        assert (record["state"], record["points_done"], record["points_failed"]) == ("done", 9, 0), record
        params = {"x": "frequency_ratio", "y": "friction_ratio", "metric": "relative_amplitude_ratio"}
        answer = client.get(f"/studies/{record['id']}/resonance-map", params=params).raise_for_status().json()
    # what was computed is in the object store, and not in the data folder
    assert not list((tmp_path / "data").rglob("zarr.json"))
    assert (answer["x"], answer["y"], answer["complete"]) == ([0.9, 1.0, 1.1], [0.0, 0.2, 0.6], 1.0)
    # Closed form without friction: |x - z|/Z = r²/√((1 - r²)² + (2ζr)²), at resonance 1/(2ζ).
    assert answer["values"][0][1] == pytest.approx(1 / (2 * 0.0038), rel=1e-9)
    # Friction only, at resonance (Den Hartog's exact solution).
    assert answer["values"][2][1] == pytest.approx(31.059792, rel=1e-6)


def test_cluster_is_reached_with_a_certificate_alone_and_nothing_grows_without_bound() -> None:
    services = _compose()["services"]
    assert services["service"]["environment"]["DAMPERLAB_SCHEDULER"].startswith("tls://")
    assert "--protocol=tls" in services["scheduler"]["command"]
    # the scheduler knows no data, the workers no database, and only who makes keys and certificates may write them
    assert services["scheduler"]["volumes"] == ["certificates:/certificates:ro"]
    assert services["worker"]["volumes"] == ["certificates:/certificates:ro", "store-key:/store-key:ro"]
    for name, part in services.items():
        secret = [each for each in part["volumes"] if re.match("certificates|.*-key", each)]
        assert all(each.endswith(":ro") is (name != "keys") for each in secret)
    assert all("mem_limit" in part and part["read_only"] for part in services.values())


def test_results_are_in_database_and_store_and_one_port_is_published_on_loopback() -> None:
    services = _compose()["services"]
    environment = services["service"]["environment"]
    assert (environment["DAMPERLAB_STORE"], environment["DAMPERLAB_DATA_DIR"]) == ("s3://cubes", "/data")
    assert "data:/data" in services["service"]["volumes"]
    assert environment["DAMPERLAB_CATALOGUE"].startswith("postgresql://")
    published = [port for part in services.values() for port in part.get("ports", [])]
    assert published == ["127.0.0.1:8000:8000"]
    lasting = [part for part in services.values() if part["restart"] != "no"]
    assert len(lasting) == 5
    assert all(part["healthcheck"]["test"][0] == "CMD" for part in lasting)
    assert all(":latest" not in part["image"] for part in services.values())


def test_store_is_opened_at_the_address_that_the_containers_are_given(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # the stack above has it on loopback, where more is allowed
    for name in ("service", "worker"):
        with monkeypatch.context() as patch:
            for key, value in _compose()["services"][name]["environment"].items():
                patch.setenv(key, value)
            patch.setenv("AWS_ACCESS_KEY_ID", "of-the-store")
            patch.setenv("AWS_SECRET_ACCESS_KEY", "made-at-the-first-start")
            assert open_shelf("s3://cubes").address == "s3://cubes"
            patch.delenv("AWS_ALLOW_HTTP")
            with pytest.raises(StoreFault, match="unencrypted"):
                open_shelf("s3://cubes")


def test_image_runs_as_a_user_and_installs_what_the_lock_file_says() -> None:
    lines = (ROOT / "Dockerfile").read_text().splitlines()
    assert any("--require-hashes -r requirements-image.lock" in line for line in lines)
    locked = (ROOT / "requirements-image.lock").read_text()
    # stores that a cluster uses, and its certificates
    assert all(f"\n{name}==" in locked for name in ("psycopg", "obstore", "cryptography"))
    user = next(line.split()[1] for line in lines if line.startswith("USER "))
    assert user not in ("root", "0")
    copied = [line.split()[1] for line in lines if line.startswith("COPY ")]
    assert all((ROOT / name).exists() for name in copied)
