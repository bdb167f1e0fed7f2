"""The manifests without a cluster: held against the published schemas and each other, and their commands run as processes.

What Kubernetes would provide is put in its place by one substitution: names of Services become the loopback address, ports
become free ones, volumes become folders, Secrets become the variables and files that the documentation says to put there.
"""

import json
import os
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import kubernetes_validate
import pytest
import yaml
from tests.end_to_end.containers import PATH, Containers
from tests.faults.processes import Database, ObjectServer
from tests.ports import free_port

from damperlab import Client

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "deploy" / "kubernetes"
VERSIONS = ("1.30", "1.37")
"""The oldest and newest version of Kubernetes whose schemas the manifests are held against."""
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


class Pods(Containers):
    """The containers of the pods, and their Secrets as the documentation says to make them."""

    def __init__(self, folder: Path) -> None:
        ports = {port: str(free_port()) for port in ("8786", "8000")}
        super().__init__(folder, ports, ("certificates", "data", "tmp"))
        self.secrets: dict[str, dict[str, str]] = {}

    def environment(self, part: Document) -> dict[str, str]:
        """Give the variables of a container."""
        given: dict[str, str] = {}
        for each in part.get("envFrom", []):
            given |= self.secrets[each["secretRef"]["name"]]
        return given | {each["name"]: self.here(each["value"]) for each in part.get("env", [])}

    def run(self, name: str) -> None:
        """Start a part and wait until every probe of it is content."""
        part = pods()[name]["spec"]["containers"][0]
        self.start(name, part["args"], self.environment(part))
        for kind in ("startupProbe", "livenessProbe", "readinessProbe"):
            if kind in part:
                self.wait(name, lambda probe=part[kind]: self.content(probe))

    def content(self, probe: Document) -> bool:
        """Ask a probe."""
        if "exec" in probe:
            return self.ends_well(probe["exec"]["command"])
        asked = probe["httpGet"]
        headers = {each["name"]: each["value"] for each in asked["httpHeaders"]}
        try:
            url = f"http://127.0.0.1:{self.ports['8000']}{asked['path']}"
            return httpx.get(url, headers=headers, timeout=probe.get("timeoutSeconds", 1)).status_code == 200
        except httpx.HTTPError:
            return False


@pytest.fixture
def running(tmp_path: Path) -> Iterator[Pods]:
    found = Pods(tmp_path)
    for folder in ("data", "tmp"):
        (tmp_path / folder).mkdir()
    database = Database(tmp_path / "database")
    objects = ObjectServer(tmp_path / "objects")
    try:
        objects.wait()
        found.secrets = {
            "damperlab-store": objects.environment | {"DAMPERLAB_STORE": objects.address},
            "damperlab-catalogue": {"DAMPERLAB_CATALOGUE": database.address},
        }
        assert found.ends_well(["damperlab", "admin", "certificates", "/certificates"])
        yield found
    finally:
        found.kill()
        objects.kill()
        database.close()


@pytest.mark.night
def test_study_runs_through_the_containers_commands_and_a_worker_leaves_well(running: Pods) -> None:
    part = pods()["first-key"]["spec"]["containers"][0]
    command = [*(running.here(word) for word in part["args"]), "--json"]
    environment = {**os.environ, **PATH, **running.environment(part)}
    told = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    for name in ("scheduler", "worker", "service"):
        running.run(name)
    key = json.loads(told.stdout)["key"]
    study = {
        "particle": False,
        "damping_ratio": 0.0038,
        "axes": {"friction_ratio": [0.0, 0.6], "frequency_ratio": 1.0},
    }
    url = f"http://127.0.0.1:{running.ports['8000']}"
    with Client(url, api_key=key) as client:
        assert client.submit(study).wait(progress=False).record.points_failed == 0
    told_of = httpx.get(f"{url}/metrics", headers={"Authorization": f"Bearer {key}"}, timeout=60)
    # the number that the autoscaler goes by
    assert "\ndamperlab_blocks_left 0\n" in told_of.raise_for_status().text
    # the service first, as its scheduler's client
    for name in ("service", "worker"):
        running.leave(name)
