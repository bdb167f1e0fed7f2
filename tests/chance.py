"""Tests run again and again beside busy processes: what fails once in many runs, or where nothing is in time, fails here.

A process that is busy takes turns with the tests on the cores, so that whatever waits for a clock in place of an event waits
too short some time.
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

BUSY = "import os\nparent = os.getppid()\nwhile os.getppid() == parent:\n    sum(range(1_000_000))"
"""Ends with whoever started it, however that ends."""
FAILED = re.compile(r"^(?:FAILED|ERROR) (\S+)", re.MULTILINE)


@contextmanager
def busy(count: int) -> Iterator[None]:
    """Keep so many processes busy meanwhile."""
    processes = [subprocess.Popen([sys.executable, "-c", BUSY]) for _ in range(count)]
    try:
        yield
    finally:
        for process in processes:
            process.kill()
            process.wait()


def run_once(arguments: list[str], log: Path) -> list[str]:
    """Run tests, with what they print in a file; give the names of those that fail."""
    with log.open("w") as out:
        command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *arguments]
        status = subprocess.run(command, stdout=out, stderr=subprocess.STDOUT, check=False).returncode
    return FAILED.findall(log.read_text()) or ([f"pytest ended with status {status}"] if status else [])


def main() -> int:
    """Run tests so many times, and print which failed how often."""
    parser = argparse.ArgumentParser(prog="python -m tests.chance", description=__doc__)
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--busy", type=int, default=8, help="processes that keep the cores busy meanwhile")
    parser.add_argument(
        "--logs", type=Path, help="where what each run prints is kept; a new folder by default"
    )
    asked, arguments = parser.parse_known_args()
    logs = asked.logs or Path(tempfile.mkdtemp(prefix="chance-"))
    logs.mkdir(parents=True, exist_ok=True)
    failures: Counter[str] = Counter()
    began = time.monotonic()
    with busy(asked.busy):
        for number in range(1, asked.runs + 1):
            log = logs / f"run-{number}.txt"
            failed = run_once(arguments, log)
            failures.update(failed)
            last = log.read_text().rstrip().rpartition("\n")[2].strip("= ")
            print(f"{time.monotonic() - began:6.0f} s  run {number} of {asked.runs}: {last}", flush=True)
            for name in failed:
                print(f"          {name}, see {log}", flush=True)
    for name, count in failures.most_common():
        print(f"failed {count} times: {name}")
    print(f"{asked.runs} runs beside {asked.busy} busy processes on {os.cpu_count()} cores")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
