"""A discrete model of a cluster: the runner's own policy, which block goes to whom, over workers that only keep time.

Two questions. How busy are 2, 8, 32, 128 workers with the blocks of a study whose points take what they took when they were
measured (`run_time.npz`: one hybrid study of 24 × 12 × 40 points; larger ones repeat its points), beside the best that
is possible with the same blocks. And what becomes of 10⁸ points on 10,000 workers that live one hour each.

`python -m tests.benchmarks.model` prints both; crew and backlog are the product's, nothing of them is modelled.
"""

import heapq
import json
import math
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.definition import parse_study
from damperlab.studies.plan import Plan, make_plan
from damperlab.worker.backlog import Backlog
from damperlab.worker.cost import seconds_per_point
from damperlab.worker.crew import Crew

MEASURED = Path(__file__).with_name("run_time.npz")
TRAVEL_SECONDS = 0.01
"""From the end of a block until its worker has the next one, where none waits there."""


class Model:
    """Workers that keep time.

    Parameters
    ----------
    backlog : Backlog
        The blocks.
    truth : array of float
        What each block takes.
    workers : int
        How many, always: one that is gone is replaced.
    life_seconds : float
        Mean life of a worker, exponentially distributed.
    replace_seconds : float
        After how long another comes.
    """

    def __init__(
        self,
        backlog: Backlog,
        truth: NDArray[np.float64],
        workers: int,
        life_seconds: float = math.inf,
        replace_seconds: float = 60.0,
    ) -> None:
        self.crew = Crew(backlog)
        self._truth = truth
        self._life, self._replace = life_seconds, replace_seconds
        self._events: list[tuple[float, int, str, str]] = []
        self._count = 0
        self._random = np.random.default_rng(1)
        self._threads: dict[str, int] = {}
        self._began: dict[str, float] = {}
        self.now = self.lost = self.done = 0.0
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
                self._see()
                self._send()
            elif what == "gone" and name in self._threads:
                self._lose(name)
            elif what == "end" and name in self._began:
                self._end(name)
            if not self.crew.waiting and not self._began:
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
        if math.isfinite(when):
            heapq.heappush(self._events, (when, self._count, what, name))

    def _lose(self, name: str) -> None:
        del self._threads[name]
        for key in self.crew.vanish(name):
            if key in self._began:
                self.lost += self.now - self._began.pop(key)
        self._at(self.now + self._replace, "hire", "")
        self._send()

    def _end(self, key: str) -> None:
        name = self.crew.at(key)
        assert name is not None
        index = int(key.split("-")[1])
        del self._began[key]
        self.done += self._truth[index]
        self.crew.ended(key)
        waiting = self.crew.members[name].held
        if waiting:
            self._begin(next(iter(waiting)))
        self._send()

    def _begin(self, key: str, after: float = 0.0) -> None:
        self._began[key] = self.now + after
        self._at(self.now + after + float(self._truth[int(key.split("-")[1])]), "end", key)

    def _see(self) -> None:
        self.crew.see(self._threads, self._threads)
        for member in list(self.crew.due(math.inf)):
            self.crew.admit(member.address)

    def _send(self) -> None:
        for address, attempt in self.crew.assignments():
            self.decisions += 1
            key = f"b-{attempt.index}-{self.decisions}"
            self.crew.sent(key, address, attempt)
            if len(self.crew.members[address].held) == 1:
                self._begin(key, TRAVEL_SECONDS)


def best_possible(truth: NDArray[np.float64], workers: int) -> float:
    """Busy share where all that blocks take is known beforehand and the longest begin first; nearly the best there is."""
    free = [0.0] * workers
    for seconds in -np.sort(-truth):
        heapq.heappush(free, heapq.heappop(free) + float(seconds))
    return float(truth.sum() / (workers * max(free)))


def replayed(plan: Plan) -> NDArray[np.float64]:
    """Seconds of every block of a plan over the measured points, tiled."""
    points = np.load(MEASURED)["run_time"].astype(float).reshape(24, 12, 40)
    repeat = [-(-n // m) for n, m in zip(plan.shape[-3:], points.shape, strict=True)]
    tiled = np.repeat(np.repeat(np.repeat(points, repeat[0], 0), repeat[1], 1), repeat[2], 2)
    tiled = tiled[: plan.shape[-3], : plan.shape[-2], : plan.shape[-1]]
    return np.array([tiled[plan.block(index).slices[-3:]].sum() for index in range(plan.count)])


def study_of(refined: int) -> Plan:
    """The measured study, each axis so many times finer."""
    axes = {
        "clearance_ratio": {"start": 1, "stop": 25, "num": 24 * refined},
        "friction_ratio": {"start": 0, "stop": 0.8, "num": 12 * refined},
        "restitution": 0.47,
        "mass_ratio": 0.1,
        "frequency_ratio": {"start": 0.8, "stop": 1.2, "num": 40 * refined},
    }
    return make_plan(parse_study({"damping_ratio": 0.0038, "axes": axes}), seconds_per_point)


def busy(refined: int, workers: int) -> dict[str, Any]:
    """Busy share of one study on so many workers: in the model, and at best."""
    plan = study_of(refined)
    truth = replayed(plan)
    model = Model(Backlog(plan.order()), truth, workers)
    model.run()
    return {
        "blocks": plan.count,
        "workers": workers,
        "block_seconds": [float(truth.min()), float(np.median(truth)), float(truth.max())],
        "busy": truth.sum() / (workers * model.now),
        "best": best_possible(truth, workers),
    }


def vast(workers: int = 10_000, life_seconds: float = 3600.0) -> dict[str, Any]:
    """10⁸ points in the most blocks that a plan has, on workers that live one hour each."""
    axes = {
        "clearance_ratio": {"start": 1, "stop": 25, "num": 500},
        "friction_ratio": {"start": 0, "stop": 0.8, "num": 400},
        "frequency_ratio": {"start": 0.8, "stop": 1.2, "num": 500},
    }
    plan = make_plan(parse_study({"damping_ratio": 0.0038, "axes": axes}), seconds_per_point)
    truth = plan.block_seconds * np.random.default_rng(2).lognormal(0.0, 0.5, plan.count)
    began = time.process_time()
    model = Model(Backlog(plan.order()), truth, workers, life_seconds)
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


def killed(workers: int = 24, blocks: int = 240, seconds: float = 2.0) -> dict[str, Any]:
    """Half of the workers are gone at a third of the run, and none comes back; beside the ideal time."""
    truth = np.full(blocks, seconds) * np.random.default_rng(3).lognormal(0.0, 0.3, blocks)
    model = Model(Backlog(range(blocks)), truth, workers, replace_seconds=math.inf)
    at = truth.sum() / workers / 3
    for name in list(model._threads)[: workers // 2]:
        model._at(at, "gone", name)
    model.run()
    ideal = at + (truth.sum() - workers * at) / (workers / 2)
    return {"seconds": model.now, "ideal": ideal, "over": model.now / ideal - 1.0}


def run() -> dict[str, Any]:
    """All of it."""
    return {
        "busy": [busy(refined, workers) for refined in (1, 2, 4) for workers in (2, 8, 32, 128)],
        "half_killed": killed(),
        "vast": vast(),
    }


if __name__ == "__main__":
    print(json.dumps(run(), indent=1))
