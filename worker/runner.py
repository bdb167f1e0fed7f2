"""One study from claimed to done: its pending blocks through a cluster into the store."""

import logging
import math
import time
import uuid
from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager, closing, suppress
from dataclasses import replace
from functools import partial
from threading import Event
from typing import TYPE_CHECKING, Any

import numpy as np

from damperlab.studies.plan import Block, plan_with_chunk
from damperlab.studies.store.cube import description_of, stored_variables, write_region
from damperlab.studies.store.definition import parse_stored
from damperlab.studies.store.faults import StoreFault, StudyNotFound
from damperlab.studies.store.measured import measured_blocks
from damperlab.studies.store.places import open_shelf
from damperlab.studies.store.record import BlockOutcome, Record
from damperlab.studies.store.reuse import Overlaps
from damperlab.studies.store.shelf import ShelfAway
from damperlab.studies.store.store import Store
from damperlab.studies.store.sweep import sweep
from damperlab.studies.vocabulary import STATES
from damperlab.worker.backlog import Backlog
from damperlab.worker.cost import seconds_per_point
from damperlab.worker.examination import canary_of, stored_bits
from damperlab.worker.forecast import Forecast, known_of
from damperlab.worker.here import Here
from damperlab.worker.lease import Lease, hold
from damperlab.worker.outcomes import (
    ClusterUnusable,
    Failure,
    Interrupted,
    Outage,
    asking_the_cluster,
    is_full,
)
from damperlab.worker.progress import Meter, Progress
from damperlab.worker.provenance import (
    WrongCode,
    code_hash,
    computing,
    one_identity,
    require_begun_alike,
    require_solver,
)
from damperlab.worker.scenes import Scene, scenes
from damperlab.worker.tasks import failed_values, run_block
from damperlab.worker.warm import compile_apart, missing

if TYPE_CHECKING:
    from distributed import Client

    from damperlab.worker.crew import Crew
    from damperlab.worker.window import Window

_log = logging.getLogger(__name__)

GRACE_SECONDS = 15.0
"""How long blocks that run when a study is stopped may still take; a block takes a few seconds."""
POLL_SECONDS = 0.2
"""Longest sleep of the coordinator: how late it notices that it shall stop."""
SECONDS_PER_HOUR = 3600.0
REPORT_SECONDS = 0.5
"""Shortest time between two reports of progress."""


def run_study(
    store: Store,
    study_id: str,
    client_factory: "Callable[[], AbstractContextManager[Client]]",
    on_progress: Callable[[Progress], None],
    stop: Event,
    *,
    only_from: tuple[str, ...] = STATES,
    stopped_as: str = "cancelled",
    outage_as: str = "failed",
    here_seconds: float = 0.0,
    wait_seconds: float = 120.0,
    budget_seconds: float | None = None,
) -> Record:
    """Compute what a study lacks, and no more.

    The study ends `done` when every block has its mark, also where blocks were given up and recorded as
    failed points; it ends `failed` where each of its blocks was given up. Stopped, here or by a cancel in
    another process, it is `cancelled`. Where it could not go on for a reason outside its points (the
    scheduler is lost, the disk is full, a worker holds other code) it is `failed` with that message while
    blocks are pending. Whatever the end, what is done is kept, and another call goes on from there.

    Parameters
    ----------
    store : Store
        Where the study was submitted.
    study_id : str
        Its full id.
    client_factory : callable
        Makes a context that gives a client, as `damperlab.worker.cluster.connect` does; called only to compute blocks.
    on_progress : callable
        Called in this thread as the study starts, about twice a second while it moves, and at its end.
    stop : Event
        Set it from elsewhere to stop: no block begins, and those that run may finish within `GRACE_SECONDS`.
    only_from : tuple of str
        Nothing is computed unless the study is in one of these states once it is claimed: somebody may have cancelled it.
    stopped_as : str
        The state in which it is left by `stop`: "queued" for somebody who will go on with it, or who has said already
        what becomes of it.
    outage_as : str
        The state in which it is left by what passes by itself: a cluster that is away, a disk that is full.
    here_seconds : float
        Work that is expected to take no longer is done in this process, without a cluster: the same values, bit for bit.
    wait_seconds : float
        How long to wait while no worker of the cluster can compute; the record says for what.
    budget_seconds : float, optional
        Kernel seconds after which no block begins; the study is left as if it had been stopped, and its message says so.

    Returns
    -------
    Record
        The study as it ended.

    Raises
    ------
    StudyNotFound
        If there is no such study, or it was deleted while it ran.
    StudyBusy
        If another process runs it; nothing is changed then.
    ClusterUnusable
        From `connect`; the study is `failed` with that message and can be run again.
    """
    store.find(study_id)
    with hold(store, study_id) as lease:
        run = _Run(store, lease, on_progress, stop, math.inf if budget_seconds is None else budget_seconds)
        if run.begin(only_from):
            try:
                run.compute(client_factory, here_seconds, wait_seconds)
                run.end(stopped_as)
            # One step each: a process that is killed between two would leave the first one's state for good.
            except Outage as error:
                run.put_down(outage_as, f"{error}; {run.left()}")
            except Interrupted as error:
                run.put_down(outage_as if store.trouble() else "failed", f"{error}; {run.left()}")
            except StudyNotFound:
                raise
            except StoreFault as error:
                # the catalogue was locked, or its server away, and may be back already
                run.put_down(outage_as, f"{error}; {run.left()}")
            except WrongCode as error:
                run.put_down("failed", str(error))
            except KeyboardInterrupt:
                run.put_down("cancelled", None)
                raise
            except ClusterUnusable as error:
                run.put_down(outage_as, str(error))
                raise
            except Exception as error:
                run.put_down("failed", str(error))
                raise
    return store.find(study_id)


