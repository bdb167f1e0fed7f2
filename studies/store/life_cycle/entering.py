"""Entry of new studies into the catalogue: reserve serial numbers, create the cubes, and write the rows."""

import json
import math
import time
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, TypeVar

from sqlalchemy import Connection, bindparam, delete, func, insert, select, update

from damperlab.studies.digest import family_digest
from damperlab.studies.kind import AnyStudy
from damperlab.studies.store.catalogue.home import (
    BACKUP_OF,
    UNKNOWN_RESULTS,
    cube_name,
    disk_gone,
    fact,
    forget,
    holds_results,
    is_of_block,
    older_copy,
    parse_cube_name,
    remember,
)
from damperlab.studies.store.catalogue.rows import NEVER_ENTERED, RESERVED, pieces, record_of
from damperlab.studies.store.catalogue.tables import events, studies
from damperlab.studies.store.cube.block_file import BLOCKS
from damperlab.studies.store.cube.description import block_grid, bytes_per_point, first_pieces
from damperlab.studies.store.cubes import Cubes
from damperlab.studies.store.faults import StoreFault, cannot_use, using
from damperlab.studies.store.files.shelf import AT_ONCE, ShelfAway
from damperlab.studies.store.provenance import asked_by
from damperlab.studies.store.record import Record

_Answer = TypeVar("_Answer")


@dataclass(frozen=True)
class Submission:
    """A submitted study with its options.

    Parameters
    ----------
    study : AnyStudy
        The study.
    chunk : tuple of int
        Extent of a block along each dimension.
    provenance : dict of str
        Provenance, from `damperlab.studies.store.provenance.provenance`.
    reuse : bool
        Whether the study may reuse points of earlier studies.
    priority, version : int
        Priority and version of the study; see `Record`. The priority of an existing study is not changed.
    """

    study: AnyStudy
    chunk: tuple[int, ...]
    provenance: dict[str, str]
    reuse: bool = True
    priority: int = 0
    version: int = 1

    @property
    def id(self) -> str:
        """Id of the study, made of its digest and its version."""
        return self.study.digest[:12] + (f"-{self.version}" if self.version > 1 else "")

    @property
    def bytes(self) -> int:
        """Number of bytes of the complete study before compression."""
        return self.study.points * bytes_per_point(self.study)

    def columns(self) -> dict[str, Any]:
        """Return the values of the study's row in the catalogue, by column."""
        study = self.study
        return {
            "id": self.id,
            "digest": study.digest,
            "version": self.version,
            "name": study.name,
            "state": "queued",
            "definition": json.dumps(study.document()),
            "provenance": json.dumps(self.provenance),
            **asked_by(self.provenance),
            "shape": json.dumps(study.shape),
            "chunk": json.dumps(self.chunk),
            "points_total": study.points,
            "bytes_total": self.bytes,
            "blocks_total": math.prod(block_grid(study.shape, self.chunk)),
            "family": family_digest(study, self.provenance),
            "box": json.dumps(box_of(study)),
            "reuse": self.reuse,
            "priority": self.priority,
        }


