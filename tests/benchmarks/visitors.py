"""Two hundred clients look at maps while a study runs and somebody asks for the stiffest point there is.

Each client keeps one connection and asks for a map, waits for the answer, and looks at it for a second, a little more or less:
200 requests a second where nobody has to wait. The clients are one process of their own; their latencies are from the first
byte sent to the last one read. Beside them another client asks how the service is, ten times a second.

`--cores 2` holds the service, with all that it starts, to so many cores, and leaves the others to the clients; without it all
share what there is, and the clients' own share of the processor is in the figures.
"""

import argparse
import asyncio
import json
import multiprocessing
import os
import random
import tempfile
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import aiohttp
import numpy as np
from tests.benchmarks._service import cpu_seconds, serving

from damperlab.service.client.client import Client

CLIENTS = 200
SECONDS = 40.0
LOOKING_SECONDS = 1.0
"""Mean time for which a client looks at a map."""
METRICS = ("amplitude_ratio", "relative_amplitude_ratio", "impacts_per_cycle", "response_class")
AXES = {
    "clearance_ratio": {"start": 1.0, "stop": 16.0, "num": 61},
    "friction_ratio": {"start": 0.0, "stop": 0.8, "num": 33},
}
DONE: dict[str, Any] = {
    "name": "looked at",
    "axes": {**AXES, "frequency_ratio": [0.95, 1.0, 1.05]},
    "steady": {"max_cycles": 60},
}
RUNNING = {
    "name": "running",
    "axes": {
        "clearance_ratio": {"start": 1.0, "stop": 16.0, "num": 301},
        "friction_ratio": {"start": 0.0, "stop": 0.8, "num": 161},
        "frequency_ratio": {"start": 0.9, "stop": 1.1, "num": 21},
    },
}
STIFFEST = {
    "clearance_ratio": 0.002,
    "friction_ratio": 0.2,
    "restitution": 0.95,
    "mass_ratio": 0.5,
    "frequency_ratio": 1.0,
    "contact": {"model": "compliant", "contact_time": 1e-5},
    "cycles": 100_000,
}
"""Hundreds of impacts a cycle on walls that are hardly there, for as many cycles as may be asked for: minutes of one core."""


@dataclass
class Seen:
    """What clients met.

    Parameters
    ----------
    seconds : list of float
        Latency of each map [s].
    alive : list of float
        Latency of each question how the service is [s].
    failed : Counter
        What was no answer, by its text.
    """

    seconds: list[float] = field(default_factory=list)
    alive: list[float] = field(default_factory=list)
    failed: Counter[str] = field(default_factory=Counter)


def addresses(study: str) -> list[str]:
    """Maps to look at: of each metric, at each frequency."""
    where = "x=clearance_ratio&y=friction_ratio"
    return [
        f"/api/v1/studies/{study}/resonance-map?metric={metric}&{where}&frequency_ratio={ratio}"
        for metric in METRICS
        for ratio in DONE["axes"]["frequency_ratio"]
    ]


async def look(url: str, study: str, clients: int, seconds: float) -> Seen:
    """Be so many clients for so long."""
    seen, ends = Seen(), time.perf_counter() + seconds
    maps = addresses(study)

    async def ask(session: aiohttp.ClientSession, path: str, into: list[float]) -> None:
        began = time.perf_counter()
        try:
            async with session.get(url + path) as answer:
                body = await answer.read()
                if answer.status == 200:
                    into.append(time.perf_counter() - began)
                else:
                    seen.failed[f"{answer.status} {body[:200]!r}"] += 1
        except (aiohttp.ClientError, TimeoutError) as error:
            seen.failed[repr(error)] += 1

    async def one(number: int) -> None:
        chance = random.Random(number)
        async with aiohttp.ClientSession() as session:
            await asyncio.sleep(chance.random() * LOOKING_SECONDS)
            while time.perf_counter() < ends:
                await ask(session, chance.choice(maps), seen.seconds)
                await asyncio.sleep(LOOKING_SECONDS * (0.5 + chance.random()))

    async def probe() -> None:
        async with aiohttp.ClientSession() as session:
            while time.perf_counter() < ends:
                await ask(session, "/health/live", seen.alive)
                await asyncio.sleep(0.1)

    await asyncio.gather(probe(), *(one(number) for number in range(clients)))
    return seen


def be_clients(cores: set[int] | None, pipe: Any, *what: Any) -> None:
    """Run `look` in this process, on these cores, and send what was seen."""
    if cores:
        os.sched_setaffinity(0, cores)
    began = time.process_time()
    seen = asyncio.run(look(*what))
    pipe.send((seen, time.process_time() - began))


async def stiffest(url: str, seconds: float) -> tuple[int, float]:
    """Ask for the stiffest point; the status of the answer and how long it took."""
    began = time.perf_counter()
    async with (
        aiohttp.ClientSession(timeout=aiohttp.ClientTimeout(seconds)) as session,
        session.post(f"{url}/api/v1/simulate", json=STIFFEST) as answer,
    ):
        await answer.read()
        return answer.status, time.perf_counter() - began


def measure(clients: int = CLIENTS, seconds: float = SECONDS, cores: int | None = None) -> dict[str, Any]:
    """Compute a study to look at, start another, and look."""
    all_cores = os.sched_getaffinity(0)
    theirs = None
    if cores:
        ours = set(sorted(all_cores)[:cores])
        theirs = all_cores - ours or None
        os.sched_setaffinity(0, ours)
    context = multiprocessing.get_context("spawn")
    with (
        tempfile.TemporaryDirectory() as made,
        serving(Path(made), None, cores or 2) as (url, pid),
        Client(url) as client,
    ):
        done = client.submit(DONE).wait()
        running = client.submit(RUNNING)
        while running.record.points_done == 0:
            time.sleep(0.5)
        before, began = cpu_seconds(pid), time.perf_counter()
        here, there = context.Pipe(duplex=False)
        process = context.Process(target=be_clients, args=(theirs, there, url, done.id, clients, seconds))
        process.start()
        with ThreadPoolExecutor(1) as beside:
            stiff = beside.submit(lambda: asyncio.run(stiffest(url, seconds + 120)))
            seen, own = here.recv()
            spent, elapsed = cpu_seconds(pid) - before, time.perf_counter() - began
            status, took = stiff.result()
        process.join()
        points = running.record.points_done
        running.cancel()
    figures: dict[str, Any] = {"clients": clients, "cores": cores or len(all_cores)}
    for name, values in (("maps", seen.seconds), ("alive", seen.alive)):
        quantiles = np.quantile(values, [0.5, 0.95, 0.99, 1.0]) * 1e3
        figures[name] = len(values)
        figures |= {
            f"{name}: {label} [ms]": float(at)
            for label, at in zip(("median", "p95", "p99", "longest"), quantiles, strict=True)
        }
    figures["failed"] = dict(seen.failed)
    figures["stiffest point: status"] = status
    figures["stiffest point: answered after [s]"] = took
    figures["CPU of the service, share of one core"] = spent / elapsed
    figures["CPU of the clients, share of one core"] = own / elapsed
    figures["points computed meanwhile"] = points
    return figures


def run() -> dict[str, Any]:
    """Measure as the module's text says."""
    return measure()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--clients", type=int, default=CLIENTS)
    parser.add_argument("--seconds", type=float, default=SECONDS)
    parser.add_argument("--cores", type=int, help="cores of the service; the others are the clients'")
    options = parser.parse_args()
    print(json.dumps(measure(options.clients, options.seconds, options.cores), indent=2))
