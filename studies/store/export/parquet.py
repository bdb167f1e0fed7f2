"""Export of a cube, piece by piece, to a Parquet file."""

import json
from collections.abc import Iterator
from typing import TYPE_CHECKING

from damperlab.studies.store.export.table import column_attributes, columns

if TYPE_CHECKING:
    import xarray as xr


class _Pieces:
    """A file object that collects the written bytes until `take` is called."""

    closed = False

    def __init__(self) -> None:
        self._pieces: list[bytes] = []

    def write(self, piece: bytes) -> int:
        """Append bytes."""
        self._pieces.append(bytes(piece))
        return len(piece)

    def flush(self) -> None:
        """Do nothing; Parquet's writer calls this method."""

    def close(self) -> None:
        """Do nothing; Parquet's writer calls this method."""

    def take(self) -> bytes:
        """Return the bytes that were written since the last call of this method."""
        taken, self._pieces = b"".join(self._pieces), []
        return taken


def parquet_pieces(cube: "xr.Dataset") -> Iterator[bytes]:
    """Yield the pieces of a Parquet file with the table of a cube; see `columns`.

    The metadata contain the attributes of the cube, and the unit and the description of every column.

    Parameters
    ----------
    cube : Dataset
        A study's cube, from `Store.cube`.

    Yields
    ------
    bytes
        The pieces of the file, in order.
    """
    # imported here, because importing pyarrow takes a fifth of a second
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
