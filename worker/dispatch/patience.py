"""How long a block may run: a worker whose disk or network hangs goes on answering, and never ends it."""

from collections.abc import Callable, Iterable, Iterator

from damperlab.worker.dispatch.piece import Piece
from damperlab.worker.dispatch.roster import Member

STUCK_SECONDS, STUCK_TIMES = 600.0, 100.0
"""A block that has run for so long, and for so many times what is expected of it, is given to another worker too."""


class Patience:
    """Since when each task has been at the head of its worker's queue."""

    def __init__(self) -> None:
        self._since: dict[str, float] = {}

    def overdue(
        self, members: Iterable[Member], expected: Callable[[Piece], float], now: float
    ) -> Iterator[tuple[Member, str, float]]:
        """Give the tasks that run for too long.

        Parameters
        ----------
        members : iterable of Member
            The workers; those that leave will be gone soon.
        expected : callable
            Gives what a piece is expected to take [s].
        now : float
            By a clock that nobody sets [s].

        Yields
        ------
        member, key, seconds : Member, str, float
            The worker, the task, and how long it has been seen there [s].
        """
        running = {key: member for member in members for key in list(member.held)[: member.threads]}
        self._since = {key: self._since.get(key, now) for key in running}
        for key, member in running.items():
            seconds = now - self._since[key]
            likely = expected(member.held[key].piece)
            if member.standing != "leaving" and seconds > max(STUCK_SECONDS, STUCK_TIMES * likely):
                yield member, key, seconds
