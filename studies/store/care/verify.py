"""Verification of stored studies: the cube's description, coordinates and blocks, the done-marks, and the catalogue.

Both the catalogue and the cube contain a description of the study with checksums. A damaged description in the cube is
repaired from the catalogue. A block whose file is damaged is computed again.
"""

import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from sqlalchemy import Row, select

from damperlab.studies.definition import Study, parse_study
from damperlab.studies.design.shelf import Shelf as Designs
from damperlab.studies.ground.shelf import Shelf as Records
from damperlab.studies.ground.suite import Suite
from damperlab.studies.store.catalogue.home import cube_name, holds_results, parse_cube_name
from damperlab.studies.store.catalogue.rows import (
    ALIVE,
    NEVER_ENTERED,
    claim_owner,
    last_event,
    record_of,
    rows_of_marks,
    study_row,
    sums_of_marks,
)
from damperlab.studies.store.catalogue.rowsum import damaged_row, is_sound
from damperlab.studies.store.catalogue.tables import SUMMED, access_keys, done_blocks, studies
from damperlab.studies.store.cube.block_file import read_whole
from damperlab.studies.store.cube.definition import DefinitionDamaged, lost_attachments, parse_stored
from damperlab.studies.store.cube.description import DESCRIPTION, Description, describe_cube, first_pieces
from damperlab.studies.store.faults import cannot_use, using
from damperlab.studies.store.files.shelf import Shelf, ShelfAway
from damperlab.studies.store.life_cycle.manifest import (
    lost_end,
    marks_put_off,
    put_off_marks,
    read_marks,
    read_tombstone,
)
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store
from damperlab.studies.vocabulary import ENDED

_TRIES = 5  # number of times that a study is read again because it changed meanwhile
_HEADER_COLUMNS = ("points", "failed", "reused", "checksum")


@dataclass(frozen=True)
class Damage:
    """One damaged item.

    Parameters
    ----------
    block : int or None
        Index of the damaged block; None if the damage concerns the whole study.
    found : str
        Description of the damage in one sentence.
    part : str
        The damaged part: `block`, `description` of the cube, list of `marks` in the cube, or `catalogue`.
    """

    block: int | None
    found: str
    part: str = "block"


def verify(store: Store, record: Record, pause: Callable[[], None] = lambda: None) -> Iterator[Damage]:
    """Read everything that is stored for a study, and compare it with the checksums and the done-marks.

    The study may change meanwhile: a difference between a file and the catalogue is damage only if the catalogue is
    still the same after the file was read. The function `pause` is called before each block, to slow the reading down.

    Yields
    ------
    Damage
        First damaged rows of done-marks, then damage of the whole study, then damaged blocks in ascending order. The
        blocks are not read if the definition or the cube's description is damaged.

    Raises
    ------
    StudyNotFound
        If the study does not exist, or was deleted meanwhile.
    StoreAway
        If the location of the cubes cannot be reached, or denies access.
    """
    for _ in range(_TRIES):
        entry = _Entry.of(store, record.id)
        shelf = store.cube_shelf(record.id, entry.row.number)
        described, damages = _around_blocks(shelf, entry)
        if not damages or _Entry.of(store, record.id) == entry:
            break
    yield from damages
    if described is None:
        return
    for mark in entry.whole_marks:
        pause()
        trouble = _trouble(shelf, described, mark)
        if trouble is not None and _holds(store, record.id, mark):
            yield Damage(mark.block, trouble)


def _holds(store: Store, study_id: str, mark: Row[Any]) -> bool:
    """Whether the catalogue still has a done-mark; raise `StudyNotFound` if the study was deleted meanwhile."""
    b = done_blocks.c
    with store.catalogue.reading() as connection:
        number = study_row(connection, study_id).number
        query = select(done_blocks).where(b.study == number, b.block == mark.block)
        return connection.execute(query).one_or_none() == mark


