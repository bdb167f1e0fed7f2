"""Studies that are deleted for a while, and restored."""

import pytest
from tests.filling import enter, make_study

from damperlab.studies.store.care.verify import verify
from damperlab.studies.store.faults import NothingToDo, StudyNotFound
from damperlab.studies.store.files.shelf import TOMBSTONE
from damperlab.studies.store.life_cycle.lookup import Wanted

WEEK = 7 * 86_400.0


def ids(store, **wanted):
    return [record.id for record in store.page(wanted=Wanted(**wanted)).records]


def test_a_study_is_taken_back_from_the_trash_as_it_was(store):
    record = enter(store, make_study())
    store.delete(record.id, WEEK)
    assert (ids(store), ids(store, trash=True)) == ([], [record.id])
    with pytest.raises(StudyNotFound, match="in the trash until"):
        store.find(record.id)
    with pytest.raises(StudyNotFound, match=f"in the trash until .* `damperlab undelete {record.id}`"):
        store.find(record.name)
    store.bury()  # what may still be restored stays
    assert store.trashed(record.id).name == record.name
    assert store.undelete(record.id) == record
    assert (ids(store), ids(store, trash=True)) == ([record.id], [])
    # and nothing beside its blocks says that it was deleted
    assert TOMBSTONE not in {entry.key for entry in store.cube_shelf(record.id, 1).entries()}
    assert list(verify(store, record)) == []
    store.bury()
    assert store.find(record.id) == record
    with pytest.raises(StudyNotFound):
        store.undelete(record.id)


def test_what_is_deleted_for_good_or_was_submitted_again_is_not_taken_back(store):
    record = enter(store, make_study())
    store.delete(record.id)
    with pytest.raises(StudyNotFound):
        store.undelete(record.id)
    again = enter(store, make_study())
    store.delete(again.id, WEEK)
    enter(store, make_study())
    with pytest.raises(NothingToDo):
        store.undelete(again.id)
