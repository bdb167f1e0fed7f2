"""The command `damperlab`, in this process or in one of its own."""

import io
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any
from unittest.mock import patch

from tests.ready import ready
from typer.main import get_command

from damperlab.service.cli.main import _run, app

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


def every_command(group: Any = None, before: str = "") -> Iterator[tuple[str, Any]]:
    """Give each command, and those of groups, by what is written for it."""
    for name, each in (group or get_command(app)).commands.items():
        yield before + name, each
        if hasattr(each, "commands"):
            yield from every_command(each, f"{before}{name} ")


def command(*arguments: str | Path) -> list[str]:
    return [sys.executable, "-m", COMMAND, *map(str, arguments)]


def environment() -> dict[str, str]:
    # Wide enough that no help text or table is broken into lines.
    return {**os.environ, "COLUMNS": "200", "TERM": "dumb"}


def run(*arguments: str | Path, status: int | None = 0) -> subprocess.CompletedProcess[str]:
    """Run a command in this process, which has loaded everything, and collect what it prints."""
    words = list(map(str, arguments))
    with (
        redirect_stdout(io.StringIO()) as out,
        redirect_stderr(io.StringIO()) as err,
        patch.dict(os.environ, environment()),
    ):
        ended = _run(words)
    told = subprocess.CompletedProcess(words, ended, out.getvalue(), err.getvalue())
    assert status in (None, ended), f"{arguments}: {ended}\n{told.stdout}\n{told.stderr}"
    return told


def run_apart(*arguments: str | Path, seconds: float = END_SECONDS) -> subprocess.CompletedProcess[str]:
    """Run a command in a process of its own, to its good end."""
    ended = ready().run(COMMAND, list(map(str, arguments)), environment(), seconds)
    assert ended.returncode == 0, f"{arguments}: {ended.returncode}\n{ended.stdout}\n{ended.stderr}"
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
