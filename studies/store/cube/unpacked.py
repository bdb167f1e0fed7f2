"""Blocks of the first layout, a file for each variable: their done-marks made again from the files alone.

Those files say neither whose they are nor how long they took. But each variable was written and synced before a block
got its mark, each file has a checksum and its generation in its name; so a block is there where every variable is, whole
and of one generation.
"""

from collections import defaultdict
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from damperlab.studies.store.cube.checksum import checksum
from damperlab.studies.store.cube.chunks import chunk_file, chunk_key, chunk_place
from damperlab.studies.store.cube.description import Description
from damperlab.studies.store.files.shelf import Shelf
from damperlab.studies.variables import Status


def marks_of_files(
    shelf: Shelf, described: Description, trouble: Callable[[str], None]
) -> Iterator[dict[str, Any]]:
    """Give the marks of the blocks whose files are all there, in the order of their indices.

    Parameters
    ----------
    shelf : Shelf
        Of the cube.
    described : Description
        What it says of itself.
    trouble : callable
        Told of a block that was written and cannot be read, in one sentence.

    Yields
    ------
    dict
        What a packed block's header says, as far as the files tell; of several whole generations the first by name.
    """
    found: dict[int, dict[str, dict[str, float]]] = defaultdict(lambda: defaultdict(dict))
    for entry in shelf.entries():
        key, _, generation = entry.key.partition("~")
        place = chunk_place(key, described.grid)
        if place is not None and place[0] in described.arrays and not entry.key.endswith(".partial"):
            found[place[1]][generation][place[0]] = entry.changed
    for index in sorted(found):
        for generation, changed in sorted(found[index].items()):
            if len(changed) < len(described.arrays):
                continue  # of an attempt that was cut short
            try:
                values = _values(shelf, described, index, generation)
            except (ValueError, RuntimeError, FileNotFoundError) as error:
                trouble(f"block {index}, generation {generation or 'of no name'}: {error}")
                continue
            yield {
                "block": index,
                "generation": generation,
                "points": values["status"].size,
                "failed": int(np.count_nonzero(values["status"] >= Status.TOO_MANY_EVENTS)),
                "checksum": checksum(values),
                "at": max(changed.values()),
            }
            break


def _values(shelf: Shelf, described: Description, index: int, generation: str) -> dict[str, np.ndarray]:
    place = [int(at) for at in np.unravel_index(index, described.grid)]
    values = {}
    for name, array in described.arrays.items():
        whole = array.decode(shelf.get(chunk_file(chunk_key(name, place), generation)))
        # chunks at the far ends are padded
        extents = [
            min(step, extent - at * step)
            for at, step, extent in zip(place, array.chunks, array.shape, strict=True)
        ]
        values[name] = whole[tuple(map(slice, extents))]
    return values
