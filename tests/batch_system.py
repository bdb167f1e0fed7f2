"""A batch system that begins every job at once, on this machine, and kills it when its wall time is over.

It reads directives by rules of its own, and answers as Slurm does. A job has a number, is begun once for each place
of its array, and what it prints lies beside the script.
"""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pytest

LASTING: dict[str, Any] = {
    "name": "lasting",
    "damping_ratio": 0.0038,
    "axes": {
        "clearance_ratio": {"start": 10, "stop": 20, "num": 12},
        "friction_ratio": [0.2, 0.4, 0.6],
        "frequency_ratio": {"start": 0.98, "stop": 1.02, "num": 160},
        "restitution": 0.47,
        "mass_ratio": 0.1,
    },
}
"""A study of about sixteen core seconds."""


def put_commands(folder: Path) -> Path:
    """Make the commands of the system in a folder; give where jobs are kept."""
    kept = folder / "queue"
    kept.mkdir(parents=True)
    for name in ("sbatch", "scancel"):
        command = folder / name
        command.write_text(f'#!/bin/sh\nexec {sys.executable} {__file__} {kept} {name} "$@"\n')
        command.chmod(0o755)
    return kept


def make_queue(folder: Path, patch: "pytest.MonkeyPatch") -> Path:
    """Make a batch system of this machine for whatever a test starts; give where its jobs are kept."""
    kept = put_commands(folder / "bin")
    patch.setenv("PATH", f"{folder / 'bin'}:{os.environ['PATH']}")
    patch.setenv("PYTHONPATH", str(Path(__file__).parents[1]))
    patch.setenv("DAMPERLAB_CLUSTER_HOST", "127.0.0.1")
    return kept


def running(kept: Path) -> list[int]:
    """Process ids of jobs that run."""
    pids = (int(line) for file in kept.glob("*.pids") for line in file.read_text().split())
    return [pid for pid in pids if Path(f"/proc/{pid}").exists()]


def wait_until_ended(kept: Path, seconds: float = 3000.0) -> None:
    """Wait until no job runs: what is taken back may take a moment."""
    deadline = time.monotonic() + seconds
    while running(kept):
        assert time.monotonic() < deadline
        time.sleep(0.2)


def _submit(kept: Path, text: str) -> None:
    array = re.search(r"--array=1-(\d+)", text)
    wall = re.search(r"--time=(\d+):(\d+):(\d+)", text)
    assert array is not None
    assert wall is not None
    seconds = 3600 * int(wall[1]) + 60 * int(wall[2]) + int(wall[3])
    number = len(list(kept.glob("*.sh"))) + 1
    script = kept / f"{number}.sh"
    script.write_text(text)
    pids = []
    for task in range(1, int(array[1]) + 1):
        with (kept / f"{number}-{task}.log").open("wb") as log:
            job = subprocess.Popen(
                ["timeout", "--signal=KILL", str(seconds), "sh", script],
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                env={**os.environ, "SLURM_ARRAY_TASK_ID": str(task)},
                start_new_session=True,
            )
        pids.append(str(job.pid))
    (kept / f"{number}.pids").write_text("\n".join(pids))
    print(f"{number};main")


def _cancel(kept: Path, job: str) -> None:
    for pid in (kept / f"{job}.pids").read_text().split():
        try:
            # `timeout` hands it on to what it runs
            os.kill(int(pid), signal.SIGTERM)
        except ProcessLookupError:
            continue


if __name__ == "__main__":
    folder, name, *rest = sys.argv[1:]
    if name == "scancel":
        _cancel(Path(folder), rest[0])
    else:
        _submit(Path(folder), sys.stdin.read())
