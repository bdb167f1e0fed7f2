"""A cube as one Parquet file, written and sent piece by piece, so that memory does not grow with the cube."""

import json
from collections.abc import Iterator
from typing import TYPE_CHECKING

from damperlab.studies.store.export.table import column_attributes, columns

if TYPE_CHECKING:
    import xarray as xr


class _Pieces:
    """A file object whose content is removed when it is taken."""

    closed = False

    def __init__(self) -> None:
        self._pieces: list[bytes] = []

    def write(self, piece: bytes) -> int:
        """Append a piece."""
        self._pieces.append(bytes(piece))
        return len(piece)

    def flush(self) -> None:
        """Nothing is buffered."""

    def close(self) -> None:
        """Nothing is open."""

    def take(self) -> bytes:
        """Give the bytes written since the last call."""
        taken, self._pieces = b"".join(self._pieces), []
        return taken


def parquet_pieces(cube: "xr.Dataset") -> Iterator[bytes]:
    """Give a cube as Parquet: one row per point in C order, the coordinates, then the variables.

    Every column has its units and description as metadata, and the file has the study's attributes.

    Parameters
    ----------
    cube : Dataset
        A study's cube, `Store.cube`.

    Yields
    ------
    bytes
        The pieces of the file, in order.
    """
    # imported here to save other commands a fifth of a second
    import pyarrow
    import pyarrow.parquet

    schema = pyarrow.schema(
        [
            pyarrow.field(
                name,
                pyarrow.from_numpy_dtype(dtype),
                metadata={key: _text(value) for key, value in attributes.items()},
            )
            for name, (dtype, attributes) in column_attributes(cube).items()
        ],
        metadata={str(key): _text(value) for key, value in cube.attrs.items()},
    )
    sink = _Pieces()
    with pyarrow.parquet.ParquetWriter(
        pyarrow.PythonFile(sink, mode="w"), schema, compression="zstd"
    ) as writer:
        for piece in columns(cube):
            writer.write_table(pyarrow.table(piece, schema=schema))
            yield sink.take()
    yield sink.take()


def _text(value: object) -> str:
    if isinstance(value, str):
        return value
    return json.dumps(value.tolist() if hasattr(value, "tolist") else value)
