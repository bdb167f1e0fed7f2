"""Outdated results over HTTP and in the client: flagged, recomputed beside, compared, and deleted at once."""

from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
from tests.filling import enter, write
from tests.service.conftest import CURVE, ended, wait_for, wait_until
from tests.service.contract import check

from damperlab import Client
from damperlab.studies.definition import parse_study
from damperlab.studies.plan import Block
from damperlab.studies.store.store import Store
from damperlab.worker.block import solve_block

STUDIES = "/api/v1/studies"


def test_outdated_results_are_flagged_and_recomputed_beside(
    own_service: Callable[..., Any], tmp_path: Path
) -> None:
    """What another solver really computes is compared in `tests/worker/run/test_versions.py`."""
    study = parse_study(CURVE)
    whole = Block.whole(study.shape)
    values = {name: np.asarray(column) for name, column in solve_block(study, whole).items()}
    with closing(Store.open(tmp_path / "data")) as store:
        old = enter(store, study, study.shape, solver="another").id
        write(store, old, whole, values | {"amplitude_ratio": 2 * values["amplitude_ratio"]})
        store.set_state(old, "done")
    running = own_service()
    with running.client() as client, Client(running.url) as remote:
        again = client.post(STUDIES, json=CURVE)
        assert (again.status_code, again.json()["id"], again.json()["outdated"]) == (200, old, True)
        (listed,) = client.get(STUDIES).json()["studies"]
        assert (listed["outdated"], listed["version"]) == (True, 1)
        refused = client.post(f"{STUDIES}/{old}/retry")
        assert refused.status_code == 409
        assert refused.json()["type"] == "urn:damperlab:problem:nothing-to-do"
        assert "recompute" in refused.json()["errors"][0]["advice"]
        made = client.post(f"{STUDIES}/{old}/recompute")
        assert made.status_code == 201
        newer = made.json()["id"]
        assert made.headers["Location"] == f"{STUDIES}/{old}-2"
        done = wait_for(client, newer, ended)
        assert (done["state"], done["outdated"], done["version"]) == ("done", False, 2)
        assert client.post(STUDIES, json=CURVE).json()["id"] == newer
        assert client.post(f"{STUDIES}/{newer}/recompute").status_code == 409
        versions = client.get(f"{STUDIES}/{old}/versions").json()["studies"]
        assert [each["id"] for each in versions] == [old, newer]
        answer = client.get(f"{STUDIES}/{newer}/differences")
        check("get", f"{STUDIES}/{{study_id}}/differences", answer)
        found = answer.json()
        assert (found["older"], found["compared"], found["differing"]) == (old, 11, 11)
        before, after = remote.study(old), remote.study(newer)
        assert (before.outdated, after.outdated) == (True, False)
        # asked once more, the version that is there answers
        assert before.recompute() == after
        assert after.differences(before) == found
        one, two = (each.cube()["amplitude_ratio"].values for each in (before, after))
        np.testing.assert_array_equal(one, two * 2)
        before.delete()
        for path in ("", "/resonance-map", "/frequency-response", "/optimal-designs", "/axes"):
            gone = client.get(f"{STUDIES}/{old}{path}", follow_redirects=True)
            # the start of its id finds the version that took its place, for those who only look
            assert gone.status_code in (200, 422), gone.text
        assert client.delete(f"{STUDIES}/{old}").status_code == 404
        assert client.delete(f"{STUDIES}/{newer}").status_code == 204
        missing = client.get(f"{STUDIES}/{newer}/frequency-response")
        assert missing.status_code == 404
        assert "deleted 20" in missing.json()["errors"][0]["found"]
        cubes = tmp_path / "data" / "cubes"
        wait_until(lambda: not list(cubes.glob("*.zarr")))
