"""Submission of studies. A study is entered once, however often it is submitted; simultaneous submissions share a
transaction.
"""

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
from damperlab.studies.store.cube.cube import block_grid, bytes_per_point
from damperlab.studies.store.cube.description import first_pieces
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

_MOST = 256  # most studies in one transaction: other writers must not wait long

_Answer = TypeVar("_Answer")


@dataclass(frozen=True)
class Submission:
    """The submitted content.

    Parameters
    ----------
    study, plan : AnyStudy, Plan
        The study, and the division of its grid.
    provenance : dict of str
        See `damperlab.studies.store.provenance.provenance`.
    reuse : bool
        Whether it may reuse points of earlier studies.
    key : str, optional
        A name that the caller gives this submission; from then on it stands for this definition.
    priority : int
        See `Record`; an existing study keeps its own.
    """

    study: AnyStudy
    plan: Plan
    provenance: dict[str, str]
    reuse: bool = True
    key: str | None = None
    priority: int = 0

    def __post_init__(self) -> None:
        """Refuse a plan of another study."""
        if self.plan.count != math.prod(block_grid(self.study.shape, self.plan.chunk)):
            raise ValueError(
                f"a plan of {self.plan.count} blocks does not cut {self.study.shape} by {self.plan.chunk}"
            )


@dataclass(frozen=True)
class Entry:
    """A study that is about to be entered.

    Parameters
    ----------
    study : AnyStudy
        The study.
    chunk : tuple of int
        Extent of a block.
    provenance : dict of str
        Provenance of the solver.
    reuse : bool
        Whether it may reuse points of earlier studies.
    version : int
        1 for a study as submitted.
    priority : int
        See `Record`.
    """

    study: AnyStudy
    chunk: tuple[int, ...]
    provenance: dict[str, str]
    reuse: bool
    version: int = 1
    priority: int = 0

    @property
    def id(self) -> str:
        """The study's id."""
        return self.study.digest[:12] + (f"-{self.version}" if self.version > 1 else "")

    @property
    def bytes(self) -> int:
        """Usage of the complete study, before compression."""
        return self.study.points * bytes_per_point(self.study)

    def columns(self) -> dict[str, Any]:
        """Give the values for its row."""
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
    """The part of the store that enters studies."""

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
        """Store a study and create its empty cube, unless the same definition exists already; see `Submission`.

        Returns
        -------
        record : Record
            The study's record, new or found.
        created : bool
            Whether it is new. Among any number of processes that submit one definition simultaneously, one creates
            it.

        Raises
        ------
        StoreFault
            If the cube cannot be written.
        QuotaReached
            If the study would exceed the remaining quota.
        KeyTaken
            If the key belongs to another definition.
        """
        # checked first without the write lock, because the same study is often submitted again
        if key is None:
            with self.catalogue.reading() as connection:
                row = newest_row(connection, study.digest)
            if row is not None:
                return record_of(row), False
        return self.submit_all([Submission(study, plan, provenance, reuse, key, priority)])[0]

    def submit_all(self, submissions: Sequence[Submission]) -> Entered:
        """Store several studies, all or none, as `submit` does; submissions of other threads share the transaction."""
        # the owner is read here, because another thread may enter the studies
        return self._turns.ask([replace(one, provenance=signed(one.provenance)) for one in submissions])

    def _submit_lists(self, lists: Sequence[Sequence[Submission]]) -> list[Entered | Exception]:
        """Enter the submissions of several threads; the refusal of one list does not affect the others."""

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
                    untold.discard(digest)  # if several submitted it, one of them has created it
                    return records[digest], created

                return [refused.get(place) or list(map(told, some)) for place, some in enumerate(lists)]

            return list(entries.values()), answer

        return self.enter(decide, "submitted")

    def enter(
        self, decide: Callable[[Connection], tuple[list[Entry], Callable[[list[Record]], _Answer]]], what: str
    ) -> _Answer:
        """Enter studies: one transaction reserves numbers, cubes are created, and another transaction writes the
        rows.

        No cube is created inside a transaction: a slow disk or server blocks no writer. A visible study always has its
        cube, which was created before. A kill in between leaves a reserved number and a cube without results, which
        `collect_garbage` removes.

        Parameters
        ----------
        decide : callable
            Called in each transaction; gives the studies to enter into the present catalogue, and a function that makes
            the answer.
        what : str
            Recorded among the studies' events.

        Raises
        ------
        StoreFault
            If a cube cannot be written; then no cube is left.
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
                # created for another plan, or withdrawn as garbage meanwhile
                self._discard([made.pop(each.entry.id) for each in fresh if each.entry.id in made])
                self._make_way(fresh)
                made |= {each.entry.id: each for each in fresh}
                self._make(fresh)
        except StoreFault as error:
            if isinstance(error.__cause__, ShelfAway):
                made.clear()  # a server that does not answer removes nothing; its pieces become garbage
            raise
        finally:
            self._discard([each for study_id, each in made.items() if study_id not in entered])
        return answered

    def _reserve(self, connection: Connection, entries: Sequence[Entry]) -> list["_Made"]:
        """Reserve new numbers, with rows like those of deleted studies whose files were removed."""
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
        """Withdraw cubes and numbers without a study; what cannot be removed becomes garbage."""
        with suppress(StoreFault, OSError):
            # a rebuild may have entered the study of a reserved number: only unused ones are withdrawn
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
        """Remove unused reserved numbers from the catalogue; no number is given twice anyway."""
        with suppress(StoreFault):
            for some in pieces(numbers):
                with self.catalogue.writing() as connection:
                    connection.execute(delete(studies).where(studies.c.number.in_(some), NEVER_ENTERED))

    def _publish(self, connection: Connection, several: Sequence["_Made"], what: str) -> list[Record]:
        """Write the rows of studies whose cubes exist."""
        if not several:
            return []
        c = studies.c
        # a backup with its own submissions becomes independent, since the next copy would remove them
        forget(connection, BACKUP_OF)
        # a reader at a revision of a deleted study must not find the same revision in the new study
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
        """Check that the locations of new cubes are empty; raise `StoreFault` if they hold results."""
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
        """Remove the remains of an interrupted submission under a name; False if there are results."""
        shelf = self.shelf.at(name)
        entries = list(shelf.entries())
        if any(is_of_block(entry) for entry in entries):
            return False
        if entries:
            shelf.clear()
        return True

    def _require_newest(self) -> None:
        """Refuse to continue if an earlier submission found that this catalogue is an older copy."""
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
    """The catalogue's entries for the submitted studies and keys."""

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
        """Assign the damage of a row to the submission concerned, so that it does not affect the others."""
        try:
            yield
        except CatalogueDamaged as error:
            self._damaged[name] = error

    def require_sound(self, some: Iterable[Submission]) -> None:
        """Raise `CatalogueDamaged` for a damaged row, and `KeyTaken` if a key belongs to another definition."""
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
        """Assign the keys of a list to its definitions."""
        new = {one.key: one.study.digest for one in some if one.key and one.key not in self._keys}
        self._new |= new
        self._keys |= new

    def keep_keys(self) -> None:
        """Record the use of keys."""
        rows = ({"key": key, "digest": digest, "at": time.time()} for key, digest in self._new.items())
        for some in pieces(rows):
            self._connection.execute(insert(keys), some)