class Entering(Cubes):
    """The part of a store that enters new studies into the catalogue."""

    def enter(
        self,
        decide: Callable[[Connection], tuple[list[Submission], Callable[[list[Record]], _Answer]]],
        what: str,
    ) -> _Answer:
        """Enter studies in three steps: reserve serial numbers, create the cubes, and write the rows.

        The cubes are created outside any transaction, so that a slow disk or server does not block other writers. If
        the process is killed between the steps, `collect_garbage` removes the empty cubes.

        Parameters
        ----------
        decide : callable
            Function that is called in each transaction. `decide` returns the studies to enter, and a function that
            converts the records of these studies to the answer.
        what : str
            Text of the event that is recorded for each study.

        Raises
        ------
        StoreFault
            If a cube cannot be written. The cubes that were already created are removed.
        """
        made: dict[str, _Made] = {}
        entered: set[str] = set()
        try:
            while True:
                with self.catalogue.writing() as connection:
                    entries, answer = decide(connection)
                    reserved = _still_reserved(connection, made.values())
                    missing = [entry for entry in entries if not _is_made(entry, made, reserved)]
                    if not missing:
                        records = self._publish(connection, [made[entry.id] for entry in entries], what)
                        answered = answer(records)
                        entered = {entry.id for entry in entries}
                        break
                    fresh = self._reserve(connection, missing)
                # remove cubes that belong to another plan, or whose numbers the garbage collection has withdrawn
                self._discard([made.pop(each.entry.id) for each in fresh if each.entry.id in made])
                self._make_way(fresh)
                made |= {each.entry.id: each for each in fresh}
                self._make(fresh)
        except StoreFault as error:
            if isinstance(error.__cause__, ShelfAway):
                made.clear()  # the server does not answer, so the cubes cannot be removed and become garbage
            raise
        finally:
            self._discard([each for study_id, each in made.items() if study_id not in entered])
        return answered

    def _reserve(self, connection: Connection, entries: Sequence[Submission]) -> list["_Made"]:
        """Reserve new serial numbers by inserting rows that have no id and are marked as deleted."""
        now = time.time()
        texts = dict.fromkeys(("id", "digest", "name", "definition", "provenance"), "")
        sizes = {"points_total": 0, "blocks_total": 0, "shape": "[]", "chunk": "[]"}
        row = {**texts, **sizes, "state": "queued", "created": now, "deleted": now}
        new = insert(studies).returning(studies.c.number, sort_by_parameter_order=True)
        numbers = connection.execute(new, [row] * len(entries)).scalars()
        return [_Made(entry, number, now) for entry, number in zip(entries, numbers, strict=True)]

    def _make(self, fresh: Sequence["_Made"]) -> None:
        with using(self.shelf.address):
            self.shelf.make({each.name: each.files() for each in fresh}, (BLOCKS,))

    def _discard(self, several: Sequence["_Made"]) -> None:
        """Remove cubes whose studies were not entered, and withdraw the reserved serial numbers."""
        with suppress(StoreFault, OSError):
            # withdraw only numbers that are still reserved: a rebuild may have assigned the others to studies
            ours: set[int] = set()
            for some in pieces(each.number for each in several):
                mine = update(studies).where(studies.c.number.in_(some), RESERVED).values(state="cancelled")
                with self.catalogue.writing() as connection:
                    ours |= set(connection.execute(mine.returning(studies.c.number)).scalars())
            for each in several:
                if each.number in ours:
                    self.shelf.at(each.name).clear()
            self._give_back(ours)

    def _give_back(self, numbers: Iterable[int]) -> None:
        """Remove the rows of unused reserved serial numbers. The database never assigns these serial numbers again."""
        with suppress(StoreFault):
            for some in pieces(numbers):
                with self.catalogue.writing() as connection:
                    connection.execute(delete(studies).where(studies.c.number.in_(some), NEVER_ENTERED))

    def _publish(self, connection: Connection, several: Sequence["_Made"], what: str) -> list[Record]:
        """Write the rows of studies whose cubes exist."""
        if not several:
            return []
        c = studies.c
        # a backup with new studies becomes independent, because the next backup would remove these studies
        forget(connection, BACKUP_OF)
        # if a deleted study is submitted again, use revisions that the deleted study did not have
        ever: dict[str, int] = {}
        for digests in pieces(each.entry.study.digest for each in several):
            query = select(c.id, func.max(c.revision) + 1).where(c.digest.in_(digests)).group_by(c.id)
            ever |= {row[0]: row[1] for row in connection.execute(query)}
        rows = []
        for each in several:
            revision = ever.get(each.entry.id, 0)
            new = {"created": each.created, "deleted": None, "revision": revision, "taken_back": revision}
            rows.append({"number": each.number, **each.entry.columns(), **new})
        names = rows[0].keys() - {"number"}
        change = update(studies).where(c.number == bindparam("of_number"))
        connection.execute(
            change.values({name: bindparam(f"to_{name}") for name in names}),
            [{"of_number": row["number"], **{f"to_{name}": row[name] for name in names}} for row in rows],
        )
        now = time.time()
        connection.execute(
            insert(events), [{"study": each.entry.id, "at": now, "what": what} for each in several]
        )
        found: dict[int, Record] = {}
        for given in pieces(each.number for each in several):
            for row in connection.execute(select(studies).where(c.number.in_(given))):
                found[row.number] = record_of(row)
        return [found[each.number] for each in several]

    def _make_way(self, fresh: Sequence["_Made"]) -> None:
        """Clear the locations of new cubes; raise `StoreFault` if a location contains results."""
        names = [each.name for each in fresh]
        try:
            gone = disk_gone(self.shelf)
            if gone is not None:
                raise FileNotFoundError(gone)
            self._require_newest()
            with ThreadPoolExecutor(AT_ONCE) as pool:
                free = list(pool.map(self._clear, names)) if len(names) > 1 else [self._clear(names[0])]
            if not all(free):
                taken = names[free.index(False)]
                with self.catalogue.writing() as connection:
                    remember(connection, UNKNOWN_RESULTS, taken)
                raise older_copy(self.shelf.at(taken).address, self.catalogue.name)
        except (OSError, StoreFault) as error:
            self._give_back([each.number for each in fresh])
            if isinstance(error, OSError):
                raise cannot_use(self.shelf.address, error) from error
            raise

    def _clear(self, name: str) -> bool:
        """Remove a cube that an interrupted submission has left. Return False if the cube contains results."""
        shelf = self.shelf.at(name)
        entries = list(shelf.entries())
        if any(is_of_block(entry) for entry in entries):
            return False
        if entries:
            shelf.clear()
        return True

    def _require_newest(self) -> None:
        """Raise `StoreFault` if an earlier submission found a cube whose results this catalogue lacks."""
        with self.catalogue.reading() as connection:
            name = fact(connection, UNKNOWN_RESULTS)
            if name is None:
                return
            study_id, number = parse_cube_name(name) or ("", 0)
            ours = select(studies.c.number).where(studies.c.number == number, studies.c.id == study_id)
            known = connection.execute(ours).first() is not None
        shelf = self.shelf.at(name)
        if not known and holds_results(shelf):
            raise older_copy(shelf.address, self.catalogue.name)
        with self.catalogue.writing() as connection:
            forget(connection, UNKNOWN_RESULTS)


