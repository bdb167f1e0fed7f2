"""A bounded number of blocks at the workers of a cluster, each examined before its first block."""

import queue
import time
import uuid
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from typing import Any

from distributed import CancelledError, Client, Future, KilledWorker

from damperlab.studies.plan import Block
from damperlab.studies.store.record import BlockOutcome
from damperlab.worker.apart import call_apart
from damperlab.worker.backlog import Backlog
from damperlab.worker.crew import AGAIN_SECONDS, Crew
from damperlab.worker.examination import Answer, examine, majority
from damperlab.worker.outcomes import Failure, Outage, asking_the_cluster
from damperlab.worker.part import PartOutcome
from damperlab.worker.provenance import WrongCode

LOOK_SECONDS = 1.0
"""Between two looks at who is there."""
WAIT_SECONDS = 120.0
"""How long a study waits, unless told otherwise, while no worker can compute."""
ANSWER_SECONDS = 30.0
"""How long a scheduler that is there may take to answer."""
FETCH_SECONDS = 1.0
"""How long an answer, a few bytes, may take from its worker before it is looked whether that is still there."""
LATE_SECONDS = 10.0
"""How long the first workers are waited for once one of them has answered; the others join later."""

Call = tuple[Any, ...]
"""A function and its arguments."""
Ended = BlockOutcome | PartOutcome | Failure
"""What becomes of a block, or of a part of one."""


