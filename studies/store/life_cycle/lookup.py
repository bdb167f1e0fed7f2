"""Finds a study by its name, lists studies page by page under conditions, and lists the events of a study."""

import json
import math
import re
from dataclasses import dataclass
from typing import Any

from sqlalchemy import ColumnElement, Row, func, not_, select

from damperlab.studies.faults import describe, listing, write_nearest
from damperlab.studies.kinds import EVERY_DIMENSION, dimensions_of_definition
from damperlab.studies.remarks import faults_of_tag
from damperlab.studies.store.catalogue.rows import (
    ALIVE,
    FIRST_DIGITS,
    VALUES,
    alive_row,
    asked_for,
    in_trash,
    newest_row,
    record_of,
    study_row,
    too_few_digits,
    unknown_study,
)
from damperlab.studies.store.catalogue.rowsum import require_row
from damperlab.studies.store.catalogue.tables import events, studies
from damperlab.studies.store.cubes import Cubes
from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.provenance import DESIGNS, REFINES
from damperlab.studies.store.record import Page, Record, Totals
from damperlab.studies.unit_names import ALIASES, COORDINATE_NAMES
from damperlab.studies.vocabulary import STATES

PAGE_LIMIT = 1000
"""Largest number of records on one page."""
MOST_LOOKED_AT = 5000
"""Largest number of studies whose axes are examined for one page."""
_OF_TEXTS = ("record",)  # dimensions whose values are texts, which have no range


@dataclass(frozen=True, kw_only=True)
class Wanted:
    """Conditions that a listed study must satisfy. None stands for no condition.

    Parameters
    ----------
    state : str, optional
        State of the study.
    name : str, optional
        Text that the name of the study contains; the case of ASCII letters is ignored.
    tag : str, optional
        Tag that the study has.
    axis : str, optional
        Dimension of the study, or quantity in the study's physical block that corresponds to a dimension.
    low, high : float, optional
        Least and greatest value along `axis`. The values of the study along this axis must overlap this range.
    designs : bool
        Whether to list every study of a design or a refinement. If false, such a study is listed only if
        `tag`, `name`, or a `state` other than `done` is given.
    trash : bool
        Whether to list deleted studies that can be restored, instead of the existing studies.

    Raises
    ------
    StoreFault
        If a condition is invalid.
    """

    state: str | None = None
    name: str | None = None
    tag: str | None = None
    axis: str | None = None
    low: float | None = None
    high: float | None = None
    designs: bool = True
    trash: bool = False

    def __post_init__(self) -> None:
        """Refuse invalid conditions."""
        for fault in () if self.tag is None else faults_of_tag("tag", self.tag):
            raise StoreFault(fault.field, fault.found, fault.allowed, fault.advice)
        names = dict.fromkeys((*EVERY_DIMENSION, *COORDINATE_NAMES, *ALIASES))
        axes = [name for name in names if name not in _OF_TEXTS]
        if self.state is not None and self.state not in STATES:
            advice = write_nearest(self.state, STATES, "leave it out for every state")
            raise StoreFault("state", describe(self.state), f"one of {listing(STATES)}", advice)
        if self.axis is not None and self.axis not in axes:
            advice = write_nearest(self.axis, axes, "leave it out for every study")
            raise StoreFault("axis", describe(self.axis), f"one of {listing(axes)}", advice)
        ends = {"from": self.low, "to": self.high}
        for name, end in ends.items():
            if end is not None and (self.axis is None or math.isnan(end)):
                allowed = "a number" if self.axis else "no value without an axis"
                raise StoreFault(name, describe(end), allowed, "name the `axis` as well, or leave it out")
        if None not in ends.values() and self.low > self.high:  # type: ignore[operator]
            allowed = f"at least {self.low:g}, the value of `from`"
            raise StoreFault("to", describe(self.high), allowed, "exchange them")

    def clauses(self) -> list[ColumnElement[bool]]:
        """Return the SQL clauses of the conditions that the database can check."""
        found: list[ColumnElement[bool]] = [in_trash() if self.trash else ALIVE]
        if self.state is not None:
            found.append(studies.c.state == self.state)
        if self.name:
            text = self.name.encode(errors="replace").decode().replace("\0", "?")
            found.append(studies.c.name.icontains(text, autoescape=True))
        if self.tag is not None:
            found.append(studies.c.tags.contains(json.dumps(self.tag), autoescape=True))
        if not self.designs and self.tag is None and not self.name and self.state in (None, "done"):
            found += [not_(asked_for(purpose)) for purpose in (DESIGNS, REFINES)]
        return found

    def fits(self, row: Row[Any]) -> bool:
        """Whether the study's values along the axis overlap the range from `low` to `high`.

        The database cannot check this condition.
        """
        definition = json.loads(row.definition)
        names = [name for name in dimensions_of_definition(definition) if name not in _OF_TEXTS]
        box = dict(zip(names, json.loads(row.box), strict=True))
        ends = box.get(str(self.axis)) or self._ends_in_units(definition)
        if ends is None:
            return False
        first, last = ends
        reaches = self.low is None or last >= self.low
        return bool(reaches and (self.high is None or first <= self.high))

    def _ends_in_units(self, definition: dict[str, Any]) -> list[float] | None:
        """Return the lowest and the highest value along `axis` in the physical block; None if the block has no such
        entry.
        """
        physical = definition.get("physical") or {}
        # the excitation frequency has different names in the physical block and as a coordinate
        own = {coordinate: name for name, coordinate in ALIASES.items()}
        given = physical.get(own.get(str(self.axis), self.axis))
        if given is None:
            return None
        values = [given["start"], given["stop"]] if isinstance(given, dict) else given
        values = values if isinstance(values, list) else [values]
        return [float(min(values)), float(max(values))]


