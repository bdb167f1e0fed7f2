"""Submission of studies. The catalogue gets one entry for a study, however often the study is submitted."""

import json
import math
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from typing import Any, TypeVar

from sqlalchemy import Connection, bindparam, delete, func, insert, select, update

from damperlab.studies.digest import family_digest
from damperlab.studies.faults import Fault, describe, printable
from damperlab.studies.kind import AnyStudy
from damperlab.studies.plan import Plan
from damperlab.studies.store.catalogue.base import StoreBase
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
from damperlab.studies.store.catalogue.quota import Ledger
from damperlab.studies.store.catalogue.rows import (
    ALIVE,
    NEVER_ENTERED,
    RESERVED,
    newest_row,
    pieces,
    record_of,
)
from damperlab.studies.store.catalogue.rowsum import require_row
from damperlab.studies.store.catalogue.tables import events, keys, studies
from damperlab.studies.store.catalogue.turns import Turns
from damperlab.studies.store.cube.cube import bytes_per_point
from damperlab.studies.store.cube.description import block_grid, first_pieces
from damperlab.studies.store.cube.packed import BLOCKS
from damperlab.studies.store.faults import (
    CatalogueDamaged,
    KeyTaken,
    QuotaReached,
    StoreFault,
    cannot_use,
    using,
)
from damperlab.studies.store.files.shelf import AT_ONCE, ShelfAway
from damperlab.studies.store.provenance import SUBMITTED_BY, asked_by, signed
from damperlab.studies.store.record import Record

_MOST = 256  # largest number of studies in one transaction, so that other writers do not wait long

_Answer = TypeVar("_Answer")


@dataclass(frozen=True)
class Submission:
    """A submitted study with its options.

    Parameters
    ----------
    study, plan : AnyStudy, Plan
        The study, and the division of its grid into blocks.
    provenance : dict of str
        Provenance, from `damperlab.studies.store.provenance.provenance`.
    reuse : bool
        Whether the study may reuse points of earlier studies.
    key : str, optional
        Idempotency key: a name chosen by the caller, which cannot be used for another definition.
    priority : int
        Priority of the study; see `Record`. The priority of an existing study is not changed.
    """

    study: AnyStudy
    plan: Plan
    provenance: dict[str, str]
    reuse: bool = True
    key: str | None = None
    priority: int = 0

    def __post_init__(self) -> None:
        """Check that the plan belongs to the study."""
        if self.plan.count != math.prod(block_grid(self.study.shape, self.plan.chunk)):
            raise ValueError(
                f"a plan of {self.plan.count} blocks of {self.plan.chunk} does not fit a grid of {self.study.shape}"
            )


@dataclass(frozen=True)
class Entry:
    """A study that is about to be entered into the catalogue.

    Parameters
    ----------
    study : AnyStudy
        The study.
    chunk : tuple of int
        Extent of a block along each dimension.
    provenance : dict of str
        Provenance of the study.
    reuse : bool
        Whether the study may reuse points of earlier studies.
    version : int
        Version of the study; see `Record`.
    priority : int
        Priority of the study; see `Record`.
    """

    study: AnyStudy
    chunk: tuple[int, ...]
    provenance: dict[str, str]
    reuse: bool
    version: int = 1
    priority: int = 0

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


Entered = list[tuple[Record, bool]]


