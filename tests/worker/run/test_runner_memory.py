"""A study of ten million points in a process of its own."""

import pytest
from tests.benchmarks.memory import measure_apart


@pytest.mark.night
def test_coordinator_holds_no_number_per_point() -> None:
    figures = measure_apart(10_000_000)
    assert figures["points"] == 10_000_000
    assert figures["state"] == "cancelled"
    assert figures["blocks_done"] >= 4
    assert figures["peak_mib"] < 1024
    # One number of eight bytes per point would take 76 MiB more than the imports do.
    assert figures["peak_mib"] - figures["after_import_mib"] < 8 * figures["points"] / 2**20