@dataclass(frozen=True)
class _Entry:
    """The catalogue's rows of a study at one moment."""

    row: Row[Any]
    marks: Sequence[Row[Any]]
    sums: Mapping[str, Any]
    # note that the list of marks in the cube must still be written
    put_off: str | None

    @classmethod
    def of(cls, store: Store, study_id: str) -> "_Entry":
        with store.catalogue.reading() as connection:
            row = study_row(connection, study_id)
            marks, sums = rows_of_marks(connection, row.number), sums_of_marks(connection, row.number)
            return cls(row, marks, sums, marks_put_off(connection, study_id))

    @property
    def whole_marks(self) -> list[Row[Any]]:
        """The done-marks whose block index is an integer."""
        return [mark for mark in self.marks if isinstance(mark.block, int)]


def _around_blocks(shelf: Shelf, entry: _Entry) -> tuple[Description | None, list[Damage]]:
    """Check everything except the blocks' files. The description is None if the files cannot be checked."""
    found = [_damaged_mark(mark) for mark in entry.marks if not is_sound(done_blocks, mark)]
    wrong = _row(entry.row, entry.sums)
    if wrong is not None:
        found.append(Damage(None, wrong, "catalogue"))
    record = record_of(entry.row)
    try:
        study = parse_stored(record.definition, record.digest)
    except DefinitionDamaged as error:
        told = f"its definition in the catalogue is damaged: {error.fault.found}"
        return None, [*found, Damage(None, told, "catalogue")]
    described, wrong = _description(shelf, record, study)
    if described is None:
        return None, [*found, Damage(None, wrong, "description")]
    for key in lost_attachments(shelf, study):
        lost = f"{key}, a file of the study, is lost or not as it was written"
        found.append(Damage(None, lost, "description"))
    if not entry.put_off:
        found += _marks(shelf, entry.row, entry.whole_marks)
    return described, found


def check_catalogue(store: Store, pause: Callable[[], None] = lambda: None) -> Iterator[str]:
    """Check the rows of the catalogue, the existence of the cubes, the uploaded records, and the designs.

    Yield one sentence for each damaged item. The function `pause` is called before each record, design and
    cube, to slow the reading down.

    Raises
    ------
    StoreFault
        If the catalogue or the location of the cubes cannot be read.
    """
    for line in store.catalogue.integrity():
        yield f"{store.catalogue.name}: {line}; make it again with `damperlab store rebuild`"
    with using(store.shelf.address):
        names = sorted(store.shelf.shelves())
    with store.catalogue.reading() as connection:
        for table in SUMMED:
            for row in connection.execute(select(table)):
                if not is_sound(table, row):
                    name = str(row._mapping.get("id", row[0]))
                    fault = damaged_row(table, name).fault
                    key = "remove the key with `damperlab store rebuild`, and make another with `damperlab admin keys create`"
                    advice = key if table is access_keys else fault.advice
                    yield f"{store.catalogue.name}: {name}: {fault.found}; {advice}"
    for _, damaged_record in Records(store.data_dir).damaged(pause):
        yield damaged_record
    for _, damaged_design in Designs(store.data_dir).damaged(pause):
        yield damaged_design
    with using(store.shelf.address):
        yield from _apart(store, names, pause)


def unfinished_submissions(store: Store) -> list[str]:
    """Return one sentence for each cube without results whose number is reserved, and whose study is not in the catalogue.

    A submission creates the cube before it enters the study, so the submission is under way or was interrupted. If the
    catalogue lost the entry of a study, it looks the same. Therefore each sentence also says how to restore a study.
    """
    with using(store.shelf.address):
        names = sorted(store.shelf.shelves())
    with store.catalogue.reading() as connection:
        reserved = set(connection.execute(select(studies.c.number).where(NEVER_ENTERED)).scalars())
    return [
        f"cube {name} belongs to a submission that has not ended, or was interrupted. If its study is missing, "
        "`damperlab store rebuild` adds the study; otherwise `damperlab store gc` removes the cube."
        for name in names
        if (parsed := parse_cube_name(name))
        and parsed[1] in reserved
        and not holds_results(store.shelf.at(name))
    ]


