"""Times that must stand in a relation; other tests shorten them one by one, so none of those would see it broken."""

from pathlib import Path

import fastapi.sse
import yaml

from damperlab.service import app, designer, dispatch
from damperlab.service.client import transport, waiting
from damperlab.service.security import guard, sessions
from damperlab.service.work import later
from damperlab.studies.store.care import sweep
from damperlab.studies.store.files import bucket
from damperlab.studies.store.life_cycle import claims
from damperlab.worker.cluster import batch
from damperlab.worker.run import lease, runner
from damperlab.worker.worker_process import examination, worker

ROOT = Path(__file__).parent.parent


def test_a_claim_outlives_renewals_that_a_slow_store_delays() -> None:
    assert 3 * lease.RENEW_SECONDS < claims.CLAIM_SECONDS
    # a renewal over a bucket's catalogue may wait as long as one request to it
    assert lease.RENEW_SECONDS + bucket.REQUEST_SECONDS + bucket.RETRY_SECONDS < claims.CLAIM_SECONDS


def test_files_of_a_run_under_way_are_older_than_its_claim_before_they_are_swept() -> None:
    assert claims.CLAIM_SECONDS < sweep.LEFT_ALONE_SECONDS < sweep.ORPHAN_SECONDS


def test_a_shutdown_outlives_what_it_waits_for() -> None:
    assert runner.GRACE_SECONDS < dispatch.STOP_SECONDS
    assert app.DRAIN_SECONDS + designer.STOP_SECONDS + dispatch.STOP_SECONDS < app.SHUTDOWN_SECONDS


def test_who_ends_containers_waits_longer_than_what_runs_in_them() -> None:
    least = {"service": app.SHUTDOWN_SECONDS, "worker": batch.LEAVE_SECONDS, "workers": batch.LEAVE_SECONDS}
    graces = [
        (name, float(each["stop_grace_period"].removesuffix("s")))
        for name, each in yaml.safe_load((ROOT / "docker-compose.yml").read_text())["services"].items()
        if "stop_grace_period" in each
    ]
    for file in (ROOT / "deploy" / "kubernetes").glob("*.yaml"):
        for part in yaml.safe_load_all(file.read_text()):
            pod = ((part or {}).get("spec") or {}).get("template", {}).get("spec", {})
            if "terminationGracePeriodSeconds" in pod:
                graces.append((file.stem, pod["terminationGracePeriodSeconds"]))
    assert sorted(name for name, _ in graces) == ["service", "service", "worker", "workers"]
    assert [(name, grace) for name, grace in graces if grace <= least[name]] == []


def test_a_client_waits_longer_than_the_service_is_silent() -> None:
    assert fastapi.sse._PING_INTERVAL < waiting.SILENCE_SECONDS
    assert later.WAIT_SECONDS <= later.LONGEST_WAIT_SECONDS < later.KEPT_SECONDS
    assert transport.PROMISE_PAUSE_SECONDS < transport.PATIENCE_SECONDS


def test_a_job_has_time_to_start_to_work_and_to_leave() -> None:
    assert batch.MARGIN_SECONDS + batch.LEAVE_SECONDS < batch.SHORTEST_SECONDS < batch.IDLE_SECONDS
    assert examination.EVERY_SECONDS < batch.LEAVE_SECONDS


def test_a_worker_has_left_before_the_cloud_takes_its_machine() -> None:
    announced = 30.0  # the shortest notice of the three large clouds, Google's
    assert worker.LOOK_SECONDS + worker.Terms().leave_within_s < announced


def test_a_revoked_key_is_refused_while_whoever_revoked_it_looks_on() -> None:
    assert guard.KEPT_SECONDS < 10.0 < sessions.LASTS_SECONDS