@dataclass(frozen=True)
class _Made:
    """A cube that waits for its study's row."""

    entry: Entry
    number: int
    created: float

    @property
    def name(self) -> str:
        """Name of its shelf."""
        return cube_name(self.entry.id, self.number)

    def files(self) -> dict[str, bytes]:
        """Give the pieces of a cube that has no blocks yet."""
        entry = self.entry
        first = first_pieces(
            entry.study, entry.chunk, entry.provenance, reuse=entry.reuse, created=self.created
        )
        return first | entry.study.attachments()


def _still_reserved(connection: Connection, several: Iterable[_Made]) -> set[int]:
    """Give the reserved numbers that were not withdrawn as garbage meanwhile."""
    found: set[int] = set()
    for some in pieces(each.number for each in several):
        query = select(studies.c.number).where(studies.c.number.in_(some), RESERVED)
        found |= set(connection.execute(query).scalars())
    return found


def _is_made(entry: Entry, made: dict[str, _Made], reserved: set[int]) -> bool:
    known = made.get(entry.id)
    # if a definition was submitted twice, the other submission may have entered it by now
    return known is not None and known.entry.study is entry.study and known.number in reserved


def _row(made: _Made, revision: int) -> dict[str, Any]:
    new = {"created": made.created, "deleted": None, "revision": revision, "taken_back": revision}
    return {"number": made.number, **made.entry.columns(), **new}


def box_of(study: AnyStudy) -> list[list[Any]]:
    """Give the lowest and the highest value along every numeric dimension, in the cube's order."""
    return [
        [float(values[0]), float(values[-1])]
        for values in study.coordinates.values()
        if values.dtype.kind == "f"
    ]


def _reserved(now: float) -> dict[str, Any]:
    texts = dict.fromkeys(("id", "digest", "name", "definition", "provenance"), "")
    sizes = dict.fromkeys(("points_total", "blocks_total"), 0)
    return {**texts, **sizes, "state": "queued", "shape": "[]", "chunk": "[]", "created": now, "deleted": now}
