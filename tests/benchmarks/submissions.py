"""Ten thousand studies of one point handed in by sixteen clients: who is answered what, and what each costs.

The clients are threads with a `Client` of their own: half of the studies come in lists (`Client.submit_all`), half alone
(`Client.submit`), each way measured by itself. CPU is that of the service's process, user and system, from the first
request to the last answer; with nobody to compute (a scheduler that has no workers) it is that of submitting alone.
"""

import tempfile
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from distributed import LocalCluster
from tests.benchmarks._service import cpu_seconds, serving

from damperlab.service.client.client import Client
from damperlab.service.client.faults import ClientFault

STUDIES = 10_000
CLIENTS = 16
A_LIST = 200


def study(number: int) -> dict[str, Any]:
    """Give one point; no two numbers have the same."""
    at = {
        "clearance_ratio": 2.0 + 1e-3 * (number % 1000),
        "friction_ratio": 0.1 + 1e-3 * (number // 1000),
        "restitution": 0.47,
        "mass_ratio": 0.1,
        "frequency_ratio": 1.0,
    }
    return {"name": f"point {number}", "damping_ratio": 0.0038, "axes": at, "steady": {"max_cycles": 100}}


def submit(url: str, first: int, last: int, clients: int, a_list: int) -> tuple[Counter[str], float]:
    """Hand in the studies of some numbers, so many at once; what became of them, and for how long a client waited at most."""

    def one(place: int) -> tuple[Counter[str], float]:
        outcomes: Counter[str] = Counter()
        longest = 0.0
        mine = list(range(first + place, last, clients))
        with Client(url) as client:
            for start in range(0, len(mine), a_list):
                some = [study(number) for number in mine[start : start + a_list]]
                began = time.monotonic()
                try:
                    if a_list == 1:
                        client.submit(some[0])
                    else:
                        client.submit_all(some)
                    outcomes["stored"] += len(some)
                except ClientFault as error:
                    outcomes[f"{type(error).__name__}: {error}"[:120]] += len(some)
                longest = max(longest, time.monotonic() - began)
        return outcomes, longest

    with ThreadPoolExecutor(clients) as pool:
        ends = list(pool.map(one, range(clients)))
    return sum((found for found, _ in ends), Counter()), max(longest for _, longest in ends)


def run(studies: int = STUDIES, clients: int = CLIENTS) -> dict[str, Any]:
    """Hand in, and count."""
    figures: dict[str, Any] = {"studies": studies, "clients": clients}
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        half = studies // 2
        with (
            LocalCluster(n_workers=0, dashboard_address=None, host="127.0.0.1") as nobody,
            serving(folder, nobody.scheduler_address) as (url, pid),
        ):
            for label, a_list, first, last in (("lists", A_LIST, 0, half), ("alone", 1, half, studies)):
                before, began = cpu_seconds(pid), time.monotonic()
                outcomes, longest = submit(url, first, last, clients, a_list)
                took = cpu_seconds(pid) - before
                figures[f"{label}: stored"] = outcomes.pop("stored", 0)
                figures[f"{label}: refused"] = dict(outcomes)
                figures[f"{label}: all of them [s]"] = time.monotonic() - began
                figures[f"{label}: longest request [s]"] = longest
                figures[f"{label}: CPU of the service a study [ms]"] = 1e3 * took / (last - first)
    return figures
