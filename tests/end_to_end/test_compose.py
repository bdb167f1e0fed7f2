"""docker-compose.yml without Docker: each service's own command as a process, and a study through all of them.

What Docker would provide is put in its place by one substitution over commands and environments: names of hosts become
the loopback address, ports become free ones, volumes become folders. The object store is started by its own command; of the
database's image, which is not here, only the server: a real one, whose address stands in the place of the image's.
"""

import os
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from tests.end_to_end.containers import PATH, Containers
from tests.faults.processes import Database
from tests.ports import free_port

from damperlab import Client
from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.files.folder import open_shelf

ROOT = Path(__file__).parents[2]
STORE_ROLES = ("master", "volume", "filer", "s3", "admin")
"""Parts of the object store that listen, each at two ports."""
VOLUMES = ("certificates", "database-key", "store-key", "objects", "data", "tmp")


def _compose() -> dict[str, Any]:
    document: dict[str, Any] = yaml.safe_load((ROOT / "docker-compose.yml").read_text())
    return document


class Stack(Containers):
    """The services, and a database of our own in the place of the image's."""

    database = ""

    def here(self, text: str) -> str:
        """Lead to the database, too."""
        text = super().here(text).replace("$$", "$")
        return text.replace("postgresql://damperlab@database/damperlab", self.database)


@pytest.fixture
def stack(tmp_path: Path) -> Iterator[str]:
    """The address of the service, once every part is healthy by its own check."""
    services = _compose()["services"]
    parts = Stack(tmp_path, {port: str(free_port()) for port in ("8786", "8000", "8333")}, VOLUMES)
    database = Database(tmp_path / "database")
    parts.database = database.address
    for folder in VOLUMES:
        (tmp_path / folder).mkdir()

    # what is made once, at the first start
    made = []
    for _ in range(2):
        command = [parts.here(word) for word in services["keys"]["command"]]
        subprocess.run(command, check=True, env={**os.environ, **PATH}, timeout=300)
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

    try:
        for name in ("objects", "scheduler", "worker", "service"):
            part = services[name]
            command = [*part.get("entrypoint", ()), *part["command"]]
            if name == "objects":
                # a container has all ports to itself
                flags = [f"{role}.port{kind}" for role in STORE_ROLES for kind in ("", ".grpc")]
                command[-1] += "".join(f" -{flag}={free_port()}" for flag in flags if flag != "s3.port")
            given = {key: parts.here(value) for key, value in part.get("environment", {}).items()}
            parts.start(name, command, given)
            parts.wait(name, lambda check=part["healthcheck"]["test"][1:]: parts.ends_well(check))
        yield f"http://127.0.0.1:{parts.ports['8000']}"
        parts.leave("service")
    finally:
        parts.kill()
        database.close()


@pytest.mark.night
def test_study_runs_through_all_parts(stack: str, tmp_path: Path) -> None:
    study = {
        "name": "composed",
        "particle": False,
        "damping_ratio": 0.0038,
        "axes": {"friction_ratio": [0.0, 0.2, 0.6], "frequency_ratio": [0.9, 1.0, 1.1]},
    }
    with Client(stack) as client:
        found = (
            client.submit(study)
            .wait(progress=False)
            .resonance_map("frequency_ratio", "friction_ratio", "relative_amplitude_ratio")
        )
    # what was computed is in the object store, and not in the data folder
    assert not list((tmp_path / "data").rglob("zarr.json"))
    assert (found.attrs["complete"], found.attrs["points_failed"]) == (1.0, 0)
    at_resonance = found["relative_amplitude_ratio"].sel(frequency_ratio=1.0)
    # Closed form without friction: |x - z|/Z = r²/√((1 - r²)² + (2ζr)²), at resonance 1/(2ζ).
    assert at_resonance.sel(friction_ratio=0.0).item() == pytest.approx(1 / (2 * 0.0038), rel=1e-9)
    # Friction only, at resonance (Den Hartog's exact solution).
    assert at_resonance.sel(friction_ratio=0.6).item() == pytest.approx(31.059792, rel=1e-6)


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
