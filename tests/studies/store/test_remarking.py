"""Tags and notes in the catalogue: they change no digest, and studies are found by them and by what they vary."""

from pathlib import Path

import pytest
from tests.filling import enter, make_plan_of, make_study, write_behind

from damperlab.studies.remarks import Remarks
from damperlab.studies.store.care.verify import verify
from damperlab.studies.store.catalogue.tables import studies
from damperlab.studies.store.faults import StoreFault, StudyNotFound
from damperlab.studies.store.life_cycle.lookup import Wanted
from damperlab.studies.store.life_cycle.manifest import MARKS, marks_put_off, read_marks
from damperlab.studies.store.store import Store


def names(store, **wanted):
    return [record.name for record in store.page(wanted=Wanted(**wanted)).records]


def put_off(store, study_id):
    """Whether the catalogue notes that the study's marks must still be written into its cube."""
    with store.catalogue.reading() as connection:
        return marks_put_off(connection, study_id) is not None


def test_remarks_stay_with_their_study_and_change_nothing_else(store):
    record = enter(store, make_study())
    assert (record.tags, record.note) == ((), "")
    now = store.remark(record.id, Remarks(("rig-2", "steel"), "first"))
    assert store.remark(record.id, Remarks(note="second")).tags == ("rig-2", "steel")
    now = store.remark(record.id, Remarks(tags=("steel",)))
    assert (now.tags, now.note) == (("steel",), "second")
    now = store.remark(record.id, Remarks(name="steel rig"))
    assert (now.name, now.definition) == ("steel rig", record.definition)
    changed = {"tags": [], "note": "", "name": record.name}
    assert now.document() | changed == record.document()
    # the same definition is the same study still
    again, created = store.submit(make_study("another name"), make_plan_of(make_study()), {})
    assert (again.id, created, again.tags) == (record.id, False, ("steel",))
    with pytest.raises(StudyNotFound):
        store.remark("0" * 12, Remarks(note="n"))


def test_a_row_of_before_keeps_its_checksum_and_a_changed_remark_is_told(store):
    record = enter(store, make_study())
    with store.catalogue.reading() as connection:
        before = connection.execute(studies.select()).one().crc
    store.remark(record.id, Remarks(("a",), "n"))
    store.remark(record.id, Remarks((), ""))
    with store.catalogue.reading() as connection:
        assert connection.execute(studies.select()).one().crc == before
    store.remark(record.id, Remarks(("a",), "n"))
    store.close()

    write_behind(store.data_dir, "UPDATE studies SET note = 'm'")
    again = Store.open(store.data_dir)
    with pytest.raises(StoreFault, match="damaged"):
        again.find(record.id)
    again.close()


def test_a_tag_is_found_whole(store):
    for place, tags in enumerate((("rig",), ("rig-2",), ("a", "rig"), ())):
        study = make_study(f"study {place}", damping_ratio=0.01 * (place + 1))
        store.remark(enter(store, study).id, Remarks(tags))
    assert names(store, tag="rig") == ["study 2", "study 0"]
    assert names(store, tag="rig-2") == ["study 1"]
    assert names(store, tag="ri") == []
    assert names(store, tag="rig", name="study 0") == ["study 0"]
    for bad in ('rig"', "rig%", "Rig", ""):
        with pytest.raises(StoreFault):
            Wanted(tag=bad)


def test_studies_are_found_by_what_they_vary(store):
    axes = {"friction_ratio": 0.1, "restitution": 0.47, "mass_ratio": 0.1, "frequency_ratio": [0.9, 1.1]}
    for low, high in ((1.0, 2.0), (3.0, 5.0), (6.0, 9.0)):
        study = make_study(f"{low:g} to {high:g}", axes=axes | {"clearance_ratio": [low, high]})
        enter(store, study, (1,) * 6)
    found = {
        (None, None): ["6 to 9", "3 to 5", "1 to 2"],
        (2.5, 4.0): ["3 to 5"],
        (4.0, 4.5): ["3 to 5"],
        (5.0, 6.0): ["6 to 9", "3 to 5"],
        (5.5, 5.9): [],
        (None, 2.9): ["1 to 2"],
        (9.0, None): ["6 to 9"],
    }
    for (low, high), expected in found.items():
        assert names(store, axis="clearance_ratio", low=low, high=high) == expected, (low, high)
    assert names(store, axis="clearance_m") == []


