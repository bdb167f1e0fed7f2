"""Work requested by many threads together, done in one batch by the thread whose turn it is."""

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import accumulate
from typing import Generic, TypeVar

Asked = TypeVar("Asked")
Answer = TypeVar("Answer")


@dataclass
class _Waiting(Generic[Asked, Answer]):
    asked: Asked
    answer: Answer | Exception | None = None
    woken: threading.Event = field(default_factory=threading.Event)


class Turns(Generic[Asked, Answer]):
    """Work in batches: the thread whose turn it is does all work that has arrived meanwhile.

    The more items arrive, the cheaper each one, because they share a transaction and its wait for the disk.

    Parameters
    ----------
    work : callable
        Takes the items in the order of arrival, and gives an answer to each, or an exception instead.
    most : int
        Largest weight of a batch; a single item may exceed it.
    weigh : callable
        Gives the weight of an item.
    """

    def __init__(
        self,
        work: Callable[[Sequence[Asked]], Sequence[Answer | Exception]],
        most: int,
        weigh: Callable[[Asked], int] = lambda asked: 1,
    ) -> None:
        self._work = work
        self._most = most
        self._weigh = weigh
        self._lock = threading.Lock()
        self._queue: list[_Waiting[Asked, Answer]] = []
        self._taken = False

    def ask(self, asked: Asked) -> Answer:
        """Process one item and give its answer; raise the answer if it is an exception."""
        mine = _Waiting[Asked, Answer](asked)
        with self._lock:
            self._queue.append(mine)
            waits, self._taken = self._taken, True
        if waits:
            mine.woken.wait()
        if mine.answer is None:  # this thread's turn
            self._take_turn()
        if isinstance(mine.answer, Exception):
            raise mine.answer
        assert mine.answer is not None
        return mine.answer

    def _take_turn(self) -> None:
        with self._lock:
            weights = accumulate(self._weigh(one.asked) for one in self._queue)
            number = max(1, sum(weight <= self._most for weight in weights))
            some, self._queue = self._queue[:number], self._queue[number:]
        answers: Sequence[Answer | Exception] = [RuntimeError("the work was broken off")] * len(some)
        try:
            answers = self._work([one.asked for one in some])
        except Exception as error:
            answers = [error] * len(some)
        finally:
            for one, answer in zip(some, answers, strict=True):
                one.answer = answer
            with self._lock:
                heirs = self._queue[:1]
                self._taken = bool(heirs)
            for one in (*some, *heirs):
                one.woken.set()
