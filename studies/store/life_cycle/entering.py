"""Studies enter a store: once, however often they are asked for, and many in one transaction where many come at once."""

import json
import math
import time
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from typing import Any, TypeVar

from sqlalchemy import Connection, func, insert, select

from damperlab.studies.digest import family_digest
from damperlab.studies.faults import Fault, describe, printable
from damperlab.studies.kind import AnyStudy
from damperlab.studies.plan import Plan
from damperlab.studies.store.catalogue.base import StoreBase
from damperlab.studies.store.catalogue.box import box_of
from damperlab.studies.store.catalogue.home import (
    BACKUP_OF,
    cube_name,
    disk_gone,
    forget,
    is_of_block,
    older_copy,
)
from damperlab.studies.store.catalogue.quota import Ledger
from damperlab.studies.store.catalogue.rows import ALIVE, newest_row, record_of
from damperlab.studies.store.catalogue.rowsum import require_row
from damperlab.studies.store.catalogue.tables import events, keys, studies
from damperlab.studies.store.catalogue.turns import Turns
from damperlab.studies.store.cube.cube import block_grid, bytes_per_point, first_files
from damperlab.studies.store.cube.packed import BLOCKS
from damperlab.studies.store.faults import CatalogueDamaged, KeyTaken, QuotaReached, cannot_use
from damperlab.studies.store.files.shelf import AT_ONCE
from damperlab.studies.store.record import Record
from damperlab.studies.store.submitter import SUBMITTED_BY, signed

_VALUES = 500  # values in one statement
_MOST = 256  # studies that share a transaction: others want to write too

_Item = TypeVar("_Item")