def _apart(store: Store, names: Sequence[str], pause: Callable[[], None]) -> Iterator[str]:
    """Yield a message for each lost cube, and for each study, deletion or final state that the catalogue has lost."""
    cubes = {name: parsed for name in names if (parsed := parse_cube_name(name))}
    with store.catalogue.reading() as connection:
        rows = connection.execute(select(studies.c.id, studies.c.number, studies.c.deleted)).all()
    alive = {row.id: row.number for row in rows if row.deleted is None}
    known = {cube_name(row.id, row.number) for row in rows}
    reserved = {row.number for row in rows if not row.id}
    unknown = [name for name in cubes if name not in known]
    # a submission that was withdrawn meanwhile has removed its cube
    there = set(store.shelf.shelves()) if unknown else set()
    for name in sorted(there.intersection(unknown)):
        # without results, the cube is that of a submission that has not ended, or was interrupted
        study_id, number = cubes[name]
        if not (study_id in alive or number in reserved) or holds_results(store.shelf.at(name)):
            yield f"cube {name} belongs to no study of the catalogue; `damperlab store rebuild` adds it"
    lost = {cube_name(study_id, number) for study_id, number in alive.items()}.difference(names)
    if lost:  # some cubes may have been created after the names were read, and removed with their studies
        lost.difference_update(store.shelf.shelves())
        with store.catalogue.reading() as connection:
            still = connection.execute(select(studies.c.id, studies.c.number).where(ALIVE)).all()
        lost.intersection_update(cube_name(row.id, row.number) for row in still)
    for name in sorted(lost):
        yield f"the cube {name} is lost; restore it from a backup, or delete its study"
    for name, (study_id, number) in cubes.items():
        if alive.get(study_id) != number:
            continue
        pause()
        shelf = store.shelf.at(name)
        try:
            kept = read_marks(shelf)
            deleted = read_tombstone(shelf)
        except (OSError, ValueError):
            continue  # `verify` reports this damage
        if kept is None and deleted is None:
            continue
        with store.catalogue.reading() as connection:
            row = connection.execute(select(studies).where(studies.c.number == number)).one_or_none()
            if row is None or row.deleted is not None or claim_owner(row) is not None:
                continue  # the study was deleted meanwhile, or a process is working on it
            ended = kept is not None and lost_end(kept[0], row, last_event(connection, study_id))
        # the record of the deletion was removed if the study was restored meanwhile
        if deleted is not None and read_tombstone(shelf) == deleted:
            yield f"study {study_id} was deleted, but the catalogue has lost the deletion; `damperlab store rebuild` repeats it"
        elif ended and kept is not None:
            yield (
                f"study {study_id} is {row.state} in the catalogue, but {kept[0]['state']} in its cube: the catalogue has "
                "lost the final state, and `damperlab store rebuild` restores it"
            )


def repair(store: Store, record: Record, damages: list[Damage]) -> Record:
    """Repair the damage that `verify` found in a study, and return the new record of the study.

    A damaged description of the cube is written again. The done-marks of damaged blocks are invalidated; the study is
    then queued.

    Raises
    ------
    StudyBusy
        If a process works on the study.
    StudyFaults
        If a ground-motion record is lost both in the cube and in the data directory.
    """
    parts = {damage.part for damage in damages}
    record = store.find(record.id)
    shelf = store.find_cube(record.id)
    if "description" in parts:
        study = parse_stored(record.definition, record.digest)
        lost = lost_attachments(shelf, study)
        if lost:
            whole = parse_study(record.definition, Records(store.data_dir)).attachments()
            shelf.fill({key: whole[key] for key in lost})
        created = record.created.timestamp()
        shelf.fill(first_pieces(study, record.chunk, record.provenance, reuse=record.reuse, created=created))
    blocks = [damage.block for damage in damages if damage.block is not None]
    if blocks or "catalogue" in parts:
        record = store.forget(record.id, blocks, "damaged")
    if record.ended and parts & {"description", "marks"}:
        with store.catalogue.writing() as connection:
            put_off_marks(connection, record.id)
        store.settle_marks(record.id)
    return store.find(record.id)


def _damaged_mark(mark: Row[Any]) -> Damage:
    if isinstance(mark.block, int):
        return Damage(mark.block, "its done-mark in the catalogue is not what was written")
    return Damage(None, "a done-mark belongs to no block; `damperlab store rebuild` removes it", "catalogue")


