"""The short form of the fault campaign; `make faults` runs the long one."""

from tests.faults.campaign import run_campaign


def test_studies_end_as_if_nothing_had_been_killed() -> None:
    report = run_campaign(kills=4, seed=7, patience=200.0, rows=30)
    assert report.good, report
    assert sum(report.kills.values()) == 4
    assert report.blocks > 4