@dataclass(frozen=True)
class Submission:
    """What is handed in.

    Parameters
    ----------
    study, plan : AnyStudy, Plan
        What is asked, and how its grid is cut.
    provenance : dict of str
        See `damperlab.studies.store.provenance.provenance`.
    reuse : bool
        Whether points that earlier studies hold may be taken from them.
    key : str, optional
        A name that the caller gave this submission; it stands for this definition from now on.
    priority : int
        See `Record`; a study that is there already keeps its own.
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
        What is asked.
    chunk : tuple of int
        Extent of a block.
    provenance : dict of str
        Of what will compute it.
    reuse : bool
        Whether points may be taken from earlier studies.
    version : int
        1 for a study as it was submitted.
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
        """What it takes when it is done, before compression."""
        return self.study.points * bytes_per_point(self.study)


Entered = list[tuple[Record, bool]]


class Entering(StoreBase):
    """How studies enter a store."""

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
        """Keep a study and make its empty cube, unless the same definition is there already; see `Submission`.

        Returns
        -------
        record : Record
            The study's record, new or found.
        created : bool
            Whether it is new. Of any number of processes that submit one definition at once, one makes it.

        Raises
        ------
        StoreFault
            If the cube cannot be written.
        QuotaReached
            If the study would take more than is left.
        KeyTaken
            If the key was given to another definition before.
        """
        # seen without a turn at writing first: the same study is asked for again and again
        if key is None:
            with self.catalogue.reading() as connection:
                row = newest_row(connection, study.digest)
            if row is not None:
                return record_of(row), False
        return self.submit_all([Submission(study, plan, provenance, reuse, key, priority)])[0]

    def submit_all(self, submissions: Sequence[Submission]) -> Entered:
        """Keep several studies, all or none, as `submit` does; what other threads hand in shares the transaction."""
        # whose they are is known here: another thread may enter them
        return self._turns.ask([replace(one, provenance=signed(one.provenance)) for one in submissions])

    def _submit_lists(self, lists: Sequence[Sequence[Submission]]) -> list[Entered | Exception]:
        """Enter what several threads have handed in; what refuses one list leaves the others alone."""
        with self.catalogue.writing() as connection:
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
            asked.keep_keys()
            records = dict(
                zip(entries, self.enter(connection, list(entries.values()), "submitted"), strict=True)
            )
            return [
                refused.get(place) or self._answer(asked, records, some) for place, some in enumerate(lists)
            ]

    @staticmethod
    def _answer(asked: "_Asked", records: dict[str, Record], some: Sequence[Submission]) -> Entered:
        answers = []
        told: set[str] = set()
        for one in some:
            digest = one.study.digest
            if digest in records:
                answers.append((records[digest], digest not in told and digest not in asked.told))
                told.add(digest)
            else:
                answers.append((asked.known[digest], False))
        asked.told |= told
        return answers

    def enter(self, connection: Connection, entries: Sequence[Entry], what: str) -> list[Record]:
        """Give studies their rows and empty cubes; `what` is noted among their events.

        Raises
        ------
        StoreFault
            If a cube cannot be written; nothing is left of any then.
        """
        if not entries:
            return []
        c = studies.c
        now = time.time()
        # a backup that studies are submitted to lives on its own: the next copy would take them away
        forget(connection, BACKUP_OF)
        # a reader that keeps to a revision of a study that was deleted must not find it in the new one
        ever: dict[str, int] = {}
        for some in _pieces(entry.study.digest for entry in entries):
            query = select(c.id, func.max(c.revision) + 1).where(c.digest.in_(some)).group_by(c.id)
            ever |= {row[0]: row[1] for row in connection.execute(query)}
        rows = [_row(entry, ever.get(entry.id, 0), now) for entry in entries]
        numbers: list[int] = []
        for several in _pieces(rows):
            new = insert(studies).returning(c.number, sort_by_parameter_order=True)
            numbers += connection.execute(new, several).scalars()
        cubes = {
            cube_name(entry.id, number): first_files(
                entry.study, entry.chunk, entry.provenance, reuse=entry.reuse, created=now
            )
            for entry, number in zip(entries, numbers, strict=True)
        }
        self._make_way(list(cubes))
        try:
            # made before the commit: who sees a study finds its cube
            self.shelf.make(cubes, (BLOCKS,))
        except BaseException as error:
            for name in cubes:
                with suppress(OSError):
                    self.shelf.at(name).clear()
            if isinstance(error, OSError):
                raise cannot_use(self.shelf.address, error) from error
            raise
        for noted in _pieces({"study": entry.id, "at": now, "what": what} for entry in entries):
            connection.execute(insert(events), noted)
        found: dict[int, Record] = {}
        for given in _pieces(numbers):
            for row in connection.execute(select(studies).where(c.number.in_(given))):
                found[row.number] = record_of(row)
        return [found[number] for number in numbers]

    def _make_way(self, names: list[str]) -> None:
        """Remove what submissions that were cut short left under some names; raise `StoreFault` where results lie there."""

        gone = disk_gone(self.shelf)
        if gone is not None:
            raise cannot_use(self.shelf.address, FileNotFoundError(gone))

        def clear(name: str) -> bool:
            shelf = self.shelf.at(name)
            entries = list(shelf.entries())
            if any(is_of_block(entry) for entry in entries):
                return False
            if entries:
                shelf.clear()
            return True

        try:
            with ThreadPoolExecutor(AT_ONCE) as pool:
                free = list(pool.map(clear, names)) if len(names) > 1 else [clear(name) for name in names]
        except OSError as error:
            raise cannot_use(self.shelf.address, error) from error
        taken = next((name for name, good in zip(names, free, strict=True) if not good), None)
        if taken is not None:
            raise older_copy(self.shelf.at(taken).address, self.catalogue.name)


class _Asked:
    """What the catalogue knows of the studies and keys that are handed in."""

    def __init__(self, connection: Connection, lists: Iterable[Sequence[Submission]]) -> None:
        self._connection = connection
        submissions = [one for some in lists for one in some]
        self.known: dict[str, Record] = {}
        self._damaged: dict[str, CatalogueDamaged] = {}
        for digests in _pieces(dict.fromkeys(one.study.digest for one in submissions)):
            query = select(studies).where(studies.c.digest.in_(digests), ALIVE).order_by(studies.c.version)
            for row in connection.execute(query):
                with self._noting(row.digest):
                    self.known[row.digest] = record_of(row)
        self._keys: dict[str, str] = {}
        for names in _pieces(one.key for one in submissions if one.key is not None):
            for row in connection.execute(select(keys).where(keys.c.key.in_(names))):
                self._keys[row.key] = row.digest
                with self._noting(row.key):
                    require_row(keys, row, row.digest[:12])
        self._new: dict[str, str] = {}
        self.told: set[str] = set()
        """Digests of studies that another list has been told to have made."""

    @contextmanager
    def _noting(self, name: str) -> Iterator[None]:
        """Keep the damage of a row for who asks for it: it is nobody else's."""
        try:
            yield
        except CatalogueDamaged as error:
            self._damaged[name] = error

    def require_sound(self, some: Iterable[Submission]) -> None:
        """Raise `CatalogueDamaged` for a damaged row, and `KeyTaken` where a key stands for another definition."""
        for one in some:
            for name in (one.study.digest, one.key):
                if name in self._damaged:
                    raise self._damaged[name]
            known = one.key and self._keys.get(one.key)
            if known and known != one.study.digest:
                raise KeyTaken(
                    Fault(
                        "Idempotency-Key",
                        f"{describe(one.key)}, given to study {known[:12]} before",
                        "a different key for each study",
                        "send the same definition as before, or another key",
                        f"The idempotency key {printable(one.key or '')} was given to study {known[:12]} "
                        "before, which has another definition.",
                    )
                )

    def take_keys(self, some: Iterable[Submission]) -> None:
        """Let the keys of a list stand for its definitions."""
        new = {one.key: one.study.digest for one in some if one.key and one.key not in self._keys}
        self._new |= new
        self._keys |= new

    def keep_keys(self) -> None:
        """Write what was taken."""
        rows = ({"key": key, "digest": digest, "at": time.time()} for key, digest in self._new.items())
        for some in _pieces(rows):
            self._connection.execute(insert(keys), some)


def _row(entry: Entry, revision: int, now: float) -> dict[str, Any]:
    study = entry.study
    return {
        "id": entry.id,
        "digest": study.digest,
        "version": entry.version,
        "name": study.name,
        "state": "queued",
        "definition": json.dumps(study.document()),
        "provenance": json.dumps(entry.provenance),
        "shape": json.dumps(study.shape),
        "chunk": json.dumps(entry.chunk),
        "points_total": study.points,
        "bytes_total": entry.bytes,
        "blocks_total": math.prod(block_grid(study.shape, entry.chunk)),
        "family": family_digest(study, entry.provenance),
        "box": json.dumps(box_of(study)),
        "reuse": entry.reuse,
        "priority": entry.priority,
        "created": now,
        "revision": revision,
        "taken_back": revision,
    }


def _pieces(items: Iterable[_Item]) -> Iterator[list[_Item]]:
    """Cut what may be long into lists that one statement takes."""
    every = list(items)
    for start in range(0, len(every), _VALUES):
        yield every[start : start + _VALUES]
