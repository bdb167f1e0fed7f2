"""The short form of the campaign over hosts, in a process of its own, which enters a host; `make faults` runs the long one."""

import json
import subprocess
import sys

import pytest
from tests.faults.hosts import NoHosts, hosts

pytestmark = pytest.mark.night

FAULTS = (
    "worker without keys joins",
    "worker host killed",
    "stale worker joins",
    "storage cut off",
    "service killed",
)
SECONDS = 1800.0
"""Longer than any machine needs, however loaded: it ends a run that hangs, and judges none."""


def test_studies_end_as_if_no_host_had_failed() -> None:
    pytest.importorskip("cryptography")
    try:
        with hosts("probe"):
            pass
    except NoHosts as error:
        pytest.skip(str(error))
    only = (word for fault in FAULTS for word in ("--only", fault))
    command = [sys.executable, "-m", "tests.faults.network", "--json", "--seed", "7", "--rows", "60", *only]
    done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, check=False)
    assert done.returncode == 0, done.stdout + done.stderr[-4000:]
    report = json.loads(done.stdout)
    assert report["kills"] == dict.fromkeys(FAULTS, 1)
    assert report["studies"] > 0
