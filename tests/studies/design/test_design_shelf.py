"""Designs as they are kept: whole at every moment, one for each specification, and damage is told."""

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from tests.filling import flip

from damperlab.studies.design.kept import Kept, Round
from damperlab.studies.design.shelf import DesignBusy, DesignDamaged, DesignNotFound, DesignsFull, Shelf
from damperlab.studies.specification.reading import parse_specification, read_specification
from damperlab.studies.specification.specification import Specification
from damperlab.studies.store.care.backup import copy_store
from damperlab.studies.store.care.verify import check_catalogue
from damperlab.studies.store.kept_quota import KeptQuota
from damperlab.studies.store.provenance import submitter
from damperlab.studies.store.store import Store

AT = Round(
    "a first look", 1, 0, 80, ("0123456789ab",), {"worst": {"value": None}}, "2026-01-01T00:00:00+00:00"
)


@pytest.fixture
def shelf(tmp_path: Path) -> Shelf:
    return Shelf(tmp_path)


@pytest.fixture
def asked() -> Specification:
    return read_specification("prototype")


def kept_design(shelf: Shelf, asked: Specification) -> Kept:
    kept, new = shelf.put(asked, 1000)
    assert new
    return kept


def test_a_design_is_queued_then_runs_then_is_done(shelf: Shelf, asked: Specification) -> None:
    design_id = kept_design(shelf, asked).id
    assert (shelf.get(design_id).state, shelf.get(design_id).specification) == ("queued", asked.document)
    shelf.follow(design_id, AT)
    assert (shelf.get(design_id).state, shelf.get(design_id).round) == ("running", AT)
    assert [each.id for each in shelf.waiting()] == [design_id]
    assert shelf.finish(design_id, {"words": ["ü", None]}, "<p>ü</p>")
    assert shelf.get(design_id).state == "done"
    assert shelf.waiting() == []
    assert shelf.answer(design_id) == {"words": ["ü", None]}
    assert shelf.report(design_id) == "<p>ü</p>".encode()


def test_who_ends_a_design_first_has_ended_it(shelf: Shelf, asked: Specification) -> None:
    design_id = kept_design(shelf, asked).id
    assert shelf.end(design_id, "cancelled")
    assert not shelf.finish(design_id, {}, "")
    assert shelf.get(design_id).state == "cancelled"
    shelf.resume(design_id)
    assert shelf.get(design_id).state == "queued"


def test_the_same_specification_is_one_design_whatever_it_is_called(
    shelf: Shelf, asked: Specification
) -> None:
    first = kept_design(shelf, asked)
    other = parse_specification(asked.document | {"name": "another"})
    assert shelf.put(other, 1000) == (first, False)
    assert shelf.find(first.id[:5]) == shelf.find("prototype") == first
    for reference in ("another", first.id[:3], "", ".."):
        with pytest.raises(DesignNotFound):
            shelf.find(reference)


def test_a_name_that_is_the_start_of_another_designs_id_is_a_name(shelf: Shelf, asked: Specification) -> None:
    first = kept_design(shelf, asked)
    other = asked.document | {"name": first.id[:5], "restitution": 0.4}
    named, new = shelf.put(parse_specification(other), 1000)
    assert new
    assert shelf.find(first.id[:5]) == named
    assert shelf.find(first.id[:6]) == shelf.find(first.id) == first


def test_a_deletion_that_was_cut_short_leaves_nothing_to_a_later_design(
    shelf: Shelf, tmp_path: Path, asked: Specification
) -> None:
    design_id = kept_design(shelf, asked).id
    shelf.finish(design_id, {"words": ["old"]}, "old")
    # what a deletion does first
    (tmp_path / "designs" / design_id / "request.json").unlink()
    assert shelf.ids() == set()
    with pytest.raises(DesignNotFound):
        shelf.get(design_id)
    assert kept_design(shelf, asked).state == "queued"


def test_so_many_designs_are_kept_in_all_and_of_each_owner(tmp_path: Path, asked: Specification) -> None:
    shelf = Shelf(tmp_path, KeptQuota(3, 2))

    def put(owner: str | None, mass_kg: float) -> None:
        given = asked.document | {"structure": asked.document["structure"] | {"mass_kg": mass_kg}}
        token = submitter.set(owner)
        try:
            shelf.put(parse_specification(given), 1000)
        finally:
            submitter.reset(token)

    put("ada", 2.0)
    put("ada", 3.0)
    with pytest.raises(DesignsFull, match="`key_quota_designs` is reached: 2 designs of at most 2"):
        put("ada", 4.0)
    put("ada", 2.0)  # what is there is never refused
    put("bob", 4.0)
    for owner in ("bob", None):
        with pytest.raises(DesignsFull, match="`quota_designs` is reached: 3 designs of at most 3"):
            put(owner, 5.0)
    assert len(shelf.ids()) == 3


