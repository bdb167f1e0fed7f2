"""The cube of one study in Zarr v3: made once, written a block at a time, read lazily.

One group per study, one array per stored variable and one chunk per block, so that workers never share a
file. A chunk is renamed into place whole, but the variables of a block arrive one after the other. A reader
is therefore shown only blocks with a done-mark (`open_cube`), set once the block's files are on the disk.
A file that is lost or damaged is an error for its reader and never a fill value.
"""

import json
import shutil
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
import zarr
from xarray.backends.common import BackendArray
from xarray.core.indexing import (
    ExplicitIndexer,
    IndexingSupport,
    LazilyIndexedArray,
    explicit_indexing_adapter,
)
from zarr.codecs import BloscCodec, Crc32cCodec

from studies.definition import Study
from studies.plan import Block
from studies.store.checksum import checksum
from studies.store.chunks import (
    MarkedChunks,
    Marks,
    NewGeneration,
    chunk_file,
    chunk_key,
    damaged,
)
from studies.store.decoded import KEPT, plainly_coded, read_outer
from studies.store.durable import sync_paths, sync_tree
from studies.variables import DIMENSION_LONG_NAMES, DIMENSIONS, VARIABLES, Variable


def stored_variables(study: Study) -> tuple[Variable, ...]:
    """Give the variables that a study keeps: its metrics and always the status, in the registry's order."""
    return tuple(v for v in VARIABLES.values() if v.name in study.metrics or v.name == "status")


def bytes_per_point(study: Study) -> int:
    """Bytes that one point of the study takes before compression."""
    return sum(np.dtype(v.dtype).itemsize for v in stored_variables(study))


