"""The manifests without a cluster: held against the published schemas and each other, and their commands run as processes.

What Kubernetes would provide is put in its place by one substitution: names of Services become the loopback address, ports
become free ones, volumes become folders, Secrets become the variables and files that the documentation says to put there.
"""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import httpx
import kubernetes_validate
import pytest
import yaml
from tests.faults.processes import Database, ObjectServer
from tests.ports import free_port

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "deploy" / "kubernetes"
VERSIONS = ("1.30", "1.37")
"""The oldest and newest version of Kubernetes whose schemas the manifests are held against."""
START_SECONDS = 600.0
Document = dict[str, Any]


def documents(*names: str) -> list[Document]:
    return [each for name in names for each in yaml.safe_load_all((FOLDER / name).read_text())]


def resources() -> list[Document]:
    return documents(*yaml.safe_load((FOLDER / "kustomization.yaml").read_text())["resources"])


def pods() -> dict[str, Document]:
    """Templates of pods, by what makes them."""
    found = [*resources(), *documents("first-key.yaml")]
    return {
        one["metadata"]["name"]: one["spec"]["template"] for one in found if "template" in one.get("spec", {})
    }


def of_kind(kind: str) -> list[Document]:
    return [one for one in resources() if one["kind"] == kind]


def fits(selector: Document, template: Document) -> bool:
    return selector.items() <= template["metadata"]["labels"].items()


@pytest.mark.parametrize("version", VERSIONS)
def test_every_manifest_is_as_the_published_schemas_say(version: str) -> None:
    every = [*resources(), *documents("first-key.yaml")]
    assert len(every) == 15
    for one in every:
        kubernetes_validate.validate(one, version, strict=True)
    broken = documents("scheduler.yaml")[0]
    broken["spec"]["template"]["spec"]["containers"][0]["port"] = 8786
    with pytest.raises(kubernetes_validate.ValidationError):
        kubernetes_validate.validate(broken, version, strict=True)


def test_kustomize_makes_of_them_what_stands_in_the_files() -> None:
    if shutil.which("kubectl") is None:
        pytest.skip("there is no kubectl here")
    made = subprocess.run(["kubectl", "kustomize", str(FOLDER)], capture_output=True, text=True, check=True)
    found = list(yaml.safe_load_all(made.stdout))
    names = {(one["kind"], one["metadata"]["name"]) for one in found}
    assert names == {(one["kind"], one["metadata"]["name"]) for one in resources()}
    assert {one["metadata"].get("namespace") for one in found if one["kind"] != "Namespace"} == {"damperlab"}
    images = re.findall(r"image: (.*)", made.stdout)
    job = documents("first-key.yaml")[0]["spec"]["template"]["spec"]["containers"][0]["image"]
    assert set(images) == {job}


def test_no_pod_may_do_more_than_it_must() -> None:
    for name, template in pods().items():
        spec = template["spec"]
        assert spec["automountServiceAccountToken"] is False, name
        # else a Service's address would stand in a DAMPERLAB_… variable
        assert spec["enableServiceLinks"] is False, name
        assert spec["securityContext"]["runAsNonRoot"], name
        for part in spec["containers"]:
            confined = part["securityContext"]
            assert (confined["readOnlyRootFilesystem"], confined["allowPrivilegeEscalation"]) == (True, False)
            assert confined["capabilities"] == {"drop": ["ALL"]}
            assert (
                {"cpu", "memory"}
                == part["resources"]["limits"].keys()
                == part["resources"]["requests"].keys()
            )
    store, catalogue = "damperlab-store", "damperlab-catalogue"
    # the scheduler knows no data, the workers no database
    assert secrets(pods()["scheduler"]) == {"damperlab-certificates"}
    assert secrets(pods()["worker"]) == {"damperlab-certificates", store}
    assert secrets(pods()["service"]) == {"damperlab-certificates", store, catalogue}


def secrets(template: Document) -> set[str]:
    spec = template["spec"]
    variables = {each["secretRef"]["name"] for part in spec["containers"] for each in part.get("envFrom", [])}
    return variables | {each["secret"]["secretName"] for each in spec["volumes"] if "secret" in each}


def test_what_names_something_names_what_is_there() -> None:
    deployments = {one["metadata"]["name"]: one["spec"] for one in of_kind("Deployment")}
    for spec in deployments.values():
        assert fits(spec["selector"]["matchLabels"], spec["template"])
    for service in of_kind("Service"):
        (target,) = [one for one in pods().values() if fits(service["spec"]["selector"], one)]
        named = {port["name"] for part in target["spec"]["containers"] for port in part.get("ports", [])}
        assert {port["targetPort"] for port in service["spec"]["ports"]} <= named
    (scaler,) = of_kind("HorizontalPodAutoscaler")
    assert scaler["spec"]["scaleTargetRef"]["name"] in deployments
    # the autoscaler says how many
    assert "replicas" not in deployments["worker"]
    (budget,) = of_kind("PodDisruptionBudget")
    assert fits(budget["spec"]["selector"]["matchLabels"], deployments["worker"]["template"])
    for name, spec in deployments.items():
        patience = spec["template"]["spec"].get("terminationGracePeriodSeconds", 30)
        words = spec["template"]["spec"]["containers"][0]["args"]
        leaves = [float(words[place + 1]) for place, word in enumerate(words) if word == "--leave-within"]
        assert all(seconds < patience for seconds in leaves), name


