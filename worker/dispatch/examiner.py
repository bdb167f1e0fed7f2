"""Tests workers before their first block. The test compares the software, and the bits of a few computed points."""

import time
from collections.abc import Callable, Collection, Mapping

from distributed import CancelledError, Future

from damperlab.worker.dispatch.tasks import FETCH_SECONDS, Call, Tasks
from damperlab.worker.dispatch.worker_state import AGAIN_SECONDS
from damperlab.worker.dispatch.workers import Workers
from damperlab.worker.provenance import WrongCode, other_bits
from damperlab.worker.worker_process.examination import Answer, majority

LATE_SECONDS = 10.0
"""Longest wait for answers of other workers after the first answer, and longest time to fetch an answer [s]."""


class Examiner:
    """Tests the workers of a study, and accepts or excludes each worker.

    Parameters
    ----------
    workers : Workers
        The workers. If `prepare` is never called, all workers are accepted without a test.
    tasks : Tasks
        Object that sends tasks to the workers.
    """

    def __init__(self, workers: Workers, tasks: Tasks) -> None:
        self._workers = workers
        self._tasks = tasks
        self._examination: Call | None = None
        self._truth = ""
        self._identity = ""
        self._asked: dict[str, tuple[Future, str]] = {}
        # time of the first failure to fetch an answer, by task key
        self._late: dict[str, float] = {}

    def prepare(self, examination: Call) -> None:
        """Set the test that workers must pass: `examine` and its arguments. The points come last."""
        self._examination = examination

    @property
    def compiles(self) -> bool:
        """Whether a worker under test computes points for the first time, and so may have to compile kernels."""
        asked = {address for _, address in self._asked.values()}
        new = any(one.address in asked and not one.compiled for one in self._workers.states.values())
        return self._asks_for_points and new

    def ask(self, now: float) -> None:
        """Send the test to each worker that is due for a test and is not being tested."""
        asked = {address for _, address in self._asked.values()}
        for worker in list(self._workers.due(now)):
            if self._examination is None:
                self._workers.admit(worker.address)
            elif worker.address not in asked:
                key = self._tasks.key("examination")
                self._asked[key] = self._tasks.send(key, worker.address, self._examination), worker.address

    def gather(self, look: Callable[[], None], look_on: Callable[[], bool]) -> dict[str, Answer] | None:
        """Test all present workers and return their answers by address. The caller accepts or rejects each worker.

        The function waits for all present workers, but for at most `LATE_SECONDS` after the first answer.
        Meanwhile it calls `look`, which must update the list of present workers and call `ask`. As soon as
        `look_on` returns False, the function returns None.
        """
        self._workers.examine_again()
        answers: dict[str, Answer] = {}
        first: float | None = None
        while True:
            look()
            if not look_on():
                return None
            for key in self._tasks.ended(0.2):
                if heard := self.heard(key):
                    address, answers[address] = heard
                    self._workers.states[address].again_at = float("inf")
            answers = {address: one for address, one in answers.items() if address in self._workers.states}
            first = (first or time.monotonic()) if answers else None
            if first is not None and (not self._asked or time.monotonic() - first > LATE_SECONDS):
                return answers

    def settle(self, answers: Mapping[str, Answer], identity: str, truth: str) -> dict[str, str] | None:
        """Decide which answers are right, and accept or exclude the workers by their answers.

        If `identity` is empty, the most frequent identity counts as the identity of the study's solver.
        `truth` is the correct hash of the points' results; if it is empty, the hash of most workers counts as
        correct.

        Returns
        -------
        dict of str or None
            Result of `computing()` at the accepted workers. None if no worker is accepted.
        """
        self._identity = identity or _commonest({a: one.facts["identity"] for a, one in answers.items()})
        alike = {a: one for a, one in answers.items() if one.facts["identity"] == self._identity}
        self._truth = truth or majority({a: one.bits for a, one in alike.items()}) or ""
        for address, answer in answers.items():
            if not self._asks_for_points or self._truth or address not in alike:
                self.judge(address, answer)
            else:
                reason = (
                    "the workers give different bits for the same points, and it is not known which are right"
                )
                self._workers.leave_out(address, reason, time.monotonic() + AGAIN_SECONDS)
        return next(one.facts for one in alike.values()) if self._workers.usable else None

    def heard(self, key: str) -> tuple[str, Answer] | None:
        """Return the address and the answer of a tested worker, given the key of an ended task.

        The function returns None if the task was not a test, or if its answer cannot be fetched.
        """
        if key not in self._asked:
            return None
        future, address = self._asked.pop(key)
        try:
            answer: Answer = future.result(timeout=FETCH_SECONDS)
        except WrongCode as error:
            self._workers.leave_out(address, str(error), time.monotonic() + AGAIN_SECONDS)
        # the test fails if, for example, the worker lacks this package, cannot reach the data, or is lost
        except (Exception, CancelledError) as error:
            self._tasks.require_scheduler()
            now = time.monotonic()
            fetched = isinstance(error, TimeoutError) and future.status == "finished"
            if fetched and now - self._late.setdefault(key, now) < LATE_SECONDS:
                # the worker has answered, but the answer cannot be fetched now; a later call tries again
                self._asked[key] = future, address
                self._tasks.again(key)
                return None
            reason = f"it cannot begin ({type(error).__name__}: {error})"
            self._workers.leave_out(address, reason, time.monotonic() + AGAIN_SECONDS)
        else:
            return address, answer
        return None

    def judge(self, address: str, answer: Answer) -> None:
        """Accept or exclude a worker, depending on its answer."""
        if self._identity and answer.facts["identity"] != self._identity:
            reason = f"it {other_bits(answer.facts, self._identity)}"
            self._workers.leave_out(address, reason, time.monotonic() + AGAIN_SECONDS)
        elif self._truth and answer.bits and answer.bits != self._truth:
            reason = f"known points have different bits there ({answer.bits} in place of {self._truth})"
            self._workers.leave_out(address, reason)
        else:
            self._workers.admit(address)
            if self._asks_for_points and address in self._workers.states:
                self._workers.states[address].compiled = True

    def forget(self, there: Collection[str]) -> None:
        """Drop the tests of workers whose addresses are not in `there`, because these workers have left."""
        gone = [key for key, (_, address) in self._asked.items() if address not in there]
        self._tasks.drop([self._asked.pop(key)[0] for key in gone], "the worker has left")

    def close(self) -> None:
        """Drop all running tests."""
        asked, self._asked = self._asked, {}
        self._tasks.drop([future for future, _ in asked.values()], "the study was stopped")

    @property
    def _asks_for_points(self) -> bool:
        return self._examination is not None and self._examination[-1] is not None


def _commonest(identities: Mapping[str, str]) -> str:
    """Return the most frequent identity. In a tie, the identity of the worker whose address sorts first is returned."""
    values = [identities[address] for address in sorted(identities)]
    return max(values, key=values.count)