def block_grid(shape: tuple[int, ...], chunk: tuple[int, ...]) -> tuple[int, ...]:
    """Count the blocks along each dimension; a block's index runs through them, last dimension fastest."""
    return tuple(-(-extent // step) for extent, step in zip(shape, chunk, strict=True))


def create_cube(path: Path, study: Study, chunk: tuple[int, ...], provenance: Mapping[str, str]) -> None:
    """Make an empty cube and wait until it is on the disk; whatever lies at `path` is replaced.

    Parameters
    ----------
    path : Path
        The folder to make.
    study : Study
        Coordinates and variables.
    chunk : tuple of int
        Extent of a block.
    provenance : mapping of str
        Kept with the cube; its `solver_version` becomes an attribute of its own.

    Raises
    ------
    OSError
        If the folder cannot be written.
    """
    shutil.rmtree(path, ignore_errors=True)
    attributes = {
        "title": study.name,
        "study": json.dumps(study.document()),
        "digest": study.digest,
        "solver_version": provenance.get("solver_version", "unknown"),
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
        "provenance": json.dumps(dict(provenance)),
    }
    group = zarr.create_group(str(path), zarr_format=3, attributes=attributes)
    for name, values in study.coordinates.items():
        coordinate = group.create_array(
            name,
            shape=values.shape,
            chunks=values.shape,
            dtype="f8",
            fill_value=float("nan"),
            dimension_names=[name],
            attributes={"units": "1", "long_name": DIMENSION_LONG_NAMES[name]},
        )
        coordinate[:] = values
    for variable in stored_variables(study):
        group.create_array(
            variable.name,
            shape=study.shape,
            chunks=chunk,
            dtype=variable.dtype,
            fill_value=variable.fill,
            dimension_names=list(DIMENSIONS),
            attributes=_attributes(variable),
            # the last four bytes of every file are a checksum of the others, which every Zarr reader checks
            compressors=[BloscCodec(cname="zstd", clevel=1, shuffle="shuffle"), Crc32cCodec()],
            # one flat folder per variable: a block syncs one folder each instead of six
            chunk_key_encoding={"name": "default", "separator": "."},
        )
    _consolidate(path)
    sync_tree(path)


def restore_metadata(path: Path, study: Study, chunk: tuple[int, ...], provenance: Mapping[str, str]) -> None:
    """Write a cube's metadata and coordinates anew; the files of its blocks stay.

    Raises
    ------
    OSError
        If the folder cannot be written.
    """
    fresh = path.with_name(f"{path.name}.fresh")
    create_cube(fresh, study, chunk, provenance)
    for file in sorted(fresh.rglob("*"), reverse=True):
        if file.is_file():
            target = path / file.relative_to(fresh)
            target.parent.mkdir(parents=True, exist_ok=True)
            file.replace(target)
    shutil.rmtree(fresh)
    sync_tree(path)


def write_region(cube_path: str, block: Block, values: Mapping[str, np.ndarray], generation: str = "") -> str:
    """Write the region of one block and wait until it is on the disk; its done-mark may be set afterwards.

    Parameters
    ----------
    cube_path : str
        The cube's folder, `Store.cube_path`.
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
    root = Path(cube_path)
    if not (root / "zarr.json").exists():
        raise FileNotFoundError(f"{root}: the cube is gone")  # which Zarr would make anew, empty
    group = zarr.open_group(NewGeneration(root, generation), mode="r+", use_consolidated=True)
    arrays = [(name, array) for name, array in group.arrays() if name not in DIMENSIONS]
    for name, _ in arrays:
        if values[name].shape != block.shape:
            raise ValueError(f"{name} has shape {values[name].shape}, its block {block.shape}")
    stored = {name: np.asarray(values[name], array.dtype) for name, array in arrays}
    chunks: list[Path] = []
    for name, array in arrays:
        # a chunk of nothing but NaN is written too: what is missing on the disk is then known to be lost
        array.with_config({"write_empty_chunks": True})[block.slices] = stored[name]
        place = (start // step for start, step in zip(block.start, array.chunks, strict=True))
        chunks.append(root / chunk_file(chunk_key(name, place), generation))
    sync_paths(chunks)
    sync_paths(root / name for name, _ in arrays)
    return checksum(stored)


def open_cube(path: Path, marks: Marks) -> xr.Dataset:
    """Open a cube lazily; points of blocks that are not done read as not computed.

    Opening costs the same for a small and a large cube, and indexing reads the chunks that it touches.

    Parameters
    ----------
    path : Path
        The cube's folder.
    marks : mapping
        The generation of every block that is done.

    Returns
    -------
    Dataset
        Of numpy arrays read on demand. The marks say what was done when they were taken: no file is written
        twice, so what is read later agrees with them, and newer blocks stay hidden. Reading raises
        `BlockDamaged` where a done block cannot be read.

    Raises
    ------
    FileNotFoundError
        If there is no cube at `path`.
    """
    plain = zarr.open_group(str(path), mode="r", use_consolidated=True)
    variables: dict[str, xr.Variable] = {}
    grid: tuple[int, ...] = ()
    for name, array in plain.arrays():
        if name in DIMENSIONS:
            variables[name] = xr.Variable((name,), np.asarray(array[:]), dict(array.attrs))
        else:
            grid = block_grid(array.shape, array.chunks)
    marked = zarr.open_group(MarkedChunks(path, grid, marks), mode="r", use_consolidated=True)
    for name, array in marked.arrays():
        if name in DIMENSIONS:
            continue
        attributes: dict[str, Any] = dict(array.attrs)
        if "flag_values" in attributes:
            # CF wants them of the variable's own type, which JSON does not keep
            attributes["flag_values"] = np.asarray(attributes["flag_values"], array.dtype)
        lazy = LazilyIndexedArray(_CheckedArray(path, name, array, marks))
        variables[name] = xr.Variable(DIMENSIONS, lazy, attributes, {"chunks": array.chunks})
    ordered = [name for name in (*DIMENSIONS, *VARIABLES) if name in variables]
    return xr.Dataset({name: variables[name] for name in ordered}, attrs=dict(plain.attrs))


class _CheckedArray(BackendArray):
    """A Zarr array whose damaged chunks are told by their block."""

    def __init__(self, path: Path, name: str, array: zarr.Array[Any], marks: Marks) -> None:
        self._path = path
        self._name = name
        self._array = array
        self._marks = marks
        self._chunks = array.chunks
        self._grid = block_grid(array.shape, array.chunks)
        self.shape = array.shape
        self.dtype = array.dtype

    def __getitem__(self, key: ExplicitIndexer) -> Any:
        return explicit_indexing_adapter(key, self.shape, IndexingSupport.OUTER, self._read)

    def _read(self, key: tuple[Any, ...]) -> np.ndarray:
        try:
            if plainly_coded(self._array):
                return read_outer(self._array, key, self._chunk)
            return np.asarray(self._array.oindex[key])
        except (ValueError, RuntimeError) as error:
            # what the codecs raise for bytes that they cannot decode; they do not say whose
            raise damaged(self._path, None, self._name, str(error)) from error

    def _chunk(self, place: tuple[int, ...]) -> np.ndarray | None:
        """Give a decoded chunk; None where its block is not done."""
        index = 0
        for at, count in zip(place, self._grid, strict=True):
            index = index * count + at
        generation = self._marks.get(index)
        if generation is None:
            return None
        file = f"{self._path}/{chunk_file(chunk_key(self._name, place), generation)}"
        try:
            return KEPT.get(file, self.dtype, self._chunks)
        except FileNotFoundError as error:
            found = "its file is lost, or replaced since the cube was opened"
            raise damaged(self._path, index, self._name, found) from error


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


def _consolidate(path: Path) -> None:
    # every array's metadata in the group's own file, in zarr-python's inline form: a cube opens with one
    # read, also over HTTP, where nothing can be listed. By hand: zarr's own function warns about its format
    document = json.loads((path / "zarr.json").read_text())
    members = sorted(p.parent.name for p in path.glob("*/zarr.json"))
    document["consolidated_metadata"] = {
        "kind": "inline",
        "must_understand": False,
        "metadata": {name: json.loads((path / name / "zarr.json").read_text()) for name in members},
    }
    (path / "zarr.json").write_text(json.dumps(document, indent=2))
