"""Points that earlier studies hold already: same solver, same settings, coordinates equal to the last bit."""

from dataclasses import dataclass

import numpy as np
from sqlalchemy import select

from damperlab.studies.definition import parse_study
from damperlab.studies.kind import AnyStudy
from damperlab.studies.plan import Block
from damperlab.studies.store.cube import block_grid, stored_variables
from damperlab.studies.store.faults import StoreFault, StudyNotFound
from damperlab.studies.store.record import Record
from damperlab.studies.store.rows import ALIVE, record_of
from damperlab.studies.store.shelf import open_shelf
from damperlab.studies.store.store import Store
from damperlab.studies.store.tables import studies
from damperlab.studies.variables import Status

STUDIES_AT_MOST = 8
"""Earlier studies that are looked at, the newest first: each costs a look for every block."""


@dataclass(frozen=True)
class Source:
    """Where points of one block lie in the cube of one earlier study.

    Parameters
    ----------
    cube_path : str
        That study's cube.
    generations : dict
        Of its done blocks that hold points of this block.
    theirs, ours : tuple of ndarray of int
        Along each dimension the indices in that cube, and the indices within this block.
    """

    cube_path: str
    generations: dict[int, str]
    theirs: tuple[np.ndarray, ...]
    ours: tuple[np.ndarray, ...]


class Overlaps:
    """What a study has in common with earlier ones; asked block by block as they are sent to be computed.

    Parameters
    ----------
    store : Store
        Where the studies are.
    record : Record
        The study that is about to be computed.
    """

    def __init__(self, store: Store, record: Record) -> None:
        self._store = store
        self._studies: list[_Overlap] = []
        if not record.reuse:
            return
        study = parse_study(record.definition)
        with store.catalogue.reading() as connection:
            family = select(studies.c.family).where(studies.c.id == record.id, ALIVE).scalar_subquery()
            rows = connection.execute(
                select(studies)
                .where(studies.c.family == family, studies.c.family != "", studies.c.id != record.id)
                .where(ALIVE, studies.c.blocks_done > 0)
                .order_by(studies.c.number.desc())
                .limit(STUDIES_AT_MOST)
            ).all()
        overlaps = (_overlap(study, record_of(row)) for row in rows)
        self._studies = [overlap for overlap in overlaps if overlap is not None]

    def of(self, block: Block) -> tuple[Source, ...]:
        """Say where points of a block are known; nothing for a block of new points alone."""
        found = []
        for overlap in self._studies:
            ours, theirs = [], []
            for start, extent, (own, other) in zip(block.start, block.shape, overlap.common, strict=True):
                first, last = np.searchsorted(own, (start, start + extent))
                ours.append(own[first:last] - start)
                theirs.append(other[first:last])
            if not all(map(len, ours)):
                continue
            try:
                shelf, marks = self._store.snapshot(overlap.record.id)
            except StudyNotFound:
                continue  # deleted meanwhile
            grid = block_grid(overlap.record.shape, overlap.record.chunk)
            places = (np.unique(at // step) for at, step in zip(theirs, overlap.record.chunk, strict=True))
            touched = np.ravel_multi_index(np.meshgrid(*places, indexing="ij"), grid).reshape(-1)
            generations = {int(index): marks[int(index)] for index in touched if int(index) in marks}
            if generations:
                found.append(Source(shelf.address, generations, tuple(theirs), tuple(ours)))
        return tuple(found)


def known_points(
    sources: tuple[Source, ...], study: AnyStudy, block: Block
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Read what is known of a block; a source that is gone or damaged gives nothing.

    Parameters
    ----------
    sources : tuple of Source
        Of `Overlaps.of`.
    study, block : AnyStudy, Block
        The block.

    Returns
    -------
    known : ndarray of bool, block.shape
        Which points are known.
    values : dict of ndarray, each block.shape
        Every stored variable, right where `known` is true.
    """
    from damperlab.studies.store.opened import open_cube  # brings xarray along

    known = np.zeros(block.shape, bool)
    variables = stored_variables(study)
    values = {v.name: np.full(block.shape, v.fill, v.dtype) for v in variables}
    for source in sources:
        try:
            cube = open_cube(open_shelf(source.cube_path), source.generations)
            part = cube.isel(dict(zip(study.coordinates, source.theirs, strict=True)))
            found = {v.name: part[v.name].values for v in variables}
        except (StoreFault, OSError):
            continue
        status = found["status"]
        # a block that failed as a whole says nothing about its points
        good = (status != Status.NOT_COMPUTED) & (status != Status.BLOCK_FAILED)
        place = np.ix_(*source.ours)
        good &= ~known[place]
        for name, target in values.items():
            target[place] = np.where(good, found[name], target[place])
        known[place] |= good
    return known, values


@dataclass(frozen=True)
class _Overlap:
    record: Record
    # along each dimension the equal values: their indices here and there, ascending
    common: tuple[tuple[np.ndarray, np.ndarray], ...]


def _overlap(study: AnyStudy, other: Record) -> _Overlap | None:
    earlier = parse_study(other.definition)
    if not {v.name for v in stored_variables(study)} <= {v.name for v in stored_variables(earlier)}:
        return None
    common = []
    for own, theirs in zip(study.identities.values(), earlier.identities.values(), strict=True):
        _, here, there = np.intersect1d(own, theirs, assume_unique=True, return_indices=True)
        if not here.size:
            return None
        common.append((here, there))
    return _Overlap(other, tuple(common))
