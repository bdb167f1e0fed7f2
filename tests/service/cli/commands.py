"""The command `damperlab` in a process of its own."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from tests.ready import ready

COMMAND = "damperlab.service.cli.main"

END_SECONDS = 3600.0
"""Far more than any command here takes: a hang fails, a loaded machine does not."""

LINEAR: dict[str, Any] = {
    "name": "bare structure",
    "particle": False,
    "damping_ratio": 0.0038,
    "axes": {"friction_ratio": [0, 2], "frequency_ratio": {"start": 0.5, "stop": 1.5, "num": 11}},
    "steady": {"max_cycles": 50},
}
"""Closed form without friction, locked with γ_F = 2 ≥ r² for r ≤ 1.4: milliseconds."""


def command(*arguments: str | Path) -> list[str]:
    return [sys.executable, "-m", COMMAND, *map(str, arguments)]


def environment() -> dict[str, str]:
    # Wide enough that no help text or table is broken into lines.
    return {**os.environ, "COLUMNS": "200", "TERM": "dumb"}


def run(
    *arguments: str | Path, status: int | None = 0, seconds: float = END_SECONDS
) -> subprocess.CompletedProcess[str]:
    ended = ready().run(COMMAND, list(map(str, arguments)), environment(), seconds)
    assert status in (None, ended.returncode), (
        f"{arguments}: {ended.returncode}\n{ended.stdout}\n{ended.stderr}"
    )
    return ended


def start(*arguments: str | Path) -> subprocess.Popen[str]:
    """Start a command in a process group of its own, as a terminal does, so that a signal can go to the whole group."""
    return subprocess.Popen(
        command(*arguments),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        stdin=subprocess.DEVNULL,
        text=True,
        env=environment(),
        start_new_session=True,
    )
