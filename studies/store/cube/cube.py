"""The cube of one study: created once, and written block by block.

A block's file is complete as soon as it is visible, but only a done-mark assigns it to the block: a reader sees only
blocks with a mark (`damperlab.studies.store.cube.opened`). A lost or damaged file is an error for its reader and
never a fill value.
"""

import hashlib
import time
from collections.abc import Mapping
from typing import Any

import numpy as np

from damperlab.studies.kind import AnyStudy
from damperlab.studies.plan import Block
from damperlab.studies.store.cube.coding import checksum
from damperlab.studies.store.cube.description import DESCRIPTION, Description, describe_cube
from damperlab.studies.store.cube.description import stored_variables as stored_variables
from damperlab.studies.store.cube.packed import block_key, pack
from damperlab.studies.store.files.folder import open_shelf
from damperlab.studies.store.files.shelf import Shelf
from damperlab.studies.store.record import BlockOutcome
from damperlab.studies.variables import Status


def bytes_per_point(study: AnyStudy) -> int:
    """Bytes of one point of the study before compression."""
    return sum(np.dtype(v.dtype).itemsize for v in stored_variables(study))


def block_grid(shape: tuple[int, ...], chunk: tuple[int, ...]) -> tuple[int, ...]:
    """Count the blocks along each dimension; a block's index runs through them, last dimension fastest."""
    return tuple(-(-extent // step) for extent, step in zip(shape, chunk, strict=True))


def lost_attachments(shelf: Shelf, study: AnyStudy) -> list[str]:
    """Give the keys of the study's own files that are missing or damaged.

    Raises
    ------
    OSError
        If the shelf cannot be read.
    """
    return [key for key, sha256 in study.attached.items() if _sha256(shelf, key) != sha256]


def _sha256(shelf: Shelf, key: str) -> str:
    try:
        return hashlib.sha256(shelf.get(key)).hexdigest()
    except FileNotFoundError:
        return ""


def write_region(
    cube_path: str,
    block: Block,
    values: Mapping[str, np.ndarray],
    generation: str = "",
    told: Mapping[str, Any] | None = None,
) -> BlockOutcome:
    """Write the region of one block and wait until it is synced; its done-mark may be set afterwards.

    Parameters
    ----------
    cube_path : str
        Location of the cube, `Store.cube_path`.
    block : Block
        The block, aligned with the chunks of the cube.
    values : mapping of array
        Every stored variable by name, each of the block's shape.
    generation : str
        Name that distinguishes this attempt's file from all others; the done-mark must contain it.
    told : mapping, optional
        Further values for the block's file and its done-mark, by the names in `BlockOutcome`.

    Returns
    -------
    BlockOutcome
        Values for the done-mark.

    Raises
    ------
    FileNotFoundError
        If the cube is gone (deleted meanwhile).
    KeyError
        If a stored variable is missing from `values`.
    ValueError
        If a variable has another shape than the block.
    OSError
        If the disk refuses, for example because it is full, or the cube's description is damaged.
    """
    shelf = open_shelf(cube_path)
    described = description_of(shelf)
    arrays = described.arrays
    for name in arrays:
        if values[name].shape != block.shape:
            raise ValueError(f"{name} has shape {values[name].shape}, its block {block.shape}")
    stored = {name: np.asarray(values[name], array.dtype) for name, array in arrays.items()}
    encoded = {name: array.encode(stored[name]) for name, array in arrays.items()}
    outcome = BlockOutcome(
        index=block.index,
        points=block.points,
        failed=int(np.count_nonzero(stored["status"] >= Status.TOO_MANY_EVENTS)),
        generation=generation,
        checksum=checksum(stored),
        **(told or {}),
    )
    mark = {
        "digest": described.digest,
        "block": block.index,
        "generation": generation,
        "checksum": outcome.checksum,
        "points": outcome.points,
        "failed": outcome.failed,
        "at": time.time(),
        **(told or {}),
    }
    shelf.put(block_key(block.index, generation), pack(mark, encoded))
    return outcome


def description_of(shelf: Shelf) -> Description:
    """Read a cube's description for a worker. Damage raises OSError, so that points are not recorded as failed.

    Raises
    ------
    OSError
        If it cannot be read, or is not as it was written.
    """
    try:
        return describe_cube(shelf.get(DESCRIPTION))
    except ValueError as error:
        raise OSError(
            f"the description of {shelf.name} is damaged ({error}); `damperlab store verify --repair` writes "
            "it again"
        ) from error
