"""What people say of a study is checked, every fault at once."""

from typing import Any

import pytest
from tests.studies.documents import faults_of

from damperlab.studies.remarks import MOST_NOTE, MOST_TAGS, Remarks, read_remarks


def test_tags_are_sorted_and_each_is_there_once_and_what_is_left_out_stays() -> None:
    assert read_remarks({"tags": ["steel", "rig-2", "steel"]}) == Remarks(("rig-2", "steel"), None)
    assert read_remarks({"note": " two\nlines\t"}) == Remarks(None, "two\nlines")
    assert read_remarks({"tags": [], "note": ""}) == Remarks((), "")
    assert read_remarks({"name": " rig 2, steel "}) == Remarks(name="rig 2, steel")


@pytest.mark.parametrize(
    ("document", "fields"),
    [
        ([], ["remarks"]),
        ({}, ["remarks"]),
        ({"tag": ["a"]}, ["tag"]),
        ({"tags": "rig"}, ["tags"]),
        ({"tags": ["Rig 2", "-a", "a" * 41, 3, "ok"]}, ["tags"] * 4),
        ({"tags": ["A"] * 7000}, ["tags"]),
        ({"tags": [3, "3"]}, ["tags"]),
        ({"tags": [f"t{i}" for i in range(MOST_TAGS + 1)]}, ["tags"]),
        ({"note": "n" * (MOST_NOTE + 1), "tags": [""]}, ["tags", "note"]),
        ({"note": "a\x00b"}, ["note"]),
        ({"note": 3}, ["note"]),
        ({"name": "two\nlines"}, ["name"]),
        ({"name": ""}, ["name"]),
        ({"name": "  "}, ["name"]),
    ],
)
def test_what_cannot_be_kept_is_refused(document: Any, fields: list[str]) -> None:
    faults = faults_of(read_remarks, document)
    assert [fault.field for fault in faults] == fields
    assert all(len(str(fault)) < 400 for fault in faults)
