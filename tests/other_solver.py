"""Other sources: a copy of the package with one line changed; and a second solver, which is such a copy."""

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


def altered(folder: Path, file: str, before: str, after: str) -> Path:
    """Copy the package into a folder, and change one line of one file there; the folder, from which it is imported."""
    ignored = shutil.ignore_patterns("__pycache__", "kernels")
    shutil.copytree(ROOT / "src" / "damperlab", folder / "damperlab", ignore=ignored)
    source = folder / "damperlab" / file
    text = source.read_text()
    assert text.count(before) == 1
    source.write_text(text.replace(before, after))
    return folder


class OtherSolver:
    """The command line of a copy of the package whose closed form is scaled by `SCALE`.

    Linear points need no kernel, so nothing is compiled for it.

    Parameters
    ----------
    folder : Path
        Where the copy is made.
    environment : str
        Added to this process's own.
    """

    def __init__(self, folder: Path, **environment: str) -> None:
        line = "values[name][linear] = column\n"
        scaled = f"values[name][linear] = column * ({SCALE!r} if name == 'amplitude_ratio' else 1.0)\n"
        altered(folder, "worker/block.py", line, scaled)
        self._environment = {**os.environ, **environment, "PYTHONPATH": str(folder)}

    def run(self, *arguments: str, allowed: tuple[int, ...] = (0,)) -> dict[str, Any]:
        """Run `damperlab` with arguments and ``--json``; give what it prints."""
        command = [sys.executable, "-m", "damperlab.service.cli.main", *arguments, "--json"]
        done = subprocess.run(
            command, check=False, capture_output=True, text=True, env=self._environment, cwd="/"
        )
        assert done.returncode in allowed, (done.returncode, done.stdout, done.stderr)
        document: dict[str, Any] = json.loads(done.stdout) if done.stdout else {"message": done.stderr}
        return document
