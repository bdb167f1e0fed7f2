"""A block on its way, or a part of one, and what has happened to it before."""

from dataclasses import dataclass, replace

from damperlab.worker.dispatch.piece import Piece


@dataclass(frozen=True)
class Attempt:
    """A piece on its way.

    Parameters
    ----------
    piece : Piece
        The block, or the part of it.
    errors, crashes : int
        How often computing it raised an exception, and how often it is proven to have ended its process.
    apart : bool
        Compute it in a process of its own: a worker has vanished while it ran, and whether that was the block's doing is
        seen there, and seen without a worker being lost.
    avoid : frozenset of str
        Workers at which it failed.
    tries : int
        How often it was begun before.
    moved : bool
        It was taken from a worker at which it did not end; the next one may take as long as it likes.
    """

    piece: Piece
    errors: int = 0
    crashes: int = 0
    apart: bool = False
    avoid: frozenset[str] = frozenset()
    tries: int = 0
    moved: bool = False

    @property
    def index(self) -> int:
        """Of the block."""
        return self.piece.index

    def begun(self, apart: bool = False) -> "Attempt":
        """Give the next attempt after one that began and ended by nobody's fault; in a process of its own where asked."""
        return replace(self, tries=self.tries + 1, apart=self.apart or apart)

    def elsewhere(self, address: str) -> "Attempt":
        """Give the same attempt, to be made by another worker if there is one."""
        return replace(self, avoid=self.avoid | {address})
