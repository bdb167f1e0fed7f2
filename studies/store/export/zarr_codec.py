"""A codec with which the library Zarr reads a cube's folder.

The codec is registered as an entry point, so `xarray.open_zarr(folder)` works wherever damperlab is installed. In a
complete cube, the done-marks name the valid files. In an incomplete cube, every complete block is read, and all other
points are shown as not computed. Damaged files cause an error.
"""

from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from zarr.abc.codec import ArrayBytesCodec, ArrayBytesCodecPartialDecodeMixin
from zarr.abc.store import RangeByteRequest, Store
from zarr.core.buffer import Buffer, NDBuffer, default_buffer_prototype
from zarr.storage import StorePath

from damperlab.studies.store.cube.block_file import (
    BLOCKS,
    LONGEST_HEADER,
    Header,
    block_key,
    parse_block_key,
    parse_header,
)
from damperlab.studies.store.cube.description import CODEC, DESCRIPTION, Description, describe_cube
from damperlab.studies.store.files.shelf import Shelf
from damperlab.studies.store.life_cycle.manifest import MARKS, parse_marks

_MEND = "list the damage with `damperlab store verify`, and repair the study with `damperlab store verify --repair`"


@dataclass(frozen=True)
class BlockCodec(ArrayBytesCodecPartialDecodeMixin, ArrayBytesCodec):
    """Codec that reads one variable of a cube.

    Parameters
    ----------
    variable : str
        Name of the variable in the block files.
    codecs : tuple of dict
        Zarr's metadata of the codecs with which the variable is encoded.
    """

    variable: str
    codecs: tuple[dict[str, Any], ...]
    is_fixed_size = False
    # for each cube that was read with this codec: the description, and the valid file of each block
    _seen: dict[Any, "_Seen"] = field(default_factory=dict, compare=False, repr=False)

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> "BlockCodec":
        """Create the codec from its metadata."""
        configuration = data["configuration"]
        return cls(configuration["variable"], tuple(configuration["codecs"]))

    def to_dict(self) -> dict[str, Any]:
        """Return the metadata of the codec."""
        return {"name": CODEC, "configuration": {"variable": self.variable, "codecs": list(self.codecs)}}

    def evolve_from_array_spec(self, array_spec: Any) -> "BlockCodec":
        """Return the same codec for every array."""
        return self

    def compute_encoded_size(self, input_byte_length: int, chunk_spec: Any) -> int:
        """Return the size of the input, because the encoded size is not fixed."""
        return input_byte_length

    async def _decode_single(self, chunk_bytes: Buffer, chunk_spec: Any) -> NDBuffer:
        raise NotImplementedError("this codec supports only partial decoding")

    async def _encode_single(self, chunk_array: NDBuffer, chunk_spec: Any) -> Buffer | None:
        raise NotImplementedError("this codec cannot write: only damperlab writes cubes")

    async def _decode_partial_single(
        self, byte_getter: Any, selection: Any, chunk_spec: Any
    ) -> NDBuffer | None:
        place = byte_getter
        assert isinstance(place, StorePath)
        path, _, chunk = place.path.rpartition("/")
        cube = path.removesuffix(self.variable)
        known = str(place.store), cube
        if known not in self._seen:
            self._seen[known] = await _look(place.store, cube)
        seen = self._seen[known]
        index = int(np.ravel_multi_index(tuple(map(int, chunk.split(".")[1:])), seen.description.grid))
        if index not in seen.generations:
            return None  # not computed yet
        key = block_key(index, seen.generations[index])
        try:
            part = await _part(place.store, cube + key, self.variable, seen.description.digest, key)
            values = seen.description.arrays[self.variable].decode(part)[selection]
        except (FileNotFoundError, ValueError, RuntimeError) as error:
            raise OSError(f"block {index} of {place.store}/{cube}: {error}; {_MEND}") from error
        found: NDBuffer = chunk_spec.prototype.nd_buffer.from_numpy_array(np.array(values))
        return found


@dataclass(frozen=True)
class _Seen:
    description: Description
    generations: dict[int, str]


async def _look(store: Store, cube: str) -> _Seen:
    """Find the file of each block from the done-marks; in an incomplete cube, also from the headers of the files."""
    content = await _get(store, cube + DESCRIPTION)
    complete = b'"complete": "yes"' in content
    try:
        description = describe_cube(content)
        try:
            _, marks = parse_marks(await _get(store, cube + MARKS))
        except FileNotFoundError:
            marks = []
    except ValueError as error:
        raise OSError(f"{store}/{cube}: {error}; {_MEND}") from error
    if complete and not marks:
        # the done-marks may have been invalidated since the description was read
        if await _get(store, cube + DESCRIPTION) != content:
            return await _look(store, cube)
        raise OSError(f"{store}/{cube}{MARKS} is lost; {_MEND}")
    generations = {int(mark["block"]): str(mark["generation"]) for mark in marks}
    if not complete:
        async for key in store.list_prefix(f"{cube}{BLOCKS}/"):
            found = parse_block_key(key.removeprefix(cube))
            if found is None or found[0] in generations or found[1].endswith(".partial"):
                continue
            with suppress(FileNotFoundError, ValueError):
                header = await _header(store, key)
                if header.mark.get("message") is None:
                    generations[found[0]] = found[1]
    return _Seen(description, generations)


async def _part(store: Store, path: str, variable: str, digest: str, key: str) -> bytes:
    header = await _header(store, path)
    header.require(digest, *(parse_block_key(key) or (-1, "")))
    start, size = header.parts[variable]
    return await _get(store, path, start, size)


async def _header(store: Store, path: str) -> Header:
    for length in (Shelf.first_bytes, LONGEST_HEADER):
        header = parse_header(await _get(store, path, 0, length))
        if header is not None:
            return header
    raise ValueError("the file is cut short")


async def _get(store: Store, path: str, start: int | None = None, length: int = 0) -> bytes:
    part = None if start is None else RangeByteRequest(start, start + length)
    found = await store.get(path, default_buffer_prototype(), part)
    if found is None:
        raise FileNotFoundError(f"{path} is lost")
    return found.to_bytes()
