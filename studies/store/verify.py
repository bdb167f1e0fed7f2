"""Whether a study's files still hold what its done-marks say."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr
from sqlalchemy import select

from damperlab.studies.definition import parse_study
from damperlab.studies.ground.shelf import Shelf as Records
from damperlab.studies.plan import Block, plan_with_chunk
from damperlab.studies.store.checksum import checksum
from damperlab.studies.store.chunks import BlockDamaged
from damperlab.studies.store.cube import lost_attachments, restore_metadata
from damperlab.studies.store.decoded import DecodedChunks
from damperlab.studies.store.faults import StoreAway, StoreFault, cannot_use
from damperlab.studies.store.opened import open_cube
from damperlab.studies.store.record import Record
from damperlab.studies.store.shelf import Shelf, ShelfAway
from damperlab.studies.store.store import Store
from damperlab.studies.store.tables import done_blocks


@dataclass(frozen=True)
class Damage:
    """One thing that is not as it was written.

    Parameters
    ----------
    block : int or None
        The block; None where it is the cube's description of itself, which can be written anew.
    found : str
        In one sentence.
    """

    block: int | None
    found: str


def verify(store: Store, record: Record) -> Iterator[Damage]:
    """Read everything that a study has stored and compare it with its marks.

    Parameters
    ----------
    store : Store
        Where the study is.
    record : Record
        The study.

    Yields
    ------
    Damage
        Block by block, in the order of their numbers. Of a description that is damaged nothing more can be read.

    Raises
    ------
    StudyNotFound
        If the study is gone.
    """
    shelf, _ = store.snapshot(record.id)
    study = parse_study(record.definition)
    found = _description(shelf, record, study.coordinates)
    if found is not None:
        yield Damage(None, found)
        return
    for key in lost_attachments(shelf, study):
        yield Damage(None, f"{key}, which the study brought along, is lost or not as it was written")
    plan = plan_with_chunk(study, record.chunk, lambda _, at: np.ones(len(next(iter(at.values())))))
    with store.catalogue.reading() as connection:
        marks = connection.execute(
            select(done_blocks.c.block, done_blocks.c.generation, done_blocks.c.checksum)
            .where(done_blocks.c.study == store.number(connection, record.id))
            .order_by(done_blocks.c.block)
        ).all()
    cube = open_cube(shelf, {mark.block: mark.generation for mark in marks}, DecodedChunks(0))
    for mark in marks:
        trouble = _trouble(cube, plan.block(mark.block), mark.checksum)
        if trouble is not None:
            yield Damage(mark.block, trouble)


def repair(store: Store, record: Record, damages: list[Damage]) -> Record:
    """Make what is damaged computable again: descriptions are written anew, marks of damaged blocks taken back.

    Parameters
    ----------
    store : Store
        Where the study is.
    record : Record
        The study.
    damages : list of Damage
        Of `verify`.

    Returns
    -------
    Record
        As it is then. It is queued if blocks are to be computed, and running it computes those alone.

    Raises
    ------
    StudyBusy
        If somebody works on it.
    StudyFaults
        If a ground-motion record is lost here, and not among the records of the data directory either.
    """
    if any(damage.block is None for damage in damages):
        shelf, _ = store.snapshot(record.id)
        study = parse_study(record.definition)
        lost = lost_attachments(shelf, study)
        if lost:
            whole = parse_study(record.definition, Records(store.data_dir)).attachments()
            shelf.fill({key: whole[key] for key in lost})
        restore_metadata(shelf, study, record.chunk, record.provenance)
    blocks = [damage.block for damage in damages if damage.block is not None]
    return store.forget(record.id, blocks, "damaged") if blocks else store.find(record.id)


def _description(shelf: Shelf, record: Record, coordinates: Mapping[str, np.ndarray]) -> str | None:
    try:
        cube = open_cube(shelf, {}, DecodedChunks(0))
    except (ShelfAway, PermissionError) as error:
        raise cannot_use(shelf.address, error) from error  # which says nothing of what is stored
    except Exception as error:  # whatever Zarr raises for bytes that are no metadata
        return f"the cube's description cannot be read ({type(error).__name__}: {error})"
    if cube.attrs.get("digest") != record.digest:
        return f"the cube says that it is study {cube.attrs.get('digest')}"
    for name, values in coordinates.items():
        if name not in cube.coords or not np.array_equal(cube[name].values, values):
            return f"the coordinates along {name} are not the study's"
    return None


def _trouble(cube: xr.Dataset, block: Block, expected: str | None) -> str | None:
    place = dict(zip(cube["status"].dims, block.slices, strict=True))
    try:
        values = {str(name): array.values for name, array in cube.isel(place).data_vars.items()}
    except StoreAway:
        raise  # which says nothing of what is stored
    except BlockDamaged as error:
        return f"{error.fault.found}"
    except (StoreFault, OSError) as error:
        return f"it cannot be read ({error})"
    if expected is not None and checksum(values) != expected:
        return "its values are not those that were written"
    return None