@dataclass(frozen=True)
class _Made:
    """A new cube whose study has not been entered yet."""

    entry: Submission
    number: int
    created: float

    @property
    def name(self) -> str:
        """Name of the cube's folder."""
        return cube_name(self.entry.id, self.number)

    def files(self) -> dict[str, bytes]:
        """Return the files of the empty cube, by name."""
        entry = self.entry
        first = first_pieces(
            entry.study, entry.chunk, entry.provenance, reuse=entry.reuse, created=self.created
        )
        return first | entry.study.attachments()


def _still_reserved(connection: Connection, several: Iterable[_Made]) -> set[int]:
    """Return those serial numbers of the cubes that are still reserved."""
    found: set[int] = set()
    for some in pieces(each.number for each in several):
        query = select(studies.c.number).where(studies.c.number.in_(some), RESERVED)
        found |= set(connection.execute(query).scalars())
    return found


def _is_made(entry: Submission, made: dict[str, _Made], reserved: set[int]) -> bool:
    known = made.get(entry.id)
    # the cube must have been created for this very submission, and its number must still be reserved
    return known is not None and known.entry.study is entry.study and known.number in reserved


def box_of(study: AnyStudy) -> list[list[Any]]:
    """Return the bounding box of a study's grid: the lowest and the highest value along every numeric dimension."""
    return [
        [float(values[0]), float(values[-1])]
        for values in study.coordinates.values()
        if values.dtype.kind == "f"
    ]
