"""A second solver: a copy of the sources with one line changed, run as a program of its own."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]

SCALE = 1.0 + 2.0**-40
"""By how much the other solver's amplitudes of linear points are larger."""


class OtherSolver:
    """The command line of a copy of the project whose closed form is scaled by `SCALE`.

    Linear points need no kernel, so nothing is compiled for it.

    Parameters
    ----------
    folder : Path
        Where the copy is made.
    environment : str
        Added to this process's own.
    """

    def __init__(self, folder: Path, **environment: str) -> None:
        for name in ("src", "studies", "worker", "service"):
            shutil.copytree(
                ROOT / name, folder / name, symlinks=True, ignore=shutil.ignore_patterns("__pycache__")
            )
        block = folder / "worker" / "block.py"
        text = block.read_text()
        line = "            values[name][linear] = column\n"
        assert text.count(line) == 1
        changed = (
            f"            values[name][linear] = column * ({SCALE!r} if name == 'amplitude_ratio' else 1.0)\n"
        )
        block.write_text(text.replace(line, changed))
        self._environment = {**os.environ, **environment, "PYTHONPATH": str(folder / "src")}

    def run(self, *arguments: str, allowed: tuple[int, ...] = (0,)) -> dict[str, Any]:
        """Run `damperlab` with arguments and ``--json``; give what it prints."""
        command = [sys.executable, "-m", "damperlab.service.cli.main", *arguments, "--json"]
        done = subprocess.run(
            command, check=False, capture_output=True, text=True, env=self._environment, cwd="/"
        )
        assert done.returncode in allowed, (done.returncode, done.stdout, done.stderr)
        document: dict[str, Any] = json.loads(done.stdout) if done.stdout else {"message": done.stderr}
        return document