class Window:
    """Sends blocks to the workers of a cluster as they have room for them, and hands back what became of them.

    Parameters
    ----------
    client : Client
        Of the cluster.
    task : callable
        Gives the call that computes the block of the given index under the given task key.
    backlog : Backlog
        The blocks.
    part_task : callable, optional
        Gives the call that computes a part of a block; without it none may be cut.
    wait_seconds : float
        How long the study waits while no worker can compute [s].
    priority : int
        Of two blocks that wait at a worker the one with the higher begins first.
    """

    def __init__(
        self,
        client: Client,
        task: Callable[[int, str], Call],
        backlog: Backlog,
        *,
        part_task: Callable[[Block], Call] | None = None,
        wait_seconds: float = WAIT_SECONDS,
        priority: int = 0,
    ) -> None:
        self.crew = Crew(backlog)
        self._client = client
        self._task = task
        self._part_task = part_task
        self._wait_seconds = wait_seconds
        self._priority = priority
        self._examination: Call | None = None
        self._truth = ""
        self._identity = ""
        self._flying: dict[str, Future] = {}
        self._examined: dict[str, tuple[Future, str]] = {}
        # since when an answer that is there cannot be fetched
        self._late: dict[str, float] = {}
        self._ended: queue.SimpleQueue[str] = queue.SimpleQueue()
        self._run = uuid.uuid4().hex[:8]
        self._sent = 0
        self._looked = -LOOK_SECONDS
        self._able = time.monotonic()

    @property
    def empty(self) -> bool:
        """Whether no block is at the cluster, and none waits."""
        return not self._flying and not self.crew.waiting

    @property
    def idle(self) -> bool:
        """Whether no block is at the cluster."""
        return not self._flying

    @property
    def stranded(self) -> str | None:
        """Why nothing is computed, where that is for want of workers; None while something is."""
        return None if self._flying or self.crew.usable else self.crew.words()

    def assemble(
        self,
        cube_path: str,
        digest: str,
        code: str,
        identity: str,
        canary: Block | None,
        truth: str,
        look_on: Callable[[], bool],
    ) -> dict[str, str] | None:
        """Examine who is there, and let those compute who agree; who comes later is examined alike.

        Parameters
        ----------
        cube_path, digest, code : str
            As for `damperlab.worker.tasks.run_block`.
        identity : str
            What the study is computed with; empty where it has not begun, for what most workers have.
        canary : Block, optional
            Points that every worker computes; none the first time, when kernels are yet to be compiled.
        truth : str
            Their bits, as they are stored; empty where they are not, for what most workers answer.
        look_on : callable
            Called between two looks; False ends the wait.

        Returns
        -------
        dict of str or None
            `computing()` of the workers; None where `look_on` ended the wait.

        Raises
        ------
        Outage
            No worker can compute for long.
        """
        self._examination = examine, cube_path, digest, code, canary
        # nobody was waited for meanwhile: the first look comes minutes after the last where kernels were compiled
        self._able = time.monotonic()
        while True:
            answers = self._answers(look_on)
            if answers is None:
                return None
            self._identity = identity or _commonest({a: one.facts["identity"] for a, one in answers.items()})
            alike = {a: one for a, one in answers.items() if one.facts["identity"] == self._identity}
            self._truth = truth or majority({a: one.bits for a, one in alike.items()}) or ""
            for address, answer in answers.items():
                if canary is None or self._truth or address not in alike:
                    self._judge(address, answer)
                else:
                    reason = "the workers disagree on the bits of the same points, and which are right is not known"
                    self.crew.leave_out(address, reason, time.monotonic() + AGAIN_SECONDS)
            if self.crew.usable:
                return next(one.facts for address, one in alike.items())

    def fill(self) -> None:
        """Send blocks until every thread has enough.

        Raises
        ------
        Outage
            The scheduler does not answer, or no worker has been able to compute for long.
        """
        self._look()
        for address, attempt in self.crew.assignments():
            # No key is ever used twice: the scheduler would answer with what it remembers of the first use.
            key = f"block-{self._run}-{self._sent}"
            self._sent += 1
            part, call = attempt.piece.part, self._task(attempt.index, key)
            if part is not None and self._part_task is not None:
                call = self._part_task(part)
            self._flying[key] = self._send(key, address, (call_apart, *call) if attempt.apart else call)
            self.crew.sent(key, address, attempt)

    def collect(self, wait_seconds: float) -> Iterator[Ended]:
        """Hand back the blocks that have ended since the last call.

        Parameters
        ----------
        wait_seconds : float
            Longest wait for the first of them [s]; no more are taken once it is over, however many have ended,
            so that a large cluster is sent new blocks meanwhile.

        Yields
        ------
        BlockOutcome, PartOutcome or Failure
            In the order of their end. A block that will be tried again is not among them.

        Raises
        ------
        Outage
            The scheduler is lost, or there is no room for the study's data.
        """
        for key in self._news(wait_seconds):
            if key in self._flying:
                ended = self._end(key, self._flying.pop(key))
                if ended is not None:
                    yield ended
                if self._looked < 0.0:
                    return
            elif key in self._examined:
                future, address = self._examined.pop(key)
                answer = self._examination_of(key, future, address)
                if answer is not None:
                    self._judge(address, answer)

    def drain(self, grace_seconds: float) -> Iterator[Ended]:
        """Send nothing more, drop what has not begun, and hand back what ends within a grace.

        Parameters
        ----------
        grace_seconds : float
            How long blocks that run may still take [s].

        Yields
        ------
        BlockOutcome, PartOutcome or Failure
            As `collect` does.
        """
        deadline = time.monotonic() + grace_seconds
        waiting = [key for one in self.crew.members.values() for key in list(one.held)[one.threads :]]
        self._drop(waiting)
        while self._flying and (left := deadline - time.monotonic()) > 0.0:
            yield from self.collect(min(left, 1.0))
            with suppress(Outage):
                self._look(examine=False)
        self.close()

    def close(self) -> None:
        """Drop every block that is still at the cluster."""
        self._drop(list(self._flying))
        examined, self._examined = self._examined, {}
        self._cancel([future for future, _ in examined.values()], "the study was stopped")

    def _send(self, key: str, address: str, call: Call) -> Future:
        with asking_the_cluster(self._client):
            future = self._client.submit(
                *call,
                key=key,
                pure=False,
                workers=[address],
                allow_other_workers=False,
                retries=0,
                priority=self._priority,
            )
        future.add_done_callback(lambda future: self._ended.put(future.key))
        return future

    def _drop(self, keys: list[str]) -> None:
        futures = []
        for key in keys:
            if key in self._flying:
                futures.append(self._flying.pop(key))
                if self.crew.at(key) is not None:
                    self.crew.give_back(key)
        self._cancel(futures, "the block is not wanted there")

    def _cancel(self, futures: list[Future], reason: str) -> None:
        """Let the cluster forget tasks; one whose scheduler is lost has."""
        if futures:
            with suppress(Outage), asking_the_cluster(self._client):
                self._client.cancel(futures, reason=reason)

    def _news(self, wait_seconds: float) -> Iterator[str]:
        block = True
        deadline = time.monotonic() + wait_seconds
        while block or time.monotonic() < deadline:
            try:
                yield self._ended.get(block, wait_seconds)
            except queue.Empty:
                return
            block = False

    def _end(self, key: str, future: Future) -> Ended | None:
        address = self.crew.at(key)
        if address is None:
            return None
        if future.status == "error":
            error = future.exception(timeout=ANSWER_SECONDS)
            if isinstance(error, KilledWorker):
                self._drop_lost(self.crew.vanish(address))
                return None
            return self.crew.failed(key, error, time.monotonic())
        try:
            outcome: BlockOutcome | PartOutcome = future.result(timeout=FETCH_SECONDS)
        except TimeoutError:
            # its worker may be gone, and would be waited for in vain: look, and ask again where it is not
            self._require_scheduler()
            self._flying[key] = future
            self._ended.put(key)
            self._looked = -LOOK_SECONDS
            return None
        # lost with its worker before it was fetched, or never begun; whatever the library says of that
        except (Exception, CancelledError):
            self._require_scheduler()
            self.crew.give_back(key)
            return None
        # points that were taken from earlier studies took no time
        reused = isinstance(outcome, BlockOutcome) and outcome.reused > 0
        self.crew.ended(key, 0.0 if reused else outcome.kernel_seconds)
        return outcome

    def _drop_lost(self, keys: list[str]) -> None:
        """Forget tasks that the crew has given to others."""
        self._cancel([self._flying.pop(key) for key in keys if key in self._flying], "the worker has left")

    def _look(self, examine: bool = True) -> None:
        now = time.monotonic()
        if now - self._looked < LOOK_SECONDS:
            return
        self._looked = now
        self._require_scheduler()
        with asking_the_cluster(self._client):
            ask = self._client.scheduler
            threads = self._client.sync(ask.ncores, callback_timeout=ANSWER_SECONDS)
            running = self._client.sync(ask.ncores_running, callback_timeout=ANSWER_SECONDS)
        self._drop_lost(self.crew.see(threads, running))
        gone = [key for key, (_, address) in self._examined.items() if address not in threads]
        self._cancel([self._examined.pop(key)[0] for key in gone], "the worker has left")
        if examine:
            self._examine(now)
        # a worker that compiles before it answers is no want of workers
        asked = {address for _, address in self._examined.values()}
        new = any(one.address in asked and not one.compiled for one in self.crew.members.values())
        compiles = self._asks_for_points and new
        if self.crew.able or compiles:
            self._able = now
        elif now - self._able > self._wait_seconds:
            raise Outage(f"no worker could compute for {self._wait_seconds:g} s: {self.crew.words()}")

    def _examine(self, now: float) -> None:
        """Ask those who are due, and are not being asked; without an examination everybody is believed."""
        asked = {address for _, address in self._examined.values()}
        for member in list(self.crew.due(now)):
            if self._examination is None:
                self.crew.admit(member.address)
            elif member.address not in asked:
                key = f"examination-{self._run}-{self._sent}"
                self._sent += 1
                self._examined[key] = self._send(key, member.address, self._examination), member.address

    def _examination_of(self, key: str, future: Future, address: str) -> Answer | None:
        """Give what a worker has answered; one that could not is left out."""
        try:
            answer: Answer = future.result(timeout=FETCH_SECONDS)
        except WrongCode as error:
            self.crew.leave_out(address, str(error), time.monotonic() + AGAIN_SECONDS)
        # a worker that does not hold this package, cannot reach the data, is lost, …
        except (Exception, CancelledError) as error:
            self._require_scheduler()
            now = time.monotonic()
            fetched = isinstance(error, TimeoutError) and future.status == "finished"
            if fetched and now - self._late.setdefault(key, now) < LATE_SECONDS:
                # it has answered, and nobody reaches it: asked again, while the others are heard
                self._examined[key] = future, address
                self._ended.put(key)
                return None
            reason = f"it cannot begin ({type(error).__name__}: {error})"
            self.crew.leave_out(address, reason, time.monotonic() + AGAIN_SECONDS)
        else:
            return answer
        return None

    def _judge(self, address: str, answer: Answer) -> None:
        now = time.monotonic()
        if self._identity and answer.facts["identity"] != self._identity:
            self.crew.leave_out(
                address,
                f"it would not compute the bits of the study's other blocks: it has {_words(answer.facts)}, identity "
                f"{answer.facts['identity']}, and the study {self._identity}",
                now + AGAIN_SECONDS,
            )
        elif self._truth and answer.bits and answer.bits != self._truth:
            self.crew.leave_out(
                address,
                f"points whose values are known have other bits there ({answer.bits} in place of {self._truth})",
            )
        else:
            self.crew.admit(address)
            if self._asks_for_points and address in self.crew.members:
                self.crew.members[address].compiled = True

    @property
    def _asks_for_points(self) -> bool:
        return self._examination is not None and self._examination[-1] is not None

    def _answers(self, look_on: Callable[[], bool]) -> Mapping[str, Answer] | None:
        """Examine everybody; wait for all of those who are there, but not for long once one has answered."""
        self.crew.examine_again()
        answers: dict[str, Answer] = {}
        first: float | None = None
        while look_on():
            self._look()
            for key in self._news(0.2):
                if key in self._examined:
                    future, address = self._examined.pop(key)
                    answer = self._examination_of(key, future, address)
                    if answer is not None:
                        answers[address] = answer
                        self.crew.members[address].again_at = float("inf")
            answers = {address: one for address, one in answers.items() if address in self.crew.members}
            first = (first or time.monotonic()) if answers else None
            if first is not None and (not self._examined or time.monotonic() - first > LATE_SECONDS):
                return answers
        return None

    def _require_scheduler(self) -> None:
        if self._client.status != "running":
            raise Outage("the connection to the Dask scheduler was lost")


def _commonest(identities: Mapping[str, str]) -> str:
    """Give what most have; of equally many what the first address has."""
    values = [identities[address] for address in sorted(identities)]
    return max(values, key=values.count)


def _words(facts: Mapping[str, str]) -> str:
    return f"solver {facts.get('solver', 'unknown')} on {facts.get('target', 'an unknown processor')}"
