"""Names of the files of a cube's blocks, and the errors for files that cannot be read.

Every attempt to compute a block writes a new file, whose name contains the generation of the attempt. The done-mark of
the block names the generation that readers use. No file is ever overwritten, so a reader never mixes two attempts.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import numpy as np

from damperlab.studies.faults import Fault, sentence
from damperlab.studies.store.faults import StoreFault, cannot_use
from damperlab.studies.store.files.shelf import Shelf

Marks = Mapping[int, str]
"""The generation of every done block, by the block's index."""


class BlockDamaged(StoreFault):
    """Stored data of a study are lost or damaged: a block with a done-mark, or a cube's description."""


def damaged(shelf: Shelf, index: int | None, what: str, found: str) -> BlockDamaged:
    """Return the error for lost or damaged data. `index` is None if `what` is not part of a block."""
    study_id = shelf.name.removesuffix(".zarr").rpartition("-")[0]
    where = f"{'' if index is None else f'block {index} of '}study {study_id}"
    return BlockDamaged(
        Fault(
            where,
            f"{what}: {found}",
            "what was written",
            f"list all damage with `damperlab store verify {study_id}`, and repair the study with `damperlab store verify "
            f"--repair {study_id}`: descriptions are written again, lost blocks are computed again",
            sentence(f"{where} cannot be read: {what}: {found}"),
        )
    )


@contextmanager
def telling(shelf: Shelf, index: int | None, what: str, lost: str = "its file is lost") -> Iterator[None]:
    """Raise a `StoreFault` in place of an error that occurs while a cube is read.

    Raises
    ------
    BlockDamaged
        If the block, or another part of the cube, is missing or damaged.
    StoreFault
        If the disk or the server reports an error.
    """
    try:
        yield
    except FileNotFoundError as error:
        raise damaged(shelf, index, what, lost) from error
    except OSError as error:
        raise cannot_use(shelf.address, error) from error
    except (ValueError, RuntimeError) as error:
        raise damaged(shelf, index, what, str(error)) from error


def chunk_place(key: str, grid: tuple[int, ...]) -> tuple[str, int] | None:
    """Read the variable and the block's index from the key of a chunk; return None for any other key."""
    variable, slash, name = key.partition("/c.")
    place = read_place(name, grid) if slash else None
    return None if place is None else (variable, int(np.ravel_multi_index(place, grid)))


def read_place(name: str, grid: tuple[int, ...]) -> tuple[int, ...] | None:
    """Read the indices of a chunk from a text such as `0.0.2`; return None if the grid has no such chunk."""
    parts = name.split(".")
    if len(parts) != len(grid) or not all(
        part.isascii() and part.isdigit() and len(part) < 10 for part in parts
    ):
        return None
    place = tuple(map(int, parts))
    return place if all(at < count for at, count in zip(place, grid, strict=True)) else None
