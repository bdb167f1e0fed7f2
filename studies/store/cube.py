"""The cube of one study in Zarr v3: made once, and written a block at a time.

One group per study, one array per stored variable and one chunk per block, so that workers never share a
file. A chunk is renamed into place whole, but the variables of a block arrive one after the other. A reader
is therefore shown only blocks with a done-mark (`damperlab.studies.store.opened`), set once the block's files are on the disk.
A file that is lost or damaged is an error for its reader and never a fill value.
"""

import hashlib
import json
from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any

import numpy as np
import zarr
from zarr.codecs import BloscCodec, Crc32cCodec
from zarr.storage import MemoryStore

from damperlab.studies.kind import AnyStudy
from damperlab.studies.plan import Block
from damperlab.studies.store.checksum import checksum
from damperlab.studies.store.chunks import chunk_file, chunk_key
from damperlab.studies.store.coding import describe_cube
from damperlab.studies.store.shelf import Shelf, open_shelf
from damperlab.studies.variables import Variable


def stored_variables(study: AnyStudy) -> tuple[Variable, ...]:
    """Give the variables that a study keeps: its metrics and always the status, in the registry's order."""
    return tuple(v for v in study.variables.values() if v.name in study.metrics or v.name == "status")


def bytes_per_point(study: AnyStudy) -> int:
    """Bytes that one point of the study takes before compression."""
    return sum(np.dtype(v.dtype).itemsize for v in stored_variables(study))


def block_grid(shape: tuple[int, ...], chunk: tuple[int, ...]) -> tuple[int, ...]:
    """Count the blocks along each dimension; a block's index runs through them, last dimension fastest."""
    return tuple(-(-extent // step) for extent, step in zip(shape, chunk, strict=True))


def create_cube(shelf: Shelf, study: AnyStudy, chunk: tuple[int, ...], provenance: Mapping[str, str]) -> None:
    """Make an empty cube and wait until it is safe; whatever lies on the shelf is removed.

    Parameters
    ----------
    shelf : Shelf
        Where it shall be.
    study : AnyStudy
        Coordinates and variables.
    chunk : tuple of int
        Extent of a block.
    provenance : mapping of str
        Kept with the cube; its `solver_version` becomes an attribute of its own.

    Raises
    ------
    OSError
        If the shelf cannot be written.
    """
    shelf.clear()
    shelf.fill(_first_files(study, chunk, provenance) | study.attachments())


def restore_metadata(
    shelf: Shelf, study: AnyStudy, chunk: tuple[int, ...], provenance: Mapping[str, str]
) -> None:
    """Write a cube's metadata and coordinates anew; the files of its blocks stay, and those that the study brought.

    Raises
    ------
    OSError
        If the shelf cannot be written.
    """
    shelf.fill(_first_files(study, chunk, provenance))


def lost_attachments(shelf: Shelf, study: AnyStudy) -> list[str]:
    """Give the keys of the files that a study brought along and that are gone, or not as they were written.

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


def _first_files(study: AnyStudy, chunk: tuple[int, ...], provenance: Mapping[str, str]) -> dict[str, bytes]:
    """Give the files of a cube without blocks: the metadata and the coordinates."""
    attributes = {
        "title": study.name,
        "study": json.dumps(study.document()),
        "digest": study.digest,
        "solver_version": provenance.get("solver_version", "unknown"),
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
        "provenance": json.dumps(dict(provenance)),
    }
    memory: dict[str, Any] = {}
    group = zarr.create_group(MemoryStore(memory), zarr_format=3, attributes=attributes)
    for name, values in study.coordinates.items():
        coordinate = group.create_array(
            name,
            shape=values.shape,
            chunks=values.shape,
            dtype="string" if values.dtype.kind == "U" else "f8",
            fill_value="" if values.dtype.kind == "U" else float("nan"),
            dimension_names=[name],
            attributes=dict(study.labels[name]),
        )
        coordinate[:] = values
    for variable in stored_variables(study):
        group.create_array(
            variable.name,
            shape=study.shape,
            chunks=chunk,
            dtype=variable.dtype,
            fill_value=variable.fill,
            dimension_names=list(study.coordinates),
            attributes=_attributes(variable),
            # the last four bytes of every file are a checksum of the others, which every Zarr reader checks
            compressors=[BloscCodec(cname="zstd", clevel=1, shuffle="shuffle"), Crc32cCodec()],
            # one flat folder per variable: a block syncs one folder each instead of one per dimension
            chunk_key_encoding={"name": "default", "separator": "."},
        )
    files = {key: content.to_bytes() for key, content in memory.items()}
    return files | {"zarr.json": _consolidated(files)}


def write_region(cube_path: str, block: Block, values: Mapping[str, np.ndarray], generation: str = "") -> str:
    """Write the region of one block and wait until it is safe; its done-mark may be set afterwards.

    Parameters
    ----------
    cube_path : str
        Where the cube is, `Store.cube_path`.
    block : Block
        The block, aligned with the chunks of the cube.
    values : mapping of array
        Every stored variable by name, each of the block's shape.
    generation : str
        Tells this attempt's files from those of every other; the done-mark must name it.

    Returns
    -------
    str
        The block's checksum, for its done-mark.

    Raises
    ------
    FileNotFoundError
        If the cube is gone (deleted meanwhile).
    KeyError
        If a stored variable is missing from `values`.
    ValueError
        If a variable has another shape than the block.
    OSError
        If the disk refuses, a full one for instance.
    """
    shelf = open_shelf(cube_path)
    arrays = describe_cube(shelf.get("zarr.json")).arrays
    for name in arrays:
        if values[name].shape != block.shape:
            raise ValueError(f"{name} has shape {values[name].shape}, its block {block.shape}")
    stored = {name: np.asarray(values[name], array.dtype) for name, array in arrays.items()}
    files: dict[str, bytes] = {}
    for name, array in arrays.items():
        place = (start // step for start, step in zip(block.start, array.chunks, strict=True))
        # a chunk of nothing but NaN is written too: what is missing is then known to be lost
        files[chunk_file(chunk_key(name, place), generation)] = array.encode(stored[name])
    shelf.put_all(files)
    return checksum(stored)


def _attributes(variable: Variable) -> dict[str, Any]:
    attributes: dict[str, Any] = {
        "units": variable.units,
        "long_name": variable.long_name,
        "description": variable.doc,
    }
    if variable.flags is not None:
        attributes["flag_values"] = [flag.value for flag in variable.flags]
        attributes["flag_meanings"] = " ".join(flag.name.lower() for flag in variable.flags)
    return attributes


def _consolidated(files: Mapping[str, bytes]) -> bytes:
    # every array's metadata in the group's own file, in zarr-python's inline form: a cube opens with one
    # read, also over HTTP, where nothing can be listed. By hand: zarr's own function warns about its format
    document = json.loads(files["zarr.json"])
    members = sorted(key.partition("/")[0] for key in files if key.endswith("/zarr.json"))
    document["consolidated_metadata"] = {
        "kind": "inline",
        "must_understand": False,
        "metadata": {name: json.loads(files[f"{name}/zarr.json"]) for name in members},
    }
    return json.dumps(document, indent=2).encode()
