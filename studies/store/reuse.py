"""Search for earlier studies of a family, and for the points that they have computed at identical coordinates.

The studies of a family have the same solver and settings, and differ only in their grids. A study whose rows in the
catalogue are damaged is left out; a query for that study reports the damage.
"""

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from sqlalchemy import and_, not_, select

from damperlab.studies.kind import AnyStudy
from damperlab.studies.plan import Block
from damperlab.studies.store.catalogue.rows import ALIVE, asked_for, pieces, record_of
from damperlab.studies.store.catalogue.rowsum import is_sound
from damperlab.studies.store.catalogue.tables import studies
from damperlab.studies.store.cube.definition import parse_stored
from damperlab.studies.store.cube.description import block_grid, stored_variables
from damperlab.studies.store.cube.known_points import Source
from damperlab.studies.store.faults import CatalogueDamaged, StudyNotFound
from damperlab.studies.store.life_cycle.entering import box_of
from damperlab.studies.store.provenance import DESIGNS
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store

MOST_STUDIES = 8
"""Largest number of studies that `done_of_family` returns."""


class Overlaps:
    """The points that a study shares with earlier studies, to be queried block by block.

    An earlier study is examined only if its bounding box overlaps the bounding box of the study to compute.

    Parameters
    ----------
    store : Store
        Store of the studies.
    record : Record
        The study to compute.
    boxes : Boxes, optional
        Bounding boxes of the study's family, if they have already been read.
    """

    def __init__(self, store: Store, record: Record, boxes: "Boxes | None" = None) -> None:
        self._store = store
        self._studies: list[_Overlap] = []
        boxes = (boxes or Boxes(store, record)) if record.reuse else None
        if boxes is not None and not boxes.empty:
            study = parse_stored(record.definition, record.digest)
            near = boxes.near(record, box_of(study))
            overlaps = (_overlap(study, other, boxes.study(other)) for other in near)
            self._studies = [overlap for overlap in overlaps if overlap is not None]
        # largest overlap first, so that few points are left for the other studies
        self._studies.sort(key=lambda overlap: -math.prod(len(own) for own, _ in overlap.common))
        corners = [[(own[0], own[-1]) for own, _ in overlap.common] for overlap in self._studies]
        self._corners = np.array(corners, np.int64).reshape(len(corners), len(record.shape), 2)

    def of(self, block: Block) -> tuple[Source, ...]:
        """Return the earlier studies with points of a block; an empty tuple if all points are new."""
        found = []
        first = np.array(block.start)
        last = first + np.array(block.shape) - 1
        near = np.all((self._corners[..., 0] <= last) & (self._corners[..., 1] >= first), axis=1)
        lacking = np.ones(block.shape, bool) if near.any() else np.zeros(0, bool)
        for overlap in (self._studies[place] for place in np.flatnonzero(near)):
            if not lacking.any():
                break
            ours, theirs = [], []
            for start, extent, (own, other) in zip(block.start, block.shape, overlap.common, strict=True):
                low, high = np.searchsorted(own, (start, start + extent))
                ours.append(own[low:high] - start)
                theirs.append(other[low:high])
            if not all(map(len, ours)) or not lacking[np.ix_(*ours)].any():
                continue
            try:
                shelf, marks = self._store.snapshot(overlap.record.id)
            except (StudyNotFound, CatalogueDamaged):
                continue  # the earlier study was deleted meanwhile, or has lost done-marks
            grid = block_grid(overlap.record.shape, overlap.record.chunk)
            places = [at // step for at, step in zip(theirs, overlap.record.chunk, strict=True)]
            touched = np.ravel_multi_index(np.meshgrid(*map(np.unique, places), indexing="ij"), grid).reshape(
                -1
            )
            generations = {int(index): marks[int(index)] for index in touched if int(index) in marks}
            if generations:
                found.append(Source(shelf.address, generations, tuple(theirs), tuple(ours)))
                if not overlap.record.points_failed:
                    done = np.isin(np.ravel_multi_index(np.ix_(*places), grid), list(generations))
                    lacking[np.ix_(*ours)] &= ~done
        return tuple(found)


class Boxes:
    """The studies with results in the family of a given study, each with the bounding box of its grid.

    If the study belongs to the search for a design, the other studies of this search are left out. A design
    search rarely requests a point twice, and it takes longer to find such a point than to compute it again.
    """

    def __init__(self, store: Store, record: Record) -> None:
        c = studies.c
        self._store = store
        same_design = and_(asked_for(DESIGNS), c.purpose_of == record.provenance.get(DESIGNS))
        with store.catalogue.reading() as connection:
            family = select(c.family).where(c.id == record.id, ALIVE).scalar_subquery()
            query = select(c.number, c.box).where(
                c.family == family, c.family != "", ALIVE, c.blocks_done > 0, not_(same_design)
            )
            rows = connection.execute(query).all()
        boxes = {row.number: box for row in rows if (box := _parse_box(row.box)) is not None}
        self._numbers = list(boxes)
        self._read: dict[str, AnyStudy] = {}
        self._boxes = np.array(list(boxes.values()), np.float64)

    @property
    def empty(self) -> bool:
        """Whether the family has no other study with results."""
        return not self._numbers

    def near(self, record: Record, box: list[list[float]]) -> Iterator[Record]:
        """Yield the other studies of the family whose bounding boxes overlap `box`, the bounding box of `record`."""
        low, high = np.array(box, np.float64).reshape(len(box), 2).T
        near = np.flatnonzero(np.all((self._boxes[..., 0] <= high) & (self._boxes[..., 1] >= low), axis=1))
        numbers = [self._numbers[int(place)] for place in near]
        for some in pieces(numbers):
            query = select(studies).where(studies.c.number.in_(some), ALIVE)
            with self._store.catalogue.reading() as connection:
                found = connection.execute(query).all()
            yield from (record_of(row) for row in found if row.id != record.id and is_sound(studies, row))

    def study(self, record: Record) -> AnyStudy:
        """Return the definition of a study of the family; each definition is parsed only once."""
        if record.digest not in self._read:
            self._read[record.digest] = parse_stored(record.definition, record.digest)
        return self._read[record.digest]


def _parse_box(text: str) -> np.ndarray | None:
    """Read a bounding box from the catalogue; return None if the text is damaged."""
    try:
        box = np.array(json.loads(text), np.float64)
    except (ValueError, TypeError):
        return None
    return box if box.ndim == 2 and box.shape[1] == 2 else None


@dataclass(frozen=True)
class _Overlap:
    record: Record
    # for each dimension: indices of the common values in the study to compute, and in the earlier study
    common: tuple[tuple[np.ndarray, np.ndarray], ...]


def _overlap(study: AnyStudy, other: Record, earlier: AnyStudy) -> _Overlap | None:
    if not {v.name for v in stored_variables(study)} <= {v.name for v in stored_variables(earlier)}:
        return None
    common = []
    for own, theirs in zip(study.identities.values(), earlier.identities.values(), strict=True):
        _, here, there = np.intersect1d(own, theirs, assume_unique=True, return_indices=True)
        if not here.size:
            return None
        common.append((here, there))
    return _Overlap(other, tuple(common))


def done_of_family(store: Store, family: str) -> list[Record]:
    """Find the latest completed studies of a family, given its digest; see `damperlab.studies.digest.family_digest`.

    The result is empty if the digest is empty.
    """
    c = studies.c
    query = select(studies).where(c.family == family, c.family != "", ALIVE, c.state == "done")
    with store.catalogue.reading() as connection:
        rows = connection.execute(query.order_by(c.number.desc()).limit(MOST_STUDIES)).all()
    return [record_of(row) for row in rows if is_sound(studies, row)]