def test_a_design_comes_back_from_the_trash_as_it_was(shelf: Shelf, asked: Specification) -> None:
    design_id = kept_design(shelf, asked).id
    with pytest.raises(DesignBusy):
        shelf.delete(shelf.get(design_id), trash=True)
    shelf.finish(design_id, {"words": ["a"]}, "report")
    kept = shelf.get(design_id)
    shelf.delete(kept, trash=True)
    assert (shelf.every(), shelf.every(trash=True), shelf.ids()) == ([], [kept], set())
    for look in (shelf.get, shelf.find):
        with pytest.raises(DesignNotFound, match="in the trash until"):
            look(design_id)
    shelf.bury()  # what may still be restored stays
    for reference in (design_id, kept.name, design_id[:6]):
        assert shelf.undelete(reference) == shelf.get(design_id) == kept
        shelf.delete(kept, trash=True)
    shelf.undelete(design_id)
    assert shelf.every(trash=True) == []
    assert shelf.answer(design_id) == {"words": ["a"]}
    with pytest.raises(DesignNotFound, match="is not in the trash"):
        shelf.undelete(design_id)


def test_what_has_been_in_the_trash_for_a_week_is_gone(
    shelf: Shelf, tmp_path: Path, asked: Specification
) -> None:
    design_id = kept_design(shelf, asked).id
    shelf.end(design_id, "cancelled")
    shelf.delete(shelf.get(design_id), trash=True)
    trash = tmp_path / "designs" / design_id / "trash.json"
    ago = trash.stat().st_mtime - 7 * 86_400
    os.utime(trash, (ago, ago))
    assert shelf.every(trash=True) == []
    for look in (shelf.get, shelf.undelete):
        with pytest.raises(DesignNotFound):
            look(design_id)
    other = shelf.put(read_specification("antenna-mast"), 10)[0]
    shelf.bury()
    assert [folder.name for folder in (tmp_path / "designs").iterdir()] == [other.id]


def test_what_is_asked_for_again_is_restored_from_the_trash_with_its_answer(
    tmp_path: Path, asked: Specification
) -> None:
    shelf = Shelf(tmp_path, KeptQuota(1))
    design_id = kept_design(shelf, asked).id
    shelf.finish(design_id, {"words": ["old"]}, "old")
    shelf.rename(design_id, "old")
    kept = shelf.get(design_id)
    shelf.delete(kept, trash=True)
    with pytest.raises(DesignsFull):  # the trash counts
        shelf.put(read_specification("antenna-mast"), 10)
    assert shelf.put(asked, 10) == (kept, False)
    assert shelf.every(trash=True) == []


def test_a_design_has_another_name_and_its_specification_keeps_its_own(
    shelf: Shelf, asked: Specification
) -> None:
    kept = kept_design(shelf, asked)
    shelf.rename(kept.id, "second draft")
    assert shelf.get(kept.id) == replace(kept, name="second draft")
    assert shelf.find("second draft").id == kept.id
    with pytest.raises(DesignNotFound):
        shelf.find(asked.name)


@pytest.mark.parametrize("name", ["request.json", "end.json", "answer.json", "name.json"])
def test_every_changed_byte_is_told(shelf: Shelf, tmp_path: Path, asked: Specification, name: str) -> None:
    store = Store.open(tmp_path)
    design_id = kept_design(shelf, asked).id
    shelf.rename(design_id, "draft")
    shelf.finish(design_id, {"words": ["a"]}, "")
    assert list(check_catalogue(store)) == []
    flip(tmp_path / "designs" / design_id / name)
    with pytest.raises(DesignDamaged):
        _ = shelf.answer(design_id) if name == "answer.json" else shelf.get(design_id)
    assert [design_id in line for line in check_catalogue(store)] == [True]
    store.close()


def test_a_backup_holds_the_designs(tmp_path: Path, asked: Specification) -> None:
    source, target = Store.open(tmp_path / "a"), Store.open(tmp_path / "b")
    shelf = Shelf(tmp_path / "a")
    design_id = kept_design(shelf, asked).id
    shelf.finish(design_id, {"words": ["a"]}, "report")
    running = shelf.put(read_specification("antenna-mast"), 10)[0]
    copied: list[Any] = [copy_store(source, target) for _ in range(2)]
    assert copied[0].bytes > 0
    assert copied[1].bytes == 0
    there = Shelf(tmp_path / "b")
    assert there.answer(design_id) == {"words": ["a"]}
    assert there.waiting() == [running]
    # what ends, and what goes on after it had ended
    shelf.end(running.id, "cancelled")
    shelf.resume(design_id)
    shelf.rename(design_id, "draft")
    # and a copy that was put into the trash there is as it is here
    there.delete(there.get(design_id), trash=True)
    copy_store(source, target)
    assert (there.get(running.id), there.get(design_id)) == (shelf.get(running.id), shelf.get(design_id))
    source.close()
    target.close()
