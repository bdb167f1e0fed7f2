"""The file `zarr.json`, which describes a cube. The file is written at submission, and read when the cube is opened.

The file contains Zarr's metadata of the group and of all arrays. The chunks of the arrays are in the files of the
blocks (`block_file.py`). Every variable names the codec `damperlab.block`, which no library has; its configuration
lists the codecs that encode the values.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import lru_cache
from typing import Any

import numpy as np

from damperlab.studies.conventions import of_file, of_variable
from damperlab.studies.kind import AnyStudy
from damperlab.studies.kinds import kind_of
from damperlab.studies.store.cube.coding import BLOSC, StoredArray, StoredCoordinate, encode_coordinate
from damperlab.studies.store.files.sealed import PLACEHOLDER, is_sealed, require_seal, seal
from damperlab.studies.store.files.shelf import Shelf
from damperlab.studies.store.provenance import published
from damperlab.studies.variables import Variable

DESCRIPTION = "zarr.json"
"""Name of the file with the description."""

CODEC = "damperlab.block"
"""Name of the codec of arrays whose chunks are in the files of the blocks."""

_OWN = "damperlab"  # the attribute with damperlab's own data
_CODEC_NAMES = ("bytes", "blosc", "crc32c")


def stored_variables(study: AnyStudy) -> tuple[Variable, ...]:
    """Return the variables that a study stores, in the registry's order: the study's metrics, and always the status."""
    return tuple(v for v in study.variables.values() if v.name in study.metrics or v.name == "status")


def bytes_per_point(study: AnyStudy) -> int:
    """Return the number of bytes of one point of the study before compression."""
    return sum(np.dtype(v.dtype).itemsize for v in stored_variables(study))


def block_grid(shape: tuple[int, ...], chunk: tuple[int, ...]) -> tuple[int, ...]:
    """Return the number of blocks along each dimension. Blocks are numbered in C order, last dimension fastest."""
    return tuple(-(-extent // step) for extent, step in zip(shape, chunk, strict=True))


@dataclass(frozen=True)
class Description:
    """Content of a cube's metadata.

    Parameters
    ----------
    attributes : mapping
        Attributes of the cube.
    dimensions : tuple of str
        Names of the dimensions, in the order of the arrays' axes.
    arrays : mapping
        The arrays by name, without the coordinates.
    coordinates : mapping
        The coordinates by name.
    reuse : bool
        Whether the study may reuse points of other studies.
    """

    attributes: Mapping[str, Any]
    dimensions: tuple[str, ...]
    arrays: Mapping[str, StoredArray]
    coordinates: Mapping[str, StoredCoordinate]
    reuse: bool = True

    @property
    def grid(self) -> tuple[int, ...]:
        """Number of blocks along each dimension."""
        first = next(iter(self.arrays.values()))
        return block_grid(first.shape, first.chunks)

    @property
    def digest(self) -> str:
        """Digest of the study."""
        return str(self.attributes["digest"])


def first_pieces(
    study: AnyStudy, chunk: tuple[int, ...], provenance: Mapping[str, str], *, reuse: bool, created: float
) -> dict[str, bytes]:
    """Return the files of a cube that has no blocks yet, by name: the description and the coordinates.

    Parameters
    ----------
    study : AnyStudy
        The study, which determines the coordinates and variables.
    chunk : tuple of int
        Extent of a block along each dimension.
    provenance : mapping of str
        Provenance to store with the cube. The `solver_version` is also stored as a separate attribute.
    reuse : bool
        Whether the study may reuse points of other studies.
    created : float
        Time of submission, in seconds since 1970.
    """
    coordinates = study.coordinates
    members = {name: _coordinate(name, values, study) for name, values in coordinates.items()}
    shape, dimensions = study.shape, tuple(coordinates)
    stored = tuple(each.name for each in stored_variables(study))
    members |= {v.name: _variable(v, shape, chunk, dimensions, stored) for v in stored_variables(study)}
    version = provenance.get("solver_version", "unknown")
    time = datetime.fromtimestamp(created, UTC).isoformat(timespec="microseconds")
    document = {
        "zarr_format": 3,
        "node_type": "group",
        "attributes": {
            **of_file(version, time),
            "title": study.name,
            "study": json.dumps(study.document()),
            "digest": study.digest,
            "solver_version": version,
            "created": time,
            "provenance": json.dumps(dict(provenance)),
            _OWN: {"crc32c": PLACEHOLDER, "layout": 2, "reuse": reuse},
        },
        "consolidated_metadata": {"kind": "inline", "must_understand": False, "metadata": members},
    }
    pieces = {DESCRIPTION: seal(json.dumps(document).encode())}
    for name, values in coordinates.items():
        if not _is_single_number(values):
            pieces[f"{name}/c.0"] = encode_coordinate(values)
    return pieces


@lru_cache(maxsize=64)
def describe_cube(metadata: bytes) -> Description:
    """Read a cube's description.

    Raises
    ------
    ValueError
        If the description is damaged, or was written by damperlab 0.1.0.
    """
    if CODEC.encode() in metadata or is_sealed(metadata):
        require_seal(metadata)
    elif json.loads(metadata):
        raise ValueError("the cube was made by damperlab 0.1.0; export it with that version")
    try:
        return _parse(json.loads(metadata))
    except (KeyError, TypeError, AttributeError, IndexError, StopIteration) as error:
        raise ValueError(f"it does not describe a cube ({type(error).__name__}: {error})") from error


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


@lru_cache(maxsize=64)
def plain_metadata(metadata: bytes, complete: bool) -> bytes:
    """Return a description for HTTP readers, with Zarr's codecs instead of `CODEC` and without user names.

    The attribute `complete` says whether the cube has every block.
    """
    document = json.loads(metadata)
    attributes = document.get("attributes", {})
    attributes.pop(_OWN, None)
    attributes["complete"] = "yes" if complete else "no"
    if "provenance" in attributes:
        attributes["provenance"] = published(attributes["provenance"])
    for node in document.get("consolidated_metadata", {}).get("metadata", {}).values():
        codecs = node.get("codecs", [])
        if codecs and codecs[0].get("name") == CODEC:
            node["codecs"] = codecs[0]["configuration"]["codecs"]
    return json.dumps(document).encode()


def node_metadata(metadata: bytes, name: str) -> bytes:
    """Return the metadata of one array as a separate document."""
    return json.dumps(json.loads(metadata)["consolidated_metadata"]["metadata"][name]).encode()


def _parse(document: Any) -> Description:
    arrays: dict[str, StoredArray] = {}
    coordinates: dict[str, StoredCoordinate] = {}
    dimensions: tuple[str, ...] = ()
    for name, node in document["consolidated_metadata"]["metadata"].items():
        named = tuple(node["dimension_names"])
        if named == (name,):
            text = node["data_type"] == "string"
            stored = any(codec["name"] == "crc32c" for codec in node["codecs"])
            value = None if stored else float(node["fill_value"])
            key = f"{name}/c{node['chunk_key_encoding']['configuration']['separator']}0"
            coordinates[name] = StoredCoordinate(
                name, int(node["shape"][0]), text, value, key, node.get("attributes", {})
            )
        else:
            arrays[name] = _array(name, node)
            dimensions = named
    attributes = dict(document["attributes"])
    own = attributes.pop(_OWN, {})
    if not arrays or set(dimensions) != set(coordinates):
        raise ValueError("it does not describe a cube: arrays or coordinates are missing")
    # the document may list arrays in any order: sort coordinates like the dimensions, and variables like the registry
    ordered = {name: coordinates[name] for name in dimensions}
    known = [name for name in kind_of(dimensions).variables if name in arrays]
    if len(known) != len(arrays):
        raise ValueError("it does not describe a cube: unknown arrays")
    return Description(
        attributes,
        dimensions,
        {name: arrays[name] for name in known},
        ordered,
        bool(own.get("reuse", True)),
    )


def _array(name: str, node: Mapping[str, Any]) -> StoredArray:
    codecs = node["codecs"][0]["configuration"]["codecs"]
    if tuple(codec["name"] for codec in codecs) != _CODEC_NAMES:
        raise ValueError(f"{name} has codecs that no cube uses: {codecs}")
    dtype = np.dtype(node["data_type"]).newbyteorder("<")
    fill = float("nan") if node["fill_value"] == "NaN" else node["fill_value"]
    return StoredArray(
        name,
        tuple(map(int, node["shape"])),
        tuple(map(int, node["chunk_grid"]["configuration"]["chunk_shape"])),
        dtype,
        dtype.type(fill),
        dict(node.get("attributes", {})),
    )


@lru_cache(maxsize=1024)
def _variable(
    variable: Variable,
    shape: tuple[int, ...],
    chunk: tuple[int, ...],
    dimensions: tuple[str, ...],
    stored: tuple[str, ...],
) -> dict[str, Any]:
    dtype = np.dtype(variable.dtype)
    codecs = [
        {"name": "bytes", **({"configuration": {"endian": "little"}} if dtype.itemsize > 1 else {})},
        {"name": "blosc", "configuration": {**BLOSC, "typesize": dtype.itemsize}},
        {"name": "crc32c"},
    ]
    fill = "NaN" if dtype.kind == "f" else int(variable.fill)
    return {
        "zarr_format": 3,
        "node_type": "array",
        "shape": list(shape),
        "data_type": dtype.name,
        "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": list(chunk)}},
        "chunk_key_encoding": {"name": "default", "configuration": {"separator": "."}},
        "fill_value": fill,
        "codecs": [{"name": CODEC, "configuration": {"variable": variable.name, "codecs": codecs}}],
        "dimension_names": list(dimensions),
        "attributes": _attributes(variable) | of_variable(variable.name, stored),
    }


def _coordinate(name: str, values: np.ndarray, study: AnyStudy) -> dict[str, Any]:
    text = values.dtype.kind == "U"
    array_bytes = {"name": "vlen-utf8"} if text else {"name": "bytes", "configuration": {"endian": "little"}}
    single = _is_single_number(values)
    return {
        "zarr_format": 3,
        "node_type": "array",
        "shape": [len(values)],
        "data_type": "string" if text else "float64",
        "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [len(values)]}},
        "chunk_key_encoding": {"name": "default", "configuration": {"separator": "."}},
        "fill_value": float(values[0]) if single else "" if text else "NaN",
        "codecs": [array_bytes] if single else [array_bytes, {"name": "crc32c"}],
        "dimension_names": [name],
        "attributes": dict(study.labels[name]),
    }


def _is_single_number(values: np.ndarray) -> bool:
    """Whether a coordinate is a single number. Its array then stores this number as the fill value, and needs no chunk."""
    return len(values) == 1 and values.dtype.kind != "U"


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