def _row(row: Row[Any], sums: Mapping[str, Any]) -> str | None:
    """Compare the totals in a study's row with the done-marks of its blocks. Times are not compared, because
    sums of times have rounding errors.
    """
    wrong = [
        f"{name} is {getattr(row, name)}, but the done-marks say {value}"
        for name, value in sums.items()
        if getattr(row, name) != value and "seconds" not in name
    ]
    lacking = row.blocks_total - sums["blocks_done"]
    if row.state == "done" and lacking > 0:
        wrong.append(f"it is done, and {lacking} of {row.blocks_total} done-marks are missing")
    return "; ".join(wrong) or None


def _description(shelf: Shelf, record: Record, study: Study | Suite) -> tuple[Description | None, str]:
    """Return the cube's description. If the description is wrong or damaged, return None and the reason."""
    try:
        described = describe_cube(shelf.get(DESCRIPTION))
        coordinates = {name: one.read(shelf) for name, one in described.coordinates.items()}
    except (ShelfAway, PermissionError) as error:
        raise cannot_use(shelf.address, error) from error  # the stored data may be intact
    except FileNotFoundError:
        return None, "a file of the cube's description is lost"
    except Exception as error:  # damaged metadata may raise any exception
        return None, f"the cube's description cannot be read ({type(error).__name__}: {error})"
    told = {
        "digest": (described.digest, record.digest),
        "definition": (_parse_json(described.attributes.get("study")), record.definition),
        "blocks": (next(iter(described.arrays.values())).chunks, record.chunk),
        "shape": (next(iter(described.arrays.values())).shape, record.shape),
    }
    if record.blocks_done:  # the solver is written to the cube before it is written to the catalogue
        told["provenance"] = (_parse_json(described.attributes.get("provenance")), record.provenance)
    for name, (theirs, ours) in told.items():
        if theirs != ours:
            return None, f"the {name} in the cube's description and in the catalogue differ"
    for name, values in study.coordinates.items():
        if name not in coordinates or not np.array_equal(coordinates[name], values):
            return None, f"the coordinates along {name} are not those of the study"
    return described, ""


def _parse_json(text: Any) -> Any:
    try:
        return json.loads(text)
    except (TypeError, ValueError):
        return None


def _marks(shelf: Shelf, row: Row[Any], marks: Sequence[Row[Any]]) -> Iterator[Damage]:
    """Compare the done-marks in the cube with the done-marks in the catalogue."""
    try:
        kept = read_marks(shelf)
    except ValueError as error:
        yield Damage(None, f"the cube's list of marks cannot be read: {error}", "marks")
        return
    if kept is None:
        if row.state in ENDED:
            yield Damage(None, "the cube's list of marks is lost", "marks")
        return
    ours = {mark.block: (mark.generation, mark.checksum) for mark in marks}
    theirs = {mark["block"]: (mark["generation"], mark["checksum"]) for mark in kept[1]}
    # the catalogue may also have marks of blocks that were still running when the study was cancelled
    unknown = theirs.items() - ours.items()
    if unknown or (row.state == "done" and ours != theirs):
        yield Damage(None, "the marks in the cube and in the catalogue differ", "marks")


def _trouble(shelf: Shelf, described: Description, mark: Row[Any]) -> str | None:
    """Compare the file of a block with its checksums and with the done-mark in the catalogue."""
    if not 0 <= mark.block < math.prod(described.grid):
        return "the study has no such block"
    try:
        header, _ = read_whole(shelf, described, mark.block, mark.generation)
    except FileNotFoundError:
        return "its file is lost"
    except (ShelfAway, PermissionError) as error:
        raise cannot_use(shelf.address, error) from error
    except (OSError, ValueError) as error:
        return f"its file cannot be read ({error})"
    told = header.mark
    for name in _HEADER_COLUMNS:
        if name in told and told[name] != getattr(mark, name) and getattr(mark, name) is not None:
            return f"its done-mark says {name} {getattr(mark, name)}, its file {told[name]}"
    return None