def test_studies_in_units_are_found_by_what_they_say_in_units(store):
    physical = {"mass_kg": 1.3, "natural_frequency_hz": 8.0, "base_amplitude_m": 0.001}
    physical |= {"excitation_frequency_hz": [7.5, 8.5]}
    axes = {"friction_ratio": [0.1, 0.2], "restitution": 0.47, "mass_ratio": 0.1}
    spelled = {"list": [0.003, 0.02], "range": {"start": 0.03, "stop": 0.05, "num": 3}, "number": 0.06}
    for name, clearance in spelled.items():
        study = make_study(name, axes=axes, physical=physical | {"clearance_m": clearance})
        enter(store, study, (1,) * 6)
    assert names(store, axis="clearance_m", high=0.0021) == []
    assert names(store, axis="clearance_m", low=0.004, high=0.005) == ["list"]
    assert names(store, axis="clearance_m", low=0.02, high=0.031) == ["range", "list"]
    assert names(store, axis="clearance_m", low=0.06) == ["number"]
    assert names(store, axis="natural_frequency_hz", low=7.9, high=8.1) == ["number", "range", "list"]
    for name in ("frequency_hz", "excitation_frequency_hz"):
        assert names(store, axis=name, low=8.0) == ["number", "range", "list"]
        assert names(store, axis=name, low=9.0) == []
    # and by the ratios that these make
    assert names(store, axis="clearance_ratio", low=55.0) == ["number"]


def test_a_page_looks_at_no_more_than_it_may(store, monkeypatch):
    monkeypatch.setattr("damperlab.studies.store.life_cycle.lookup.MOST_LOOKED_AT", 2)
    monkeypatch.setattr("damperlab.studies.store.life_cycle.lookup.VALUES", 2)
    for place in range(5):
        enter(store, make_study(f"study {place}", damping_ratio=0.01 * (place + 1)))
    for limit, high, expected in (
        (50, 0.01, [[], [], ["study 0"]]),
        (1, 0.02, [[], ["study 1"], ["study 0"]]),
    ):
        seen, cursor = [], None
        while len(seen) < 3:
            page = store.page(limit, cursor, Wanted(axis="damping_ratio", high=high))
            seen.append([record.name for record in page.records])
            cursor = page.cursor
        assert (seen, cursor) == (expected, None)


@pytest.mark.parametrize(
    "wanted",
    [
        {"axis": "clearance"},
        {"axis": "record"},
        {"low": 1.0},
        {"axis": "clearance_ratio", "low": 2.0, "high": 1.0},
        {"axis": "clearance_ratio", "high": float("nan")},
        {"state": "over"},
    ],
)
def test_what_no_study_can_be_is_refused(wanted):
    with pytest.raises(StoreFault) as caught:
        Wanted(**wanted)
    assert caught.value.fault.advice


def test_remarks_that_were_put_off_are_written_beside_the_blocks(store):
    record = enter(store, make_study())
    shelf = store.cube_shelf(record.id, 1)
    store.set_state(record.id, "cancelled")
    store.remark(record.id, Remarks(("steel",), "n", "renamed"), at_once=False)
    assert put_off(store, record.id)
    assert read_marks(shelf)[0]["tags"] == "[]"
    again = Store.open(store.data_dir)  # as after a process that was killed
    again.keep_late_marks()
    assert read_marks(shelf)[0]["tags"] == '["steel"]'
    assert read_marks(shelf)[0]["name"] == "renamed"
    assert not put_off(again, record.id)
    # of a study that was deleted nothing is left to write
    again.remark(record.id, Remarks(note="m"), at_once=False)
    again.delete(record.id)
    again.bury()
    again.keep_late_marks()
    assert not put_off(again, record.id)
    again.close()


def test_a_study_that_was_cancelled_and_goes_on_writes_no_late_marks(store):
    record = enter(store, make_study())
    shelf = store.cube_shelf(record.id, 1)
    assert store.set_state(record.id, "cancelled", at_once=False).state == "cancelled"
    assert read_marks(shelf) is None
    assert list(verify(store, store.find(record.id))) == []
    store.set_state(record.id, "queued")
    store.keep_late_marks()
    assert (read_marks(shelf), put_off(store, record.id)) == (None, False)
    store.set_state(record.id, "cancelled", at_once=False)
    store.keep_late_marks()
    assert read_marks(shelf)[0]["state"] == "cancelled"


def test_late_marks_of_one_study_that_cannot_be_written_hold_up_no_other(store, monkeypatch):
    ids = [enter(store, make_study(damping_ratio=0.01 + 0.01 * n)).id for n in range(3)]
    for each in ids:
        store.set_state(each, "cancelled", at_once=False)
    keep = store.settle_marks

    def refuse_the_second(study_id):
        if study_id == ids[1]:
            raise StoreFault("store", "a full disk", "room", "make room")
        keep(study_id)

    monkeypatch.setattr(store, "settle_marks", refuse_the_second)
    with pytest.raises(StoreFault):
        store.keep_late_marks()
    numbers = {record.id: Path(store.cube_path(record.id)) for record in store.page().records}
    assert [(numbers[each] / MARKS).exists() for each in ids] == [True, False, True]
