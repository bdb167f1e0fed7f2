"""Outdated results over HTTP and in the client: flagged, recomputed beside, compared, and deleted at once."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from tests.other_solver import SCALE, OtherSolver
from tests.service.contract import check

from damperlab import Client

STUDIES = "/api/v1/studies"


@pytest.fixture(scope="module")
def other(tmp_path_factory: pytest.TempPathFactory) -> OtherSolver:
    return OtherSolver(tmp_path_factory.mktemp("other"))


def test_outdated_results_are_flagged_and_recomputed_beside(
    own_service: Callable[..., Any], other: OtherSolver, tmp_path: Path, helpers: Any
) -> None:
    file = tmp_path / "curve.json"
    file.write_text(httpx.Response(200, json=helpers.CURVE).text)
    old = other.run("run", str(file), "--data-dir", str(tmp_path / "data"))
    running = own_service()
    with httpx.Client(base_url=running.url, timeout=300) as http:
        again = http.post(STUDIES, json=helpers.CURVE)
        assert (again.status_code, again.json()["id"], again.json()["outdated"]) == (200, old["id"], True)
        (listed,) = http.get(STUDIES).json()["studies"]
        assert (listed["outdated"], listed["version"]) == (True, 1)
        refused = http.post(f"{STUDIES}/{old['id']}/retry")
        assert refused.status_code == 409
        assert refused.json()["type"] == "urn:damperlab:problem:nothing-to-do"
        assert "recompute" in refused.json()["errors"][0]["advice"]
        made = http.post(f"{STUDIES}/{old['id']}/recompute")
        assert made.status_code == 201
        newer = made.json()
        assert made.headers["Location"] == f"{STUDIES}/{old['id']}-2"
        done = helpers.wait_for(http, newer["id"], helpers.ended)
        assert (done["state"], done["outdated"], done["version"]) == ("done", False, 2)
        assert http.post(STUDIES, json=helpers.CURVE).json()["id"] == newer["id"]
        assert http.post(f"{STUDIES}/{newer['id']}/recompute").status_code == 409
        versions = http.get(f"{STUDIES}/{old['id']}/versions").json()["studies"]
        assert [each["id"] for each in versions] == [old["id"], newer["id"]]
        answer = http.get(f"{STUDIES}/{newer['id']}/differences")
        check("get", f"{STUDIES}/{{study_id}}/differences", answer)
        found = answer.json()
        assert (found["older"], found["compared"], found["differing"]) == (old["id"], 11, 11)
    with Client(running.url) as client:
        before, after = client.study(old["id"]), client.study(newer["id"])
        assert (before.outdated, after.outdated) == (True, False)
        # asked once more, the version that is there answers
        assert before.recompute() == after
        assert {each["variable"] for each in after.differences(before)["variables"]} >= {"amplitude_ratio"}
        one, two = (each.cube()["amplitude_ratio"].values for each in (before, after))
        np.testing.assert_array_equal(one, two * SCALE)
        before.delete()
    with httpx.Client(base_url=running.url, timeout=300) as http:
        for path in ("", "/resonance-map", "/frequency-response", "/optimal-designs", "/axes"):
            gone = http.get(f"{STUDIES}/{old['id']}{path}", follow_redirects=True)
            # the start of its id finds the version that took its place, for those who only look
            assert gone.status_code in (200, 422), gone.text
        assert http.delete(f"{STUDIES}/{old['id']}").status_code == 404
        assert http.delete(f"{STUDIES}/{newer['id']}").status_code == 204
        missing = http.get(f"{STUDIES}/{newer['id']}/frequency-response")
        assert missing.status_code == 404
        assert "deleted 20" in missing.json()["errors"][0]["found"]
        cubes = tmp_path / "data" / "cubes"
        helpers.wait_until(lambda: not list(cubes.glob("*.zarr")))
