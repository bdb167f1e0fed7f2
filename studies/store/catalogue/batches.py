"""Batches of work from several threads. One thread processes a batch; the others wait for their answers."""

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


class Batches(Generic[Asked, Answer]):
    """Collects work from several threads into batches. The next batch is collected while one batch is processed.

    The items of a batch share a transaction, so each item costs less in a large batch.

    Parameters
    ----------
    work : callable
        Function that takes the items of a batch in the order of arrival, and returns an answer or an exception for
        each.
    most : int
        Largest total weight of a batch. A batch of a single item may exceed this weight.
    weigh : callable
        Function that returns the weight of an item; by default each item weighs 1.
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
        """Submit one item, and wait for the answer. Return the answer, or raise it if it is an exception."""
        mine = _Waiting[Asked, Answer](asked)
        with self._lock:
            self._queue.append(mine)
            waits, self._taken = self._taken, True
        if waits:
            mine.woken.wait()
        if mine.answer is None:  # it is this thread's turn to process the next batch
            self._process_batch()
        if isinstance(mine.answer, Exception):
            raise mine.answer
        assert mine.answer is not None
        return mine.answer

    def _process_batch(self) -> None:
        with self._lock:
            weights = accumulate(self._weigh(one.asked) for one in self._queue)
            number = max(1, sum(weight <= self._most for weight in weights))
            some, self._queue = self._queue[:number], self._queue[number:]
        answers: Sequence[Answer | Exception] = [RuntimeError("the work was interrupted")] * len(some)
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
