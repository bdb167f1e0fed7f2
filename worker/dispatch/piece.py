"""What is sent to a worker at a time: a block, or a part of one where the end of a study is near, and its attempts."""

import math
from dataclasses import dataclass, replace

from damperlab.studies.plan import Block, chunk_of


@dataclass(frozen=True)
class Piece:
    """A block, or a box of its points.

    Parameters
    ----------
    index : int
        Of the block.
    part : Block, optional
        The box; None for the whole block.
    share : float
        Of the block's points.
    """

    index: int
    part: Block | None = None
    share: float = 1.0


def cut(piece: Piece, block: Block, number: int, whole_rows: bool) -> list[Piece]:
    """Cut a piece into boxes of about equal size.

    Parameters
    ----------
    piece : Piece
        What to cut.
    block : Block
        The block that it is of.
    number : int
        How many boxes there should be; there are fewer where rows or points cannot be cut.
    whole_rows : bool
        Whether the last dimension must stay whole.

    Returns
    -------
    list of Piece
        They hold each point of the piece once.
    """
    box = piece.part or block
    shape, row = box.shape, box.shape[-1]
    size = -(-box.points // max(1, number))
    sides = (*chunk_of(shape[:-1], max(1, size // row)), row) if whole_rows else chunk_of(shape, size)
    corners: list[tuple[int, ...]] = [()]
    for first, length, side in zip(box.start, shape, sides, strict=True):
        corners = [(*corner, at) for corner in corners for at in range(first, first + length, side)]
    ends = [first + length for first, length in zip(box.start, shape, strict=True)]
    parts = []
    for corner in corners:
        extent = tuple(min(side, end - at) for side, end, at in zip(sides, ends, corner, strict=True))
        part = Block(block.index, corner, extent)
        parts.append(Piece(block.index, part, math.prod(extent) / block.points))
    return parts


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
