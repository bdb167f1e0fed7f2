"""docker-compose.yml without Docker: each service's own command as a process, and a study through all of them.

What Docker would provide is put in its place by one substitution over commands and environments: names of hosts become
the loopback address, ports become free ones, the volume becomes a folder.
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
from tests.ports import free_port

ROOT = Path(__file__).parents[2]
START_SECONDS = 300.0
WORK_SECONDS = 600.0


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
    scheduler_port, service_port = str(free_port()), str(free_port())
    data = tmp_path / "data"
    data.mkdir()

    def here(text: str) -> str:
        text = re.sub(r"\bscheduler:8786\b", f"127.0.0.1:{scheduler_port}", text)
        text = text.replace("'scheduler'", "'127.0.0.1'").replace("0.0.0.0", "127.0.0.1")
        text = re.sub(r"\b8786\b", scheduler_port, text)
        text = re.sub(r"\b8000\b", service_port, text)
        text = text.replace("/certificates", str(tmp_path / "certificates"))
        return re.sub(r"^/data$", str(data), text)

    # what is made once, at the first start
    made = compose["services"]["certificates"]
    command = [here(word) for word in made["command"]]
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    for _ in range(2):
        subprocess.run(command, check=True, env={**os.environ, "PATH": path}, timeout=START_SECONDS)
    assert sorted(file.name for file in (tmp_path / "certificates").iterdir()) == [
        "ca.pem",
        "cert.pem",
        "key.pem",
    ]

    started: list[tuple[str, subprocess.Popen[bytes]]] = []
    try:
        for name in ("scheduler", "worker", "service"):
            part = compose["services"][name]
            command = [here(word) for word in part["command"]]
            command[0] = str(Path(sys.executable).with_name(command[0]))
            environment = {key: here(value) for key, value in part.get("environment", {}).items()}
            log = tmp_path / f"{name}.log"
            with log.open("wb") as out:
                process = subprocess.Popen(
                    command,
                    cwd=tmp_path,
                    env={**os.environ, **environment},
                    stdout=out,
                    stderr=subprocess.STDOUT,
                )
            started.append((name, process))
            check = [here(word) for word in part["healthcheck"]["test"][1:]]
            check[0] = sys.executable

            def healthy(check: list[str] = check) -> bool:
                done = subprocess.run(check, capture_output=True, timeout=30, check=False)
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


def test_study_runs_through_scheduler_worker_and_service(stack: str) -> None:
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
    assert (answer["x"], answer["y"], answer["complete"]) == ([0.9, 1.0, 1.1], [0.0, 0.2, 0.6], 1.0)
    # Closed form without friction: |x - z|/Z = r²/√((1 - r²)² + (2ζr)²), at resonance 1/(2ζ).
    assert answer["values"][0][1] == pytest.approx(1 / (2 * 0.0038), rel=1e-9)
    # Friction only, at resonance (Den Hartog's exact solution).
    assert answer["values"][2][1] == pytest.approx(31.059792, rel=1e-6)


def test_cluster_is_reached_with_a_certificate_alone_and_nothing_grows_without_bound() -> None:
    services = _compose()["services"]
    assert services["service"]["environment"]["DAMPERLAB_SCHEDULER"].startswith("tls://")
    assert "--protocol=tls" in services["scheduler"]["command"]
    # the scheduler knows no data, and only who makes the certificates may write them
    assert services["scheduler"]["volumes"] == ["certificates:/certificates:ro"]
    assert services["certificates"]["volumes"] == ["certificates:/certificates"]
    assert all("mem_limit" in part and part["read_only"] for part in services.values())


def test_parts_share_one_volume_and_publish_on_loopback_alone() -> None:
    services = _compose()["services"]
    shared = ["data:/data", "certificates:/certificates:ro"]
    assert services["worker"]["volumes"] == services["service"]["volumes"] == shared
    assert services["service"]["environment"]["DAMPERLAB_DATA_DIR"] == "/data"
    published = [port for part in services.values() for port in part.get("ports", [])]
    assert published == ["127.0.0.1:8000:8000"]
    lasting = [part for part in services.values() if part["restart"] != "no"]
    assert len(lasting) == 3
    assert all(part["healthcheck"]["test"][0] == "CMD" for part in lasting)


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
