"""The short form of the damage campaign; `make faults` runs the long one."""

import pytest
from tests.faults.damage import run_damage


@pytest.mark.night
def test_no_flipped_bit_and_no_lost_file_changes_an_answer_in_silence() -> None:
    report = run_damage(60, seed=5)
    assert not report.defects, report.table()
    assert {outcome for _, outcome in report.outcomes} <= {"found", "refused", "harmless"}
    assert {kind for kind, _ in report.outcomes} >= {"block", "catalogue", "description", "marks", "axis"}