ALL = Wanted()
"""Conditions that every existing study satisfies."""


class Lookup(Cubes):
    """The part of a store that finds studies."""

    def find(self, ref: str) -> Record:
        """Find a study by its complete id, by its name, or by the first digits of its id, in this order.

        If several studies have this name, the newest study is returned. If the digits fit several versions of
        a study, the newest version is returned.

        Raises
        ------
        StudyNotFound
            If no study fits, if the digits fit several studies, or if fewer than `FIRST_DIGITS` digits are given.
        """
        ref = storable(ref)
        with self.catalogue.reading() as connection:
            row = alive_row(connection, ref)
            if row is not None:
                return record_of(row)
            newest = select(studies).where(ALIVE).order_by(studies.c.number.desc())
            named = ref and connection.execute(newest.where(studies.c.name == ref).limit(1)).one_or_none()
            if named:
                return record_of(named)
            starts = func.substr(studies.c.id, 1, len(ref)) == ref.lower()
            fits = connection.execute(newest.where(starts).limit(4)).all() if ref else []
            if not fits:
                raise unknown_study(connection, ref)
            if len(ref) < FIRST_DIGITS or len({row.digest for row in fits}) > 1:
                raise too_few_digits(ref, fits)
            return record_of(max(fits, key=lambda row: row.version))  # the newest of several versions

    def namesakes(self, record: Record) -> int:
        """Count the other studies that have the same name as a study. Versions of the study itself do not count."""
        others = ALIVE, studies.c.name == record.name, studies.c.digest != record.digest
        with self.catalogue.reading() as connection:
            return int(connection.execute(select(func.count()).where(*others)).scalar_one())

    def existed(self, study_id: str) -> bool:
        """Whether a study with this complete id exists or was deleted."""
        with self.catalogue.reading() as connection:
            found = connection.execute(select(studies.c.number).where(studies.c.id == study_id).limit(1))
            return found.first() is not None

    def newest(self, digest: str) -> Record | None:
        """Return the newest version of the study with this digest; None if there is no such study."""
        with self.catalogue.reading() as connection:
            row = newest_row(connection, digest)
        return None if row is None else record_of(row)

    def versions(self, study_id: str) -> list[Record]:
        """Return every version of a study, oldest first.

        Raises
        ------
        StudyNotFound
            If there is no such study.
        """
        with self.catalogue.reading() as connection:
            digest = study_row(connection, study_id).digest
            query = select(studies).where(studies.c.digest == digest, ALIVE).order_by(studies.c.version)
            return [record_of(row) for row in connection.execute(query)]

    def page(self, limit: int = 50, cursor: str | None = None, wanted: Wanted = ALL) -> Page:
        """Return one page of records, newest first.

        Parameters
        ----------
        limit : int
            Largest number of records on the page, 1 to `PAGE_LIMIT`.
        cursor : str, optional
            Cursor from the previous page; by default the first page is returned.
        wanted : Wanted
            Conditions on the studies. With a condition on an axis, a page may have fewer than `limit` records although
            more pages follow.

        Raises
        ------
        StoreFault
            If `limit` or `cursor` is invalid.
        """
        if not 1 <= limit <= PAGE_LIMIT:
            raise StoreFault("limit", str(limit), f"a number from 1 to {PAGE_LIMIT}", "ask page by page")
        query = select(studies).where(*wanted.clauses()).order_by(studies.c.number.desc())
        if cursor is not None and not re.fullmatch("before-[0-9]{1,18}", cursor):
            allowed, advice = "the cursor of a page", "leave it out for the first page"
            raise StoreFault("cursor", describe(cursor), allowed, advice)
        before = math.inf if cursor is None else int(cursor.removeprefix("before-"))
        found: list[Row[Any]] = []
        looked_at, more = 0, True
        with self.catalogue.reading() as connection:
            while more and len(found) < limit and looked_at < MOST_LOOKED_AT:
                # read one row more than needed, to detect whether more rows follow
                size = limit if wanted.axis is None else VALUES
                behind = query if before == math.inf else query.where(studies.c.number < before)
                rows = connection.execute(behind.limit(size + 1)).all()
                more = len(rows) > size
                for row in rows[:size]:
                    if len(found) == limit:
                        more = True
                        break
                    looked_at, before = looked_at + 1, row.number
                    if wanted.axis is None or wanted.fits(row):
                        found.append(row)
        return Page(tuple(map(record_of, found)), f"before-{before}" if more else None)

    def totals(self) -> dict[str, Totals]:
        """Return the sums over the studies in each state. States without studies are left out."""
        c = studies.c
        sums = (
            c.points_total,
            c.points_done,
            c.points_failed,
            c.bytes_total,
            c.blocks_total - c.blocks_done,
        )
        query = select(c.state, func.count(), *(func.sum(one) for one in sums)).where(ALIVE).group_by(c.state)
        with self.catalogue.reading() as connection:
            return {row[0]: Totals(*map(int, row[1:])) for row in connection.execute(query)}

    def events(self, study_id: str) -> list[tuple[float, str]]:
        """Return the events of a study, oldest first. Each event is a time in seconds since 1970 and a text."""
        query = select(events).where(events.c.study == study_id).order_by(events.c.number)
        with self.catalogue.reading() as connection:
            rows = connection.execute(query).all()
        for row in rows:
            require_row(events, row, study_id)
        return [(row.at, row.what) for row in rows]


def storable(text: str) -> str:
    """Replace lone surrogates and NUL, which databases refuse."""
    return text.encode(errors="replace").decode().replace("\0", "?")
