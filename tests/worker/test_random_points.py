"""Random design points over the legal ranges: every one ends, and says truly how."""

import pytest
from tests.benchmarks.sweep import sweep

from damperlab.studies.variables import Status

POINTS = 2000


@pytest.mark.night
def test_every_random_point_ends_with_a_status_and_finite_values() -> None:
    """The million of them is a benchmark, `python -m tests.benchmarks.sweep`."""
    figures = sweep(POINTS, seed=20261121)
    assert figures["hangs"] == 0
    assert figures["found"] == []
    assert sum(figures["status"].values()) == POINTS
    failed = [name for name in figures["status"] if Status[name.upper()] > Status.MAX_CYCLES]
    assert sum(figures["status"][name] for name in failed) < POINTS // 50
