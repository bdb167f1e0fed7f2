"""The choices of a study: what is refused of them, and what is advised."""

from typing import Any

import pytest

from damperlab.studies.definition import parse_study
from damperlab.studies.faults import Fault, StudyFaults

NO_WORD = "choose one of these"


def faults_of(part: dict[str, Any]) -> tuple[Fault, ...]:
    with pytest.raises(StudyFaults) as refused:
        parse_study({"axes": {"clearance_ratio": 3, "frequency_ratio": 1}} | part)
    return refused.value.faults


@pytest.mark.parametrize(
    ("part", "advice"),
    [
        ({"contact": {"model": "dwel"}}, "write dwell"),
        ({"contact": {"model": "sandstone"}}, NO_WORD),
        ({"start": "rset"}, "write rest"),
        ({"start": {"kind": "continuatoin"}}, "write continuation"),
        ({"start": {"kind": "elsewhere"}}, NO_WORD),
        ({"solver": {"method": "evnt"}}, "write event"),
        ({"excitation": "bas"}, "write base"),
        ({"excitation": "moon"}, NO_WORD),
    ],
)
def test_a_word_is_advised_where_one_is_near(part: dict[str, Any], advice: str) -> None:
    (fault,) = faults_of(part)
    assert fault.advice == advice


def test_a_start_from_rest_may_be_written_as_those_with_settings_are() -> None:
    axes = {"axes": {"clearance_ratio": 3, "frequency_ratio": 1}}
    assert (
        parse_study(axes | {"start": {"kind": "rest"}})
        == parse_study(axes | {"start": "rest"})
        == parse_study(axes)
    )


def test_a_start_without_its_kind_is_told_so_and_what_of_it_is_unknown() -> None:
    missing, unknown = faults_of({"start": {"ensemble": {"n": 4}}})
    assert (missing.field, missing.found) == ("start.kind", "nothing")
    assert "`kind: ensemble`" in missing.advice
    assert unknown.field == "start.ensemble"
    assert "kind, n, seed, direction" in unknown.allowed
    (alone,) = faults_of({"start": {"n": 4}})
    assert (alone.field, alone.found) == ("start.kind", "nothing")
