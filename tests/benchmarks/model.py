"""A discrete model of a cluster: the runner's own policy, which block goes to whom, over workers that only keep time.

Two questions. How busy are 2, 8, 32, 128 workers with the blocks of a study whose points take what they took when they were
measured, beside the best that is possible with the same blocks. And what becomes of 10⁸ points on 10,000 workers that live one
hour each.

`run_time.npz` holds what each point of a hybrid study took, 48 × 24 × 80 points, as sixteenths of powers of two in seconds;
each point of another grid takes what the nearest of these took. `python -m tests.benchmarks.model` prints both; the policy is
the product's, nothing of it is modelled.
"""

import heapq
import json
import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.definition import parse_study
from damperlab.studies.plan import Plan, make_plan
from damperlab.worker.dispatch.cost_model import seconds_per_point
from damperlab.worker.dispatch.window import LOOK_SECONDS
from damperlab.worker.dispatch.workers import Workers

MEASURED = Path(__file__).with_name("run_time.npz")
ENDS = (1.0, 25.0), (0.0, 0.8), (0.8, 1.2)
"""Of the measured clearance ratios, friction ratios and frequency ratios."""
REPLACE_SECONDS = 60.0
"""Until another worker comes for one that is gone."""
HANDING_SECONDS = 3.4e-3
"""The scheduler takes so long for each block, one after the other (`tests/benchmarks/scale.py`)."""
TRAVEL_SECONDS = 0.01
"""From the end of a block until its worker has the next one, where none waits there and the scheduler is idle."""


class Model:
    """Workers that keep time.

    Parameters
    ----------
    policy : Workers
        The workers, none of them present yet, and the blocks.
    truth : callable
        What a block takes [s].
    workers : int
        How many, always: one that is gone is replaced.
    life_seconds : float
        Mean life of a worker, exponentially distributed.
    """

    def __init__(
        self,
        policy: Workers,
        truth: Callable[[int], float],
        workers: int,
        life_seconds: float = math.inf,
    ) -> None:
        self.workers = policy
        self._truth = truth
        self._life = life_seconds
        self._events: list[tuple[float, int, str, str]] = []
        self._count = 0
        self._random = np.random.default_rng(1)
        self._threads: dict[str, int] = {}
        self._began: dict[str, float] = {}
        self._there: dict[str, float] = {}
        self._looks = False
        self.now = self.lost = self.done = self._handed = 0.0
        self.decisions = 0
        for _ in range(workers):
            self._hire()
        self._see()

    def run(self) -> None:
        """Until every block has ended."""
        self._send()
        while self._events:
            self.now, _, what, name = heapq.heappop(self._events)
            if what == "hire":
                self._hire()
                if not self._looks:
                    self._looks = True
                    self._at(self.now + LOOK_SECONDS, "look", "")
            elif what == "look":
                self._looks = False
                self._see()
                self._send()
            elif what == "gone" and name in self._threads:
                self._lose(name)
            elif what == "end" and name in self._began:
                self._end(name)
            if not self.workers.waiting and not self._began:
                return

    def _hire(self) -> None:
        name = f"w{self._count}"
        self._threads[name] = 1
        if math.isfinite(self._life):
            self._at(self.now + self._random.exponential(self._life), "gone", name)
        else:
            self._count += 1

    def _at(self, when: float, what: str, name: str) -> None:
        self._count += 1
        heapq.heappush(self._events, (when, self._count, what, name))

    def _lose(self, name: str) -> None:
        del self._threads[name]
        for key in self.workers.vanish(name):
            if key in self._began:
                self.lost += max(0.0, self.now - self._began.pop(key))
            self._there.pop(key, None)
        self._at(self.now + REPLACE_SECONDS, "hire", "")
        self._send()

    def _end(self, key: str) -> None:
        name = self.workers.at(key)
        assert name is not None
        del self._began[key]
        seconds = self._truth(self.workers.states[name].held[key].index)
        self.done += seconds
        self.workers.ended(key)
        waiting = self.workers.states[name].held
        if waiting:
            self._begin(name, next(iter(waiting)))
        self._send()

    def _begin(self, name: str, key: str) -> None:
        self._began[key] = max(self.now, self._there.pop(key))
        self._at(self._began[key] + self._truth(self.workers.states[name].held[key].index), "end", key)

    def _see(self) -> None:
        self.workers.see(self._threads, self._threads)
        for worker in list(self.workers.due(math.inf)):
            self.workers.admit(worker.address)

    def _send(self) -> None:
        for address, attempt in self.workers.assignments():
            self.decisions += 1
            key = f"b-{self.decisions}"
            self.workers.sent(key, address, attempt)
            self._handed = max(self._handed, self.now) + HANDING_SECONDS
            self._there[key] = self._handed + TRAVEL_SECONDS
            if len(self.workers.states[address].held) == 1:
                self._begin(address, key)


