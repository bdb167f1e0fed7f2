"""Runs waiting studies on the cluster, a few in parallel. Unfinished studies are resumed after a restart or a crash."""

import logging
import threading
import time
from collections.abc import Collection, Mapping
from dataclasses import dataclass

from damperlab.service.cluster import SharedCluster
from damperlab.studies.remarks import Remarks
from damperlab.studies.store.care.sweep import collect_garbage
from damperlab.studies.store.faults import StoreFault, StudyBusy, StudyNotFound
from damperlab.studies.store.life_cycle.claims import Waiting
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store
from damperlab.worker.dispatch.worker_state import STANDINGS
from damperlab.worker.outcomes import ClusterUnusable
from damperlab.worker.run.background import Background
from damperlab.worker.run.lease import owner_is_dead
from damperlab.worker.run.progress import Progress

LOOK_SECONDS = 2.0
"""Interval between checks for waiting studies [s]. Other processes may have queued studies or left them unfinished."""
WAIT_SECONDS = 20.0
"""Longest wait of a running study for workers [s]. Afterwards the study is queued again, so that another
study can run.
"""
CLEAN_SECONDS = 3600.0
"""Interval between checks for files that are no longer used [s]."""
AGAIN_SECONDS = 5.0
"""Time after which a study is tried again if the cluster or the store failed [s]."""
COMPANY, MOST = 4, 64
"""Smallest and largest number of small studies in a batch."""
STOP_SECONDS = 60.0
"""Longest wait for running studies at a shutdown [s]. The wait is longer than a study waits for its running
blocks.
"""

_log = logging.getLogger("damperlab.dispatch")


@dataclass(frozen=True)
class _Run:
    thread: threading.Thread
    stop: threading.Event


