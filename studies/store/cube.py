"""The cube of one study in Zarr v3: made once, written a block at a time, read lazily.

One group per study, one array per stored variable and one chunk per block, so that workers never share a
file. A chunk is renamed into place whole, but the variables of a block arrive one after the other. A reader
is therefore shown only blocks with a done-mark (`open_cube`), set once the block's files are on the disk.
"""

import json
import shutil
from collections.abc import Mapping
from datetime import UTC, datetime
from math import prod
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
from zarr.codecs import BloscCodec

from studies.definition import Study
from studies.plan import Block, Plan
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


def create_cube(path: Path, study: Study, plan: Plan, provenance: Mapping[str, str]) -> None:
    """Make an empty cube and wait until it is on the disk; whatever lies at `path` is replaced.

    Parameters
    ----------
    path : Path
        The folder to make.
    study, plan : Study, Plan
        Coordinates and variables; extent of the chunks.
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
            chunks=plan.chunk,
            dtype=variable.dtype,
            fill_value=variable.fill,
            dimension_names=list(DIMENSIONS),
            attributes=_attributes(variable),
            compressors=[BloscCodec(cname="zstd", clevel=1, shuffle="shuffle")],
            # one flat folder per variable: a block syncs one folder each instead of six
            chunk_key_encoding={"name": "default", "separator": "."},
        )
    _consolidate(path)
    sync_tree(path)


def write_region(cube_path: str, block: Block, values: Mapping[str, np.ndarray]) -> None:
    """Write the region of one block and wait until it is on the disk; its done-mark may be set afterwards.

    Parameters
    ----------
    cube_path : str
        The cube's folder, `Store.cube_path`.
    block : Block
        The block, aligned with the chunks of the cube.
    values : mapping of array
        Every stored variable by name, each of the block's shape.

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
    group = zarr.open_group(cube_path, mode="r+", use_consolidated=True)
    arrays = [(name, array) for name, array in group.arrays() if name not in DIMENSIONS]
    for name, _ in arrays:
        if values[name].shape != block.shape:
            raise ValueError(f"{name} has shape {values[name].shape}, its block {block.shape}")
    chunks: list[Path] = []
    for name, array in arrays:
        # a chunk of nothing but NaN is written too: what is missing on the disk is then known to be lost
        array.with_config({"write_empty_chunks": True})[block.slices] = values[name]
        place = (start // step for start, step in zip(block.start, array.chunks, strict=True))
        chunks.append(root / name / f"c.{'.'.join(map(str, place))}")
    sync_paths(chunks)
    sync_paths(root / name for name, _ in arrays)


def open_cube(path: Path, done: np.ndarray | None) -> xr.Dataset:
    """Open a cube lazily; points of blocks that are not done read as not computed.

    Opening costs the same for a small and a large cube, and indexing reads the chunks that it touches.

    Parameters
    ----------
    path : Path
        The cube's folder.
    done : array of bool, optional
        One flag per block, by its index; None where every block is done.

    Returns
    -------
    Dataset
        Of numpy arrays read on demand. A flag says what was done when it was taken: blocks are written once,
        so what is read later agrees with it, and newer blocks stay hidden.

    Raises
    ------
    FileNotFoundError
        If there is no cube at `path`.
    """
    group = zarr.open_group(str(path), mode="r", use_consolidated=True)
    variables: dict[str, xr.Variable] = {}
    for name, array in group.arrays():
        attributes: dict[str, Any] = dict(array.attrs)
        if name in DIMENSIONS:
            variables[name] = xr.Variable((name,), np.asarray(array[:]), attributes)
            continue
        if "flag_values" in attributes:
            # CF wants them of the variable's own type, which JSON does not keep
            attributes["flag_values"] = np.asarray(attributes["flag_values"], array.dtype)
        lazy = LazilyIndexedArray(_DoneArray(array, done))
        variables[name] = xr.Variable(DIMENSIONS, lazy, attributes, {"chunks": array.chunks})
    ordered = [name for name in (*DIMENSIONS, *VARIABLES) if name in variables]
    return xr.Dataset({name: variables[name] for name in ordered}, attrs=dict(group.attrs))


class _DoneArray(BackendArray):
    """A Zarr array that shows its fill value wherever the block is not done."""

    def __init__(self, array: zarr.Array[Any], done: np.ndarray | None) -> None:
        self._array = array
        grid = block_grid(array.shape, array.chunks)
        if done is not None and done.shape != (prod(grid),):
            raise ValueError(f"{done.shape} flags for a grid of {grid} blocks")
        self._done = None if done is None else done.reshape(grid)
        self.shape = array.shape
        self.dtype = array.dtype

    def __getitem__(self, key: ExplicitIndexer) -> Any:
        return explicit_indexing_adapter(key, self.shape, IndexingSupport.OUTER, self._read)

    def _read(self, key: tuple[Any, ...]) -> np.ndarray:
        values = np.asarray(self._array.oindex[key])
        if self._done is None:
            return values
        blocks = []
        for index, extent, step in zip(key, self.shape, self._array.chunks, strict=True):
            points = np.arange(extent)[index] if isinstance(index, slice) else np.asarray(index)
            blocks.append(np.atleast_1d(points // step))
        hidden = ~self._done[np.ix_(*blocks)].reshape(values.shape)
        if hidden.any():
            values = values.copy()
            values[hidden] = self._array.fill_value
        return values


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
