"""The short form of the readers beside a writer; `make faults` runs the long one."""

import pytest
from tests.faults.readers import READERS
from tests.faults.reading import run_reading

pytestmark = pytest.mark.night

PATIENCE_SECONDS = 1200.0
"""Longer than any machine needs, however loaded: it ends a run that hangs, and judges none."""


def test_no_slice_is_torn_mixed_or_stale_while_a_study_is_overwritten_and_deleted() -> None:
    result = run_reading(600, seed=5, patience=PATIENCE_SECONDS)
    assert not result.wrong, result.wrong[:10]
    assert result.reads == dict.fromkeys(READERS, 120)
    assert sum(result.writes.values()) > 5
