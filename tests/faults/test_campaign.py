"""The short form of the fault campaign; `make faults` runs the long one."""

import pytest
from tests.faults.campaign import run_campaign

pytestmark = pytest.mark.night

KILLS = ("worker", "scheduler", "care", "service", "care", "worker", "all")
PATIENCE_SECONDS = 1200.0
"""Longer than any machine needs, however loaded: it ends a run that hangs, and judges none."""


def test_studies_end_as_if_nothing_had_been_killed() -> None:
    report = run_campaign(kills=KILLS, seed=7, patience=PATIENCE_SECONDS, rows=60)
    assert report.good, report.table()
    assert report.kills == {"worker": 2, "scheduler": 1, "care": 2, "service": 1, "all": 1}
    assert report.rounds > 0
    # every block was begun at least once, where the campaign could see it
    assert report.attempts >= report.blocks > 4
