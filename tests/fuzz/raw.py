"""Malformed heads and bodies over real sockets, beside somebody who asks for /health/live: ``python -m tests.fuzz.raw``.

Every request is answered, none by a failure; the longest wait of /health/live is printed, and how busy the machine was.
"""

import argparse
import os
import tempfile
import threading
import time
from pathlib import Path

import httpx
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st
from tests.service.conftest import start_service
from tests.service.security.raw import ask, host_of
from tests.service.security.test_malformed import BROKEN, STRUCTURED, judge


def main() -> None:
    """Send the cases, and print what was seen."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    waits: list[float] = []
    over = threading.Event()
    sent = 0

    def watch(url: str) -> None:
        with httpx.Client(base_url=url, timeout=60) as client:
            while not over.wait(0.1):
                began = time.perf_counter()
                client.get("/health/live").raise_for_status()
                waits.append(time.perf_counter() - began)

    with tempfile.TemporaryDirectory() as folder:
        running = start_service(Path(folder) / "data", Path(folder) / "log")
        for path in ("/", "/openapi.json", "/api/v1/records"):
            httpx.get(f"{running.url}{path}", timeout=60).raise_for_status()
        watcher = threading.Thread(target=watch, args=(running.url,))
        watcher.start()

        @seed(asked.seed)
        @settings(
            max_examples=asked.cases,
            deadline=None,
            database=None,
            phases=(Phase.generate,),
            suppress_health_check=list(HealthCheck),
        )
        @given(request=STRUCTURED | BROKEN | st.binary(min_size=1, max_size=80))
        def send(request: bytes) -> None:
            nonlocal sent
            request = request.replace(b"Host: localhost", b"Host: " + host_of(running.url))
            judge(request, ask(running.url, request))
            sent += 1

        try:
            send()
        finally:
            over.set()
            watcher.join()
            status = running.stop()
            failures = (Path(folder) / "log").read_text().count("Traceback")
    waits.sort()
    print(
        f"{sent} requests answered, {failures} defects logged, the service ended with {status}; /health/live asked "
        f"{len(waits)} times: median {1e3 * waits[len(waits) // 2]:.0f} ms, 99 % {1e3 * waits[int(0.99 * len(waits))]:.0f} ms, "
        f"longest {1e3 * waits[-1]:.0f} ms; load {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors"
    )


if __name__ == "__main__":
    main()
