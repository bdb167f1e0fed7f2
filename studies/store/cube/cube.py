"""Writing of a study's cube, block by block.

Readers use the file of a block only if a done-mark in the catalogue names the file. If this file is lost or damaged,
reading raises an error and never returns a fill value.
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
    """Return the number of bytes of one point of the study before compression."""
    return sum(np.dtype(v.dtype).itemsize for v in stored_variables(study))


def lost_attachments(shelf: Shelf, study: AnyStudy) -> list[str]:
    """Return the names of the cube's ground-motion records that are missing or damaged.

    Raises
    ------
    OSError
        If the files cannot be read.
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
    """Write the file of one block, and wait until the file is on the disk. The done-mark may be set only afterwards.

    Parameters
    ----------
    cube_path : str
        Location of the cube, from `Store.cube_path`.
    block : Block
        The block, which must be one of the cube's chunks.
    values : mapping of array
        Stored variables by name. Every variable has the shape of the block.
    generation : str
        Unique name of this attempt to compute the block. The name of the file and the done-mark contain this name.
    told : mapping, optional
        Values of further fields of `BlockOutcome`, for the header of the file and for the returned outcome.

    Returns
    -------
    BlockOutcome
        Values for the done-mark.

    Raises
    ------
    FileNotFoundError
        If the cube does not exist, for example because the study was deleted meanwhile.
    KeyError
        If a stored variable is missing from `values`.
    ValueError
        If a variable has another shape than the block.
    OSError
        If the file cannot be written, for example to a full disk, or the cube's description is damaged.
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
    """Read a cube's description for a worker.

    Raises
    ------
    OSError
        If the description cannot be read, or is damaged. After an OSError, the block is not recorded as failed.
    """
    try:
        return describe_cube(shelf.get(DESCRIPTION))
    except ValueError as error:
        raise OSError(
            f"the description of {shelf.name} is damaged ({error}); `damperlab store verify --repair` writes "
            "it again"
        ) from error
