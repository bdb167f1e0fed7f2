"""The short form of what a damaged store answers over HTTP; `make faults` runs the long one, and by commands."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.mark.night
def test_a_service_refuses_what_is_damaged_with_a_problem_document() -> None:
    # one bit of an axis, and one of a block's values; in a process of its own, which forks
    command = [sys.executable, "-m", "tests.faults.doors"]
    command += ["--commands", "0", "--http", "2", "--no-losses", "--seed", "24"]
    ran = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=1800, check=False)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert [line.split() for line in ran.stdout.splitlines()[-2:]] == [
        ["axis", "refused", "1"],
        ["block", "refused", "1"],
    ]