class Dispatcher:
    """Runs the queued studies of a store.

    Studies with the highest priority run first. Among studies of equal priority, the submitters take turns, and the
    oldest study of a submitter runs first.

    The catalogue is the queue. A study is run if its state in the catalogue is queued, or if it is running and its
    process has died. A claim in the catalogue prevents two services from running the same study.

    Parameters
    ----------
    store : Store
        Store that requests use, with a short wait for the write lock of the catalogue.
    runs : Store
        The same store for runs of studies, with a long wait for the write lock, so that no computed block is lost.
    cluster : SharedCluster
        Cluster that computes the studies.
    at_once : int
        Largest number of studies that run at the same time.
    """

    def __init__(self, store: Store, runs: Store, cluster: SharedCluster, at_once: int) -> None:
        self.cluster = cluster
        self.trouble: str | None = None
        """Reason why the last study could not be run; None if the cluster can be used."""
        self._store = store
        self._runners_store = runs
        self._at_once = at_once
        self._lock = threading.Lock()
        # this mapping is never changed but always replaced, so that it can be read without the lock
        self._runs: Mapping[str, _Run] = {}
        self._progress: dict[str, Progress] = {}
        self._retries = 0
        self._not_before: dict[str, float] = {}
        # ids of small studies that were left over by a batch and need a separate run
        self._alone: set[str] = set()
        # for each submitter, the number of its last start; the submitter with the smallest number is next
        self._turns: dict[str | None, int] = {}
        # the event is set at the start, because an earlier process may not have completed its deletions
        self._leaving: list[threading.Thread] = []
        self._untidy = threading.Event()
        self._untidy.set()
        self._dispatching = Background("dispatch", self._start_runs, LOOK_SECONDS)
        self._removing = Background("remove", self._remove, LOOK_SECONDS)
        self._cleaning = Background("clean", self._clean, CLEAN_SECONDS)

    @property
    def backgrounds(self) -> tuple[Background, ...]:
        """Background threads of the dispatcher."""
        return self._dispatching, self._removing, self._cleaning

    @property
    def running(self) -> list[str]:
        """Ids of the studies that this process runs."""
        return sorted(self._runs)

    def workload(self) -> tuple[dict[str, int], int, int]:
        """Count the workers, the blocks at workers and the repeated attempts, for the studies that this process runs.

        Returns
        -------
        dict, int, int
            Number of workers by state, number of blocks at workers, and number of repeated attempts since the start
            of the service. The number of workers is the maximum over the running studies.
        """
        with self._lock:
            now = list(self._progress.values())
            retries = self._retries + sum(each.retries for each in now)
        counts = dict.fromkeys(map(str, STANDINGS), 0)
        for each in now:
            for standing, count in each.workers:
                counts[standing] = max(counts[standing], count)
        return counts, sum(each.blocks_in_flight for each in now), retries

    def blocks_left(self) -> int:
        """Return the number of remaining blocks of the studies that this process runs."""
        with self._lock:
            return sum(each.blocks_total - each.blocks_done for each in self._progress.values())

    def _follow(self, study_id: str, progress: Progress) -> None:
        with self._lock:
            self._progress[study_id] = progress

    def start(self) -> None:
        """Start the background threads."""
        self._dispatching.start()
        self._removing.start()
        self._cleaning.start(at_once=False)

    def wake(self) -> None:
        """Check for waiting studies now, for example after a study was queued."""
        self._dispatching.wake()

    def cancel(self, record: Record) -> Record:
        """Cancel a queued or running study, and keep its finished blocks.

        Parameters
        ----------
        record : Record
            The study.

        Returns
        -------
        Record
            The study in its new state. The state is unchanged if the study had already ended.
        """
        cancelled = self._store.set_state(
            record.id, "cancelled", only_from=("queued", "running"), at_once=False
        )
        self._tidy()
        # if the study was resumed meanwhile, the stop may hit the new run; the study is then queued again
        with self._lock:
            run = self._runs.get(record.id)
        if cancelled.state == "cancelled" and run is not None:
            run.stop.set()
        return cancelled

    def resume(self, record: Record) -> Record:
        """Queue a cancelled or failed study again; only missing points of the study will be computed."""
        queued = self._store.set_state(record.id, "queued", only_from=("cancelled", "failed"))
        self._try_now(record.id)
        return queued

    def retry(self, record: Record) -> Record:
        """Queue a study again so that its failed blocks are repeated. Raise `NothingToDo` if no block has failed."""
        queued = self._store.retry(record.id)
        self._try_now(record.id)
        return queued

    def remark(self, study_id: str, remarks: Remarks) -> Record:
        """Store remarks on a study in the catalogue. A background thread writes the remarks to the cube."""
        record = self._store.remark(study_id, remarks, at_once=False)
        self._tidy()
        return record

    def delete(self, record: Record, keep_seconds: float = 0.0) -> None:
        """Delete a study that is not running.

        The study disappears immediately. A background thread removes the files of the study once the last run
        of the study has stopped.

        Parameters
        ----------
        record : Record
            The study.
        keep_seconds : float
            Time for which the study can be restored [s].

        Raises
        ------
        StudyBusy
            If the study is running.
        """
        self._store.delete(record.id, keep_seconds)
        with self._lock:
            run = self._runs.get(record.id)
            if run is not None:
                self._leaving.append(run.thread)
        self._tidy()

    def _tidy(self) -> None:
        """Let a background thread remove the files of deleted studies and write postponed changes to cubes."""
        self._untidy.set()
        self._removing.wake()

    def close(self) -> None:
        """Stop all runs, queue unfinished studies for the next start, and close the cluster."""
        for background in self.backgrounds:
            background.tell_to_close()
        self._dispatching.close()
        # files that are not removed in this time are removed after the next start
        self._removing.close(LOOK_SECONDS)
        self._cleaning.close(LOOK_SECONDS)
        with self._lock:
            runs = self._runs
        for run in runs.values():
            run.stop.set()
        deadline = time.monotonic() + STOP_SECONDS
        for study_id, run in runs.items():
            run.thread.join(max(0.0, deadline - time.monotonic()))
            if run.thread.is_alive():
                _log.warning("study %s did not stop in time; its claim will expire", study_id)
        self.cluster.close()

    def _clean(self) -> None:
        try:
            swept = collect_garbage(self._runners_store)
            for line in (*swept.what, *swept.unknown):
                _log.info("garbage: %s", line)
        except (StoreFault, OSError) as error:
            _log.warning("files that no study needs could not be removed: %s", error)

    def _remove(self) -> None:
        if not self._untidy.is_set():
            return
        self._untidy.clear()
        with self._lock:
            leaving, self._leaving = self._leaving, []
        try:
            for thread in leaving:  # files are removed only after the run has stopped writing to them
                thread.join(STOP_SECONDS)
            # files are removed before postponed changes are written, because the changes may need the space
            self._runners_store.bury(stop=lambda: self._removing.closing)
            self._runners_store.keep_late_marks(stop=lambda: self._removing.closing)
        except (StoreFault, OSError) as error:
            self._untidy.set()
            _log.warning(
                "changes of cubes could not be written, or deleted studies could not be removed: %s", error
            )
        except BaseException:
            self._untidy.set()
            raise

    def _start_runs(self) -> None:
        waiting = self._waiting()
        while waiting:
            # the sort is stable, so the studies of a submitter stay in the order of their age
            waiting.sort(key=lambda one: (-one.priority, self._turns.get(one.owner, 0)))
            # if the first study is small and enough other small studies wait, they are run as one batch
            small = [one.id for one in waiting if one.small and one.id not in self._alone][:MOST]
            together = len(small) >= COMPANY and small[0] == waiting[0].id
            ids = small if together else [waiting[0].id]
            with self._lock:
                if self._dispatching.closing or self._busy():
                    return
                ids = [study_id for study_id in ids if study_id not in self._runs]
                if ids:
                    self._begin(ids, waiting[0].owner, together)
            taken = set(ids) | ({waiting[0].id} if not together else set(small))
            waiting = [one for one in waiting if one.id not in taken]

    def _begin(self, ids: list[str], owner: str | None, together: bool) -> None:
        """Start a thread that runs one study or a batch. The thread checks whether a study was cancelled meanwhile."""
        stop = threading.Event()
        work, about = (self._run_batch, ids) if together else (self._run, ids[0])
        thread = threading.Thread(target=work, args=(about, stop), name=f"study-{ids[0]}", daemon=True)
        thread.start()
        self._runs = {**self._runs, **{study_id: _Run(thread, stop) for study_id in ids}}
        self._turns[owner] = 1 + max(self._turns.values(), default=0)

    def _busy(self) -> bool:
        """Return whether the limit of parallel runs is reached."""
        # a thread that has died may not have removed its entry
        self._runs = {study_id: run for study_id, run in self._runs.items() if run.thread.is_alive()}
        return len({run.thread for run in self._runs.values()}) >= self._at_once

    def _waiting(self) -> list[Waiting]:
        """Return the waiting studies that no process has claimed, the oldest first."""
        with self._lock:
            if self._busy():
                return []
            here = set(self._runs)
            now = time.monotonic()
            self._not_before = {key: until for key, until in self._not_before.items() if until > now}
        # more studies are requested than needed, because the oldest may be postponed or may run here already
        most = 2 * MOST + len(here) + len(self._not_before)
        found = self._store.unclaimed(owner_is_dead, most)
        return [one for one in found if one.id not in here and one.id not in self._not_before]

    def _run_batch(self, ids: list[str], stop: threading.Event) -> None:
        from damperlab.worker.run.small_batch import compute_together_on_cluster

        left = ids
        try:
            left = compute_together_on_cluster(self._runners_store, ids, self.cluster.borrow, stop)
            self.trouble = None
            _log.info(
                "%d small studies were run together, %d are left to run alone",
                len(ids) - len(left),
                len(left),
            )
        except BaseException as error:
            # the studies are then run one by one, and each run reports its error or waits for the cluster
            _log.warning("%d small studies are run one by one: %s", len(ids), error)
        finally:
            with self._lock:
                self._alone.update(left)
                self._forget_runs(ids)
            self.wake()

    def _run(self, study_id: str, stop: threading.Event) -> None:
        from damperlab.worker.run.runner import run_study

        try:
            with self.cluster.borrow():
                self.trouble = None
            record = run_study(
                self._runners_store,
                study_id,
                self.cluster.borrow,
                lambda progress: self._follow(study_id, progress),
                stop,
                only_from=("queued", "running"),
                # a cancelled study keeps its state in the catalogue; any other stopped study is queued again
                continues=True,
                wait_seconds=WAIT_SECONDS,
            )
            _log.info(
                "study %s is %s: %d of %d points",
                study_id,
                record.state,
                record.points_done,
                record.points_total,
            )
            if record.state == "queued" and not stop.is_set():
                self._put_off(study_id, record.message or "it was cancelled and resumed elsewhere")
        except ClusterUnusable as error:
            # the scheduler may be starting, or may come back
            self._put_off(study_id, str(error))
        except (StudyBusy, StudyNotFound) as error:
            _log.info("study %s is left alone: %s", study_id, error)
            # retry later: if the clocks of the machines differ, the study may look unclaimed again at once
            with self._lock:
                self._not_before[study_id] = time.monotonic() + AGAIN_SECONDS
        except (StoreFault, OSError) as error:
            # the catalogue cannot be written, or a connection was lost
            self._put_off(study_id, str(error))
        except BaseException as error:
            # if there is a defect or the cluster does not start, only this study fails
            _log.exception("study %s failed", study_id)
            self._put_down(study_id, f"{type(error).__name__}: {error}")
        finally:
            with self._lock:
                self._forget_runs([study_id])
                self._alone.discard(study_id)
                last = self._progress.pop(study_id, None)
                self._retries += 0 if last is None else last.retries
            self.wake()

    def _forget_runs(self, ids: Collection[str]) -> None:
        self._runs = {study_id: run for study_id, run in self._runs.items() if study_id not in ids}

    def _put_down(self, study_id: str, message: str) -> None:
        try:
            self._store.set_state(study_id, "failed", message, only_from=("queued", "running"))
        except StudyNotFound:
            pass  # the study was deleted in the meantime
        except Exception as error:
            self._put_off(study_id, f"{message}; {error}")

    def _try_now(self, study_id: str) -> None:
        with self._lock:
            self._not_before.pop(study_id, None)
        self.wake()

    def _put_off(self, study_id: str, reason: str) -> None:
        self.trouble = reason
        with self._lock:
            self._not_before[study_id] = time.monotonic() + AGAIN_SECONDS
        _log.warning("study %s is tried again in %g s: %s", study_id, AGAIN_SECONDS, reason)
