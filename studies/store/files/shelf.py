"""Where cubes lie: named pieces of bytes, in a folder or in a bucket of an object store.

What is put is on the disk, or acknowledged by the server, when the call returns, and whole from the moment it can
be seen. Everything that stores or reads cubes goes through this door, so that both kinds keep the same promises.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

AT_ONCE = 16
"""Pieces that are put or read side by side: each waits for a disk or a server, and hardly computes."""


TOMBSTONE = "deleted.json"
"""The key of the piece that says that a cube's study was deleted: a lost catalogue does not bring it back."""


class ShelfAway(OSError):
    """An object store does not answer, or says that it cannot now: it may pass by itself."""


@dataclass(frozen=True)
class Entry:
    """One piece on a shelf.

    Parameters
    ----------
    key : str
        Its name, relative to the shelf.
    size : int
        Bytes.
    changed : float
        When it was put, in seconds since 1970 by the clock of the disk or the server.
    """

    key: str
    size: int
    changed: float


def removed_last(key: str) -> tuple[bool, bool]:
    """Give the order in which a shelf loses its pieces, so that a cube is never taken for whole or its study for alive.

    What describes the others goes after them, and what says that the study was deleted after that.
    """
    return key.endswith(".json"), key.endswith(TOMBSTONE)


class Shelf(ABC):
    """A place for pieces of bytes by name; names have parts, as paths have.

    Every method raises `FileNotFoundError` for what is not there, `PermissionError` where it is not allowed,
    `ShelfAway` for an object store that does not answer, and any other `OSError` as the disk has it.

    Parameters
    ----------
    address : str
        A folder's path, or the URL of a place in a bucket; it travels to the workers, and holds no secret.
    """

    readers = 1
    """How many pieces are best read side by side."""
    first_bytes = 4096
    """Best number of bytes to read at once if only the beginning of a piece is needed."""

    def __init__(self, address: str) -> None:
        self.address = address

    def __eq__(self, other: object) -> bool:
        """Tell shelves by their addresses."""
        return isinstance(other, Shelf) and self.address == other.address

    def __hash__(self) -> int:
        """Agree with equality."""
        return hash(self.address)

    @property
    def name(self) -> str:
        """The last part of the address."""
        return self.address.rpartition("/")[2]

    @abstractmethod
    def at(self, name: str) -> "Shelf":
        """Give the shelf below this one, which need not be there."""

    @abstractmethod
    def get(self, key: str) -> bytes:
        """Read a piece."""

    @abstractmethod
    def read(self, key: str, start: int, length: int) -> bytes:
        """Read a part of a piece; less where it ends earlier."""

    @abstractmethod
    def stamp(self, key: str) -> tuple[int, ...]:
        """Tell one content under a name from the next, as far as that costs no request."""

    @abstractmethod
    def put(self, key: str, content: bytes) -> None:
        """Put a piece, replacing what has its name; it never makes a shelf that is not there where it can tell."""

    @abstractmethod
    def put_new(self, key: str, content: bytes) -> bool:
        """Put a piece unless there is one of its name; say whether that is now what was to be put."""

    @abstractmethod
    def fill(self, pieces: Mapping[str, bytes], shelves: Iterable[str] = ()) -> None:
        """Put the first pieces on a shelf, which is made where it is missing, and so are some shelves below it."""

    @abstractmethod
    def make(self, shelves: Mapping[str, Mapping[str, bytes]], below: Iterable[str] = ()) -> None:
        """Make new shelves below this one, by name with their first pieces, each with some shelves of its own below it."""

    @abstractmethod
    def entries(self) -> Iterator[Entry]:
        """List every piece; those that come or go meanwhile may be missing."""

    @abstractmethod
    def shelves(self) -> Iterator[str]:
        """List the names of the shelves below this one."""

    @abstractmethod
    def made(self) -> float:
        """Say when the shelf itself was made or last changed, in seconds since 1970; 0 where it is but a name."""

    @abstractmethod
    def remove(self, key: str) -> None:
        """Remove a piece; one that is gone is no error."""

    @abstractmethod
    def clear(self) -> None:
        """Remove every piece, and the shelf itself."""

    def put_all(self, pieces: Mapping[str, bytes]) -> None:
        """Put several pieces side by side, and wait for all."""
        with ThreadPoolExecutor(AT_ONCE) as pool:
            for _ in pool.map(self.put, pieces, pieces.values()):
                pass