class Entering(StoreBase):
    """The part of a store that enters submitted studies into the catalogue."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._turns = Turns[Sequence[Submission], Entered](self._submit_lists, _MOST, len)

    def submit(
        self,
        study: AnyStudy,
        plan: Plan,
        provenance: dict[str, str],
        *,
        reuse: bool = True,
        key: str | None = None,
        priority: int = 0,
    ) -> tuple[Record, bool]:
        """Enter a new study, or return the record of an existing study. The parameters are those of `Submission`.

        Returns
        -------
        record : Record
            Record of the new or existing study.
        created : bool
            Whether this call has entered the study.

        Raises
        ------
        StoreFault
            If the cube cannot be written.
        QuotaReached
            If the study would exceed the remaining quota.
        KeyTaken
            If the key was already used for another definition.
        """
        # look for the study without the write lock first, because a study is often submitted again
        if key is None:
            with self.catalogue.reading() as connection:
                row = newest_row(connection, study.digest)
            if row is not None:
                return record_of(row), False
        return self.submit_all([Submission(study, plan, provenance, reuse, key, priority)])[0]

    def submit_all(self, submissions: Sequence[Submission]) -> Entered:
        """Submit several studies as `submit` does. Either all of the studies are entered, or none."""
        # add the owner in this thread, because another thread may enter the studies
        return self._turns.ask([replace(one, provenance=signed(one.provenance)) for one in submissions])

    def _submit_lists(self, lists: Sequence[Sequence[Submission]]) -> list[Entered | Exception]:
        """Enter the submissions of several threads. If one list is refused, the other lists are still entered."""

        def decide(connection: Connection) -> tuple[list[Entry], Callable[[list[Record]], list[Any]]]:
            asked = _Asked(connection, lists)
            ledger = Ledger(connection, self.quota)
            entries: dict[str, Entry] = {}
            refused: dict[int, Exception] = {}
            for place, some in enumerate(lists):
                fresh = {
                    one.study.digest: Entry(
                        one.study, one.plan.chunk, one.provenance, one.reuse, priority=one.priority
                    )
                    for one in reversed(some)
                    if one.study.digest not in asked.known and one.study.digest not in entries
                }
                try:
                    asked.require_sound(some)
                    ledger.enter(
                        some[0].provenance.get(SUBMITTED_BY) if some else None,
                        sum(entry.study.points for entry in fresh.values()),
                        sum(entry.bytes for entry in fresh.values()),
                        len(fresh),
                    )
                except (KeyTaken, QuotaReached, CatalogueDamaged) as error:
                    refused[place] = error
                else:
                    entries |= {digest: fresh[digest] for digest in reversed(fresh)}
                    asked.take_keys(some)

            def answer(entered: list[Record]) -> list[Entered | Exception]:
                asked.keep_keys()
                records = asked.known | dict(zip(entries, entered, strict=True))
                untold = set(entries)

                def told(one: Submission) -> tuple[Record, bool]:
                    digest = one.study.digest
                    created = digest in untold
                    untold.discard(digest)  # report the study as created to only one of several submitters
                    return records[digest], created

                return [refused.get(place) or list(map(told, some)) for place, some in enumerate(lists)]

            return list(entries.values()), answer

        return self.enter(decide, "submitted")

    def enter(
        self, decide: Callable[[Connection], tuple[list[Entry], Callable[[list[Record]], _Answer]]], what: str
    ) -> _Answer:
        """Enter studies in three steps: reserve numbers, create the cubes, and write the rows.

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
                # remove cubes that were created for another plan, or whose numbers were withdrawn as garbage
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

    def _reserve(self, connection: Connection, entries: Sequence[Entry]) -> list["_Made"]:
        """Reserve new numbers. The new rows look like the rows of deleted studies without files."""
        now = time.time()
        numbers: list[int] = []
        for some in pieces([_reserved(now)] * len(entries)):
            new = insert(studies).returning(studies.c.number, sort_by_parameter_order=True)
            numbers += connection.execute(new, some).scalars()
        return [_Made(entry, number, now) for entry, number in zip(entries, numbers, strict=True)]

    def _make(self, fresh: Sequence["_Made"]) -> None:
        cubes = {each.name: each.files() for each in fresh}
        with using(self.shelf.address):
            self.shelf.make(cubes, (BLOCKS,))

    def _discard(self, several: Sequence["_Made"]) -> None:
        """Remove cubes whose studies were not entered, and withdraw the reserved numbers."""
        with suppress(StoreFault, OSError):
            # withdraw only numbers that are still reserved, because a rebuild may have used the other numbers
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
        """Remove the rows of unused reserved numbers. The database never assigns these numbers again."""
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
        for rows in pieces(_row(each, ever.get(each.entry.id, 0)) for each in several):
            names = rows[0].keys() - {"number"}
            change = update(studies).where(c.number == bindparam("of_number"))
            connection.execute(
                change.values({name: bindparam(f"to_{name}") for name in names}),
                [{"of_number": row["number"], **{f"to_{name}": row[name] for name in names}} for row in rows],
            )
        now = time.time()
        for noted in pieces({"study": each.entry.id, "at": now, "what": what} for each in several):
            connection.execute(insert(events), noted)
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
        """Raise `StoreFault` if an earlier submission found that this catalogue is an older copy."""
        with self.catalogue.reading() as connection:
            name = fact(connection, UNKNOWN_RESULTS)
            parsed = parse_cube_name(name or "")
            ours = (
                parsed
                and connection.execute(
                    select(studies.c.id).where(studies.c.number == parsed[1], studies.c.id == parsed[0])
                ).first()
            )
        if name is None:
            return
        shelf = self.shelf.at(name)
        if not ours and holds_results(shelf):
            raise older_copy(shelf.address, self.catalogue.name)
        with self.catalogue.writing() as connection:
            forget(connection, UNKNOWN_RESULTS)