def test_page_for_operators_makes_the_secrets_that_the_pods_take() -> None:
    page = (ROOT / "docs" / "how-to" / "kubernetes.md").read_text()
    made = set(re.findall(r"create secret generic (\S+)", page))
    assert made == set().union(*map(secrets, pods().values()))
    metric = of_kind("HorizontalPodAutoscaler")[0]["spec"]["metrics"][0]["external"]["metric"]["name"]
    assert metric in page


class Parts:
    """The containers' own commands on this machine."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.ports = {"8786": str(free_port()), "8000": str(free_port())}
        self.running: dict[str, subprocess.Popen[bytes]] = {}
        self.path = {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
        self.secrets: dict[str, dict[str, str]] = {}

    def here(self, text: str) -> str:
        """Put what is here in the place of what a cluster provides."""
        text = text.replace("scheduler:8786", "127.0.0.1:8786").replace("0.0.0.0", "127.0.0.1")
        for port, free in self.ports.items():
            text = re.sub(rf"\b{port}\b", free, text)
        return re.sub(r"(?<![\w/])/(certificates|data|tmp)\b", rf"{self.folder}/\1", text)

    def environment(self, part: Document) -> dict[str, str]:
        """Give the variables of a container."""
        given: dict[str, str] = {}
        for each in part.get("envFrom", []):
            given |= self.secrets[each["secretRef"]["name"]]
        given |= {each["name"]: self.here(each["value"]) for each in part.get("env", [])}
        return {**os.environ, **self.path, **given}

    def command(self, name: str) -> tuple[list[str], Document]:
        """Give the command of a pod's container, and the container."""
        part = pods()[name]["spec"]["containers"][0]
        return [self.here(word) for word in part["args"]], part

    def start(self, name: str) -> None:
        """Start a part and wait until every probe of it is content."""
        command, part = self.command(name)
        log = self.folder / f"{name}.log"
        with log.open("wb") as out:
            process = subprocess.Popen(
                command, cwd=self.folder, env=self.environment(part), stdout=out, stderr=subprocess.STDOUT
            )
        self.running[name] = process
        for kind in ("startupProbe", "livenessProbe", "readinessProbe"):
            if kind in part:
                self.wait(lambda probe=part[kind]: self.content(probe), process, log)

    def content(self, probe: Document) -> bool:
        """Ask a probe."""
        if "exec" in probe:
            command = [self.here(word) for word in probe["exec"]["command"]]
            return (
                subprocess.run(
                    command, env={**os.environ, **self.path}, capture_output=True, check=False
                ).returncode
                == 0
            )
        asked = probe["httpGet"]
        headers = {each["name"]: each["value"] for each in asked["httpHeaders"]}
        try:
            url = f"http://127.0.0.1:{self.ports['8000']}{asked['path']}"
            return httpx.get(url, headers=headers, timeout=probe.get("timeoutSeconds", 1)).status_code == 200
        except httpx.HTTPError:
            return False

    def wait(self, true: Callable[[], bool], process: subprocess.Popen[bytes], log: Path) -> None:
        """Wait until something is so, while a process runs."""
        give_up = time.monotonic() + START_SECONDS
        while not true():
            assert process.poll() is None, log.read_text()
            assert time.monotonic() < give_up, log.read_text()
            time.sleep(0.2)


@pytest.fixture
def parts(tmp_path: Path) -> Iterator[Parts]:
    found = Parts(tmp_path)
    for folder in ("data", "tmp"):
        (tmp_path / folder).mkdir()
    database = Database(tmp_path / "database")
    objects = ObjectServer(tmp_path / "objects")
    try:
        os.environ.update(objects.environment)
        objects.wait()
        for name in objects.environment:
            del os.environ[name]
        found.secrets = {
            "damperlab-store": objects.environment | {"DAMPERLAB_STORE": objects.address},
            "damperlab-catalogue": {"DAMPERLAB_CATALOGUE": database.address},
        }
        made = ("damperlab", "certificates", str(tmp_path / "certificates"))
        subprocess.run(made, env={**os.environ, **found.path}, check=True, capture_output=True)
        yield found
    finally:
        for process in reversed(found.running.values()):
            process.kill()
            process.wait()
        objects.kill()
        database.close()


@pytest.mark.night
def test_study_runs_through_the_containers_commands_and_a_worker_leaves_well(parts: Parts) -> None:
    command, part = parts.command("first-key")
    told = subprocess.run(
        [*command, "--json"], env=parts.environment(part), capture_output=True, text=True, check=True
    )
    for name in ("scheduler", "worker", "service"):
        parts.start(name)
    headers = {"Authorization": f"Bearer {json.loads(told.stdout)['key']}"}
    study = {"particle": False, "axes": {"friction_ratio": [0.0, 0.6], "frequency_ratio": 1.0}}
    with httpx.Client(
        base_url=f"http://127.0.0.1:{parts.ports['8000']}", headers=headers, timeout=60
    ) as client:
        record = (
            client.post("/api/v1/studies", json=study | {"damping_ratio": 0.0038}).raise_for_status().json()
        )
        give_up = time.monotonic() + START_SECONDS
        while record["state"] not in ("done", "failed", "cancelled"):
            assert time.monotonic() < give_up, record
            time.sleep(0.2)
            record = client.get(f"/api/v1/studies/{record['id']}").raise_for_status().json()
        assert (record["state"], record["points_failed"]) == ("done", 0), record
        # the number that the autoscaler goes by
        assert "\ndamperlab_blocks_left 0\n" in client.get("/metrics").raise_for_status().text
    # the service first, as its scheduler's client
    for name in ("service", "worker"):
        parts.running[name].send_signal(signal.SIGTERM)
        assert parts.running[name].wait(START_SECONDS) == 0, (parts.folder / f"{name}.log").read_text()