class _Run:
    """One run of one claimed study.

    Parameters
    ----------
    store : Store
        Where the study is.
    lease : Lease
        The claim on it.
    on_progress : callable
        Takes the progress.
    stop : Event
        Set from outside.
    budget_seconds : float
        Kernel seconds after which it stops.
    """

    def __init__(
        self,
        store: Store,
        lease: Lease,
        on_progress: Callable[[Progress], None],
        stop: Event,
        budget_seconds: float,
    ) -> None:
        self._store = store
        self._lease = lease
        self._study_id = lease.study_id
        self._on_progress = on_progress
        self._stop = stop
        self._failures: list[str] = []
        self._phase: tuple[str | None, int | None, int | None] = None, None, None
        self._entered: tuple[str | None, int | None, int | None, str | None] = None, None, None, None
        self._left_out = ""
        self._budget = budget_seconds
        self._spent = 0.0
        self._crew: Crew | None = None
        self._reported = 0.0
        self._record = store.find(self._study_id)

    def begin(self, only_from: tuple[str, ...]) -> bool:
        """Let the study run, in one step with the look at its state; False where it is in none of those."""
        # why it was put down before holds no more; what is said of blocks that failed does
        told = None if self._record.points_failed else ""
        owner = self._lease.owner
        self._record = self._store.set_state(
            self._study_id, "running", told, only_from=only_from, owner=owner
        )
        self._lease.begun.set()
        return self._record.state == "running"

    def compute(
        self,
        client_factory: "Callable[[], AbstractContextManager[Client]]",
        here_seconds: float,
        wait_seconds: float,
    ) -> None:
        """Compute every pending block, or as many as there is leave for."""
        study = parse_stored(self._record.definition, self._record.digest)
        # The cube's own cut: the cost model may have changed since the study was submitted.
        self._plan = plan_with_chunk(study, self._record.chunk, seconds_per_point)
        pending = self._store.pending(self._study_id)
        earlier = measured_blocks(self._store, self._study_id) if pending.size else []
        forecast = Forecast(self._plan, known_of(earlier))
        # as they were expected at the beginning: progress is the share of that which is done
        self._expected = forecast.seconds
        work_left = float(self._expected[pending].sum())
        self._meter = Meter(_progress(self._record), work_left)
        self._report(at_once=True)
        if not pending.size or self._stopping:
            return
        sweep(self._store, self._study_id)
        if self._record.blocks_done:
            # known before a cluster is started; whether the processors are alike its workers say
            require_solver(self._study_id, self._record.provenance)
        cube_path = self._store.cube_path(self._study_id)
        self._require_room()
        if work_left <= here_seconds:
            self._agree({"this process": computing()})
            tasks = self._tasks(cube_path)
            self._compile_here(missing(scenes(study)))
            self._begin_blocks(work_left)
            order = map(int, self._plan.order(pending))
            self._pump(Here(lambda index, key: run_block(*tasks(index, key)), order), cube_path)
            return
        try:
            description_of(open_shelf(cube_path))
        except (OSError, ValueError) as error:
            # nobody could read it; else who cannot is left out
            kind = Outage if isinstance(error, ShelfAway) else Interrupted
            raise kind(f"the study's data cannot be read ({type(error).__name__}: {error})") from error
        self._enter("starting")
        with client_factory() as client:
            # known here alone: what is computed in this process needs no cluster's library
            from damperlab.worker.preparation import compile_at_workers
            from damperlab.worker.window import Window

            def task(index: int, key: str) -> tuple[Any, ...]:
                return run_block, *tasks(index, key)

            window = Window(client, task, Backlog(pending, forecast), wait_seconds=wait_seconds)
            self._crew = window.crew
            try:
                first = partial(window.assemble, cube_path, self._record.digest, code_hash())
                begun = self._record.provenance.get("identity", "") if self._record.blocks_done else ""
                facts = first(begun, None, "", lambda: self._look_on(window))
                if facts is None:
                    return
                self._agree({"the workers": facts})
                tasks = self._tasks(cube_path)
                usable = [member.address for member in window.crew.usable]
                with asking_the_cluster(client):
                    compile_at_workers(client, scenes(study), self._compiling, lambda: self._stopping, usable)
                canary, truth = self._canary(pending)
                if first(facts["identity"], canary, truth, lambda: self._look_on(window)) is None:
                    return
                self._begin_blocks(work_left)
                self._pump(window, cube_path)
            finally:
                # what ended the run matters more than that this cannot be written
                with suppress(StoreFault):
                    self._tell(window)
                window.close()

    def _canary(self, pending: "np.ndarray") -> tuple[Block, str]:
        """Choose points that every worker computes first, and give their bits where they are stored."""
        study = self._plan.study
        done = np.setdiff1d(np.arange(self._plan.count), pending, assume_unique=True)
        if done.size:
            canary = canary_of(self._plan, int(done[0]))
            names = [variable.name for variable in stored_variables(study)]
            with suppress(StoreFault, OSError):
                # no worker is measured by what is not there
                if truth := stored_bits(self._store.cube(self._study_id), study, canary, names):
                    return canary, truth
        return canary_of(self._plan, int(pending[0])), ""

    def _look_on(self, window: "Window") -> bool:
        """Let everybody see what is waited for; False where the study shall stop."""
        self._tell(window)
        return not self._stopping

    def _tell(self, window: "Window") -> None:
        """Record what has happened to workers, and what the study waits for."""
        for sentence in window.crew.take_news():
            _log.warning("study %s: %s", self._study_id, sentence)
            self._store.note(self._study_id, sentence)
        stranded, out = window.stranded, window.crew.reasons()
        if stranded is not None:
            self._enter("waiting", message=stranded)
        elif self._phase[0] == "waiting" or (out != self._left_out and self._phase[0] is None):
            self._enter(None, message=out)
        self._left_out = out

    def _compile_here(self, lacking: list[Scene]) -> None:
        """Compile what a study lacks that this process computes, in processes that leave it free."""
        if not lacking:
            return
        from damperlab.worker.cluster import core_count

        self._compiling(0, len(lacking))
        # what fails here the blocks compile themselves, and say what is wrong
        with suppress(RuntimeError), closing(compile_apart(lacking, core_count())) as compiled:
            for done, _ in enumerate(compiled, 1):
                self._compiling(done, len(lacking))
                if self._stopping:
                    return

    def _begin_blocks(self, work_left: float) -> None:
        """Go over from preparation to blocks; what it took says nothing about their pace."""
        # what was waited for is there
        self._enter(None, message=self._left_out)
        self._meter = Meter(_progress(self._record), work_left)

    def _compiling(self, done: int, total: int) -> None:
        self._enter("compiling", done, total)

    def _enter(
        self, phase: str | None, done: int | None = None, total: int | None = None, message: str | None = None
    ) -> None:
        """Let everybody see what the study is at."""
        if (phase, done, total, message) != self._entered:
            self._entered = phase, done, total, message
            self._phase = phase, done, total
            self._store.set_phase(
                self._study_id, phase, done, total, owner=self._lease.owner, message=message
            )
        self._report(at_once=True)

    def _agree(self, answers: dict[str, dict[str, str]]) -> None:
        """Record what the study is computed with.

        Raises
        ------
        WrongCode
            Those who compute are unlike each other, or unlike what computed the blocks that are there.
        """
        now = one_identity(answers)
        self._record = self._store.begin(self._study_id, now, self._lease.owner)
        require_begun_alike(self._study_id, self._record.provenance, now)

    def _tasks(self, cube_path: str) -> Callable[[int, str], tuple[Any, ...]]:
        """Give what makes the arguments of `run_block` from a block's index and its task's key."""
        overlaps = Overlaps(self._store, self._record)
        solver = self._record.provenance["identity"]

        def arguments(index: int, key: str) -> tuple[Any, ...]:
            block = self._plan.block(index)
            # a key is used once, so the files of no two attempts have the same name
            generation = key.removeprefix("block-")
            return cube_path, self._record.digest, block, code_hash(), generation, overlaps.of(block), solver

        return arguments

    def end(self, stopped_as: str) -> None:
        """Put the study into the state that its blocks say."""
        record = self._store.find(self._study_id)
        self._report(at_once=True)
        if self._lease.lost.is_set():
            return
        sweep(self._store, self._study_id)
        if record.blocks_done < record.blocks_total:
            self.put_down(stopped_as, self._budget_spent())
            return
        message = f"computed without workers that were left out: {self._left_out}" if self._left_out else None
        if self._failures:
            count, total = len(self._failures), record.blocks_total
            message = f"{count} of {total} blocks failed; the first: {self._failures[0]}"
        elif message is None and record.message and not record.points_failed:
            message = ""  # of an earlier run that was interrupted; there is nothing to say any more
        # Only blocks that were given up take no kernel time: points that fail by their numbers are an answer.
        given_up = record.points_failed == record.points_total and record.kernel_seconds == 0.0
        state = "failed" if given_up else "done"
        self._store.set_state(self._study_id, state, message, owner=self._lease.owner)

    def put_down(self, state: str, message: str | None) -> None:
        """End a study that is not complete, unless somebody else has said what becomes of it."""
        if not self._lease.lost.is_set():
            self._store.set_state(
                self._study_id, state, message, only_from=("running",), owner=self._lease.owner
            )

    def left(self) -> str:
        """What remains, and how to go on."""
        record = self._store.find(self._study_id)
        pending = record.blocks_total - record.blocks_done
        return f"{record.blocks_done} of {record.blocks_total} blocks are kept, resume computes the other {pending}"

    @property
    def _stopping(self) -> bool:
        return self._stop.is_set() or self._lease.over or self._spent >= self._budget

    def _budget_spent(self) -> str | None:
        """Say that the budget ended the run; None where something else did."""
        if self._spent < self._budget:
            return None
        hours = self._budget / SECONDS_PER_HOUR
        return f"the budget of {hours:.3g} core hours is spent; {self.left()}"

    def _pump(self, window: "Window | Here", cube_path: str) -> None:
        while not self._stopping:
            self._require_room()
            window.fill()
            if window.empty:
                return
            if not isinstance(window, Here):
                self._tell(window)
            self._keep(window.collect(POLL_SECONDS), cube_path)
            self._report()
        for ended in window.drain(GRACE_SECONDS):
            self._keep([ended], cube_path)
            self._report()

    def _require_room(self) -> None:
        trouble = self._store.trouble()
        if trouble is not None:
            raise Outage(trouble)

    def _keep(self, ended: Iterable[BlockOutcome | Failure], cube_path: str) -> None:
        outcomes: list[BlockOutcome] = []
        try:
            for end in ended:
                if self._lease.lost.is_set():
                    return
                outcomes.append(self._give_up(end, cube_path) if isinstance(end, Failure) else end)
        finally:
            # also where the cluster is lost half-way: what is safe on the disk need not be computed again
            self._mark(outcomes)

    def _mark(self, outcomes: list[BlockOutcome]) -> None:
        if not outcomes or self._lease.lost.is_set():
            return
        # one commit for all that has ended meanwhile: the more arrives, the less each costs
        if not self._store.mark(self._study_id, *outcomes, owner=self._lease.owner):
            self._lease.lost.set()
            return
        for outcome in outcomes:
            self._spent += outcome.kernel_seconds
            self._meter.add(outcome.points, outcome.failed, float(self._expected[outcome.index]))

    def _give_up(self, failure: Failure, cube_path: str) -> BlockOutcome:
        block = self._plan.block(failure.index)
        began = time.perf_counter()
        values = failed_values(self._plan.study, block)
        generation = uuid.uuid4().hex[:12]
        try:
            told = {"message": failure.message}
            checksum = write_region(cube_path, block, values, generation, told)
        except OSError as error:
            kind = Outage if isinstance(error, ShelfAway) or is_full(error) else Interrupted
            raise kind(f"the study's data cannot be written ({error})") from error
        self._failures.append(f"block {failure.index}: {failure.message}")
        points = values["status"].size
        seconds = time.perf_counter() - began
        return BlockOutcome(
            failure.index, points, points, seconds, 0.0, failure.message, generation, checksum
        )

    def _report(self, at_once: bool = False) -> None:
        now = time.monotonic()
        if at_once or now - self._reported >= REPORT_SECONDS:
            self._reported = now
            phase, done, total = self._phase
            now_at = self._meter.progress()
            if phase is not None:
                now_at = replace(now_at, phase=phase, phase_done=done, phase_total=total)
            if self._crew is not None:
                crew = self._crew
                now_at = replace(
                    now_at, workers=crew.standings(), blocks_in_flight=crew.in_flight, retries=crew.retries
                )
            self._on_progress(now_at)


def _progress(record: Record) -> Progress:
    return Progress(
        record.points_total,
        record.points_done,
        record.points_failed,
        record.blocks_total,
        record.blocks_done,
        points_per_second=0.0,
        seconds_left=None,
    )