class _Asked:
    """The entries that the catalogue already has for the submitted studies and idempotency keys."""

    def __init__(self, connection: Connection, lists: Iterable[Sequence[Submission]]) -> None:
        self._connection = connection
        submissions = [one for some in lists for one in some]
        self.known: dict[str, Record] = {}
        self._damaged: dict[str, CatalogueDamaged] = {}
        for digests in pieces(dict.fromkeys(one.study.digest for one in submissions)):
            query = select(studies).where(studies.c.digest.in_(digests), ALIVE).order_by(studies.c.version)
            for row in connection.execute(query):
                with self._noting(row.digest):
                    self.known[row.digest] = record_of(row)
        self._keys: dict[str, str] = {}
        for names in pieces(one.key for one in submissions if one.key is not None):
            for row in connection.execute(select(keys).where(keys.c.key.in_(names))):
                self._keys[row.key] = row.digest
                with self._noting(row.key):
                    require_row(keys, row, row.digest[:12])
        self._new: dict[str, str] = {}

    @contextmanager
    def _noting(self, name: str) -> Iterator[None]:
        """Store the error for a damaged row, so that only submissions that need this row are refused."""
        try:
            yield
        except CatalogueDamaged as error:
            self._damaged[name] = error

    def require_sound(self, some: Iterable[Submission]) -> None:
        """Raise `CatalogueDamaged` if a row is damaged, and `KeyTaken` if a key was used for another definition."""
        for one in some:
            for name in (one.study.digest, one.key):
                if name in self._damaged:
                    raise self._damaged[name]
            known = one.key and self._keys.get(one.key)
            if known and known != one.study.digest:
                raise KeyTaken(
                    Fault(
                        "Idempotency-Key",
                        f"{describe(one.key)}, already given to study {known[:12]}",
                        "a different key for each study",
                        "send the same definition as before, or another key",
                        f"The idempotency key {printable(one.key or '')} was already given to study "
                        f"{known[:12]}, which has another definition.",
                    )
                )

    def take_keys(self, some: Iterable[Submission]) -> None:
        """Assign the idempotency keys of a list of submissions to the definitions."""
        new = {one.key: one.study.digest for one in some if one.key and one.key not in self._keys}
        self._new |= new
        self._keys |= new

    def keep_keys(self) -> None:
        """Write newly used idempotency keys into the catalogue."""
        rows = ({"key": key, "digest": digest, "at": time.time()} for key, digest in self._new.items())
        for some in pieces(rows):
            self._connection.execute(insert(keys), some)


@dataclass(frozen=True)
class _Made:
    """A new cube whose study has not been entered yet."""

    entry: Entry
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
    """Return those numbers of cubes that are still reserved."""
    found: set[int] = set()
    for some in pieces(each.number for each in several):
        query = select(studies.c.number).where(studies.c.number.in_(some), RESERVED)
        found |= set(connection.execute(query).scalars())
    return found


def _is_made(entry: Entry, made: dict[str, _Made], reserved: set[int]) -> bool:
    known = made.get(entry.id)
    # the cube must have been created for this very submission, and its number must still be reserved
    return known is not None and known.entry.study is entry.study and known.number in reserved


def _row(made: _Made, revision: int) -> dict[str, Any]:
    new = {"created": made.created, "deleted": None, "revision": revision, "taken_back": revision}
    return {"number": made.number, **made.entry.columns(), **new}


def box_of(study: AnyStudy) -> list[list[Any]]:
    """Return the bounding box of a study's grid: the lowest and the highest value along every numeric dimension."""
    return [
        [float(values[0]), float(values[-1])]
        for values in study.coordinates.values()
        if values.dtype.kind == "f"
    ]


def _reserved(now: float) -> dict[str, Any]:
    texts = dict.fromkeys(("id", "digest", "name", "definition", "provenance"), "")
    sizes = dict.fromkeys(("points_total", "blocks_total"), 0)
    return {**texts, **sizes, "state": "queued", "shape": "[]", "chunk": "[]", "created": now, "deleted": now}