def _begin_at(workers: int) -> NDArray[np.float64]:
    return HANDING_SECONDS * np.arange(1, workers + 1) + TRAVEL_SECONDS


def best(truth: NDArray[np.float64], workers: int) -> float:
    """Busy share where all that blocks take is known beforehand, and the longest begin first; nearly the best."""
    free, end = list(_begin_at(workers)), 0.0
    for seconds in -np.sort(-truth):
        ends = heapq.heappop(free) + float(seconds)
        heapq.heappush(free, ends)
        end = max(end, ends)
    return float(truth.sum() / (workers * end))


class Replay:
    """Seconds of every block of a plan over the measured points.

    Parameters
    ----------
    plan : Plan
        Of `study_of`.
    """

    def __init__(self, plan: Plan) -> None:
        points = 2.0 ** (np.load(MEASURED)["sixteenths"] / 16.0)
        axes = list(plan.study.coordinates.values())[-3:]
        nearest = [
            np.rint(np.interp(values, ends, (0, count - 1))).astype(np.int64)
            for values, ends, count in zip(axes, ENDS, points.shape, strict=True)
        ]
        self._plan = plan
        self._taken = points[np.ix_(*nearest)]

    def __call__(self, index: int) -> float:
        """Give what a block takes [s]."""
        return float(self._taken[self._plan.block(index).slices[-3:]].sum())

    @property
    def blocks(self) -> NDArray[np.float64]:
        """What each block takes [s], (count,)."""
        return np.array([self(index) for index in range(self._plan.count)])


def study_of(*points: int) -> Plan:
    """A study over the measured box, with so many clearances, frictions and frequencies."""
    names = ("clearance_ratio", "friction_ratio", "frequency_ratio")
    axes = {
        name: {"start": start, "stop": stop, "num": num}
        for name, (start, stop), num in zip(names, ENDS, points, strict=True)
    }
    fixed = {"restitution": 0.47, "mass_ratio": 0.1}
    return make_plan(parse_study({"damping_ratio": 0.0038, "axes": axes | fixed}), seconds_per_point)


def busy(refined: int, workers: int) -> dict[str, Any]:
    """Busy share of a study of 24 × 12 × 40 points, each axis so many times finer, on so many workers; and at best."""
    plan = study_of(24 * refined, 12 * refined, 40 * refined)
    replay = Replay(plan)
    truth = replay.blocks
    model = Model(Workers(plan.order(), plan.block_seconds), replay, workers)
    model.run()
    return {
        "blocks": plan.count,
        "workers": workers,
        "block_seconds": [float(truth.min()), float(np.median(truth)), float(truth.max())],
        "seconds": model.now,
        "busy": truth.sum() / (workers * model.now),
        "best": best(truth, workers),
    }


def estimates(refined: int) -> dict[str, float]:
    """Core seconds of the same study, as they are expected and as they were."""
    plan = study_of(24 * refined, 12 * refined, 40 * refined)
    earlier = study_of(23, 11, 39)
    factor = float(Replay(earlier).blocks.sum()) / earlier.seconds
    return {"first": plan.seconds, "family": factor * plan.seconds, "true": float(Replay(plan).blocks.sum())}


def vast(workers: int) -> dict[str, Any]:
    """10⁸ points in the most blocks that a plan has, on workers that live one hour each."""
    axes = {
        "clearance_ratio": {"start": 1, "stop": 25, "num": 500},
        "friction_ratio": {"start": 0, "stop": 0.8, "num": 400},
        "frequency_ratio": {"start": 0.8, "stop": 1.2, "num": 500},
    }
    plan = make_plan(parse_study({"damping_ratio": 0.0038, "axes": axes}), seconds_per_point)
    truth = plan.block_seconds * np.random.default_rng(2).lognormal(0.0, 0.5, plan.count)
    began = time.process_time()
    policy = Workers(plan.order(), plan.block_seconds)
    model = Model(policy, lambda index: float(truth[index]), workers, 3600.0)
    model.run()
    cpu = time.process_time() - began
    return {
        "points": plan.points,
        "blocks": plan.count,
        "workers": workers,
        "core_hours": truth.sum() / 3600.0,
        "seconds": model.now,
        "lost_share": model.lost / truth.sum(),
        "busy": truth.sum() / (workers * model.now),
        "blocks_a_second": plan.count / model.now,
        "policy_cpu_ms_per_block": 1e3 * cpu / plan.count,
    }


def run() -> dict[str, Any]:
    """All of it."""
    return {
        "estimates": [estimates(refined) for refined in (1, 2, 4)],
        "busy": [busy(refined, workers) for refined in (1, 2, 4, 8) for workers in (2, 8, 32, 128)],
        "vast": [vast(workers) for workers in (1_000, 10_000)],
    }


if __name__ == "__main__":
    print(json.dumps(run(), indent=1))
