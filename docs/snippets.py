"""Python that the pages show, run against a service: `python -m docs.snippets` writes what it prints into the pages.

Blocks of a page are one program, run from top to bottom in a folder with the files of the page. A block in ```text right
after one of Python holds what that prints; where there is none, the page does not show it.
"""

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from docs.computed import record
from docs.console import ROOT, Shown, put_files, shown_again
from docs.running import service

from damperlab import Client

SNIPPET = re.compile(
    r"^```python\n(?P<code>.*?)^```\n(?:\n```text\n(?P<printed>.*?)^```\n)?", re.MULTILINE | re.DOTALL
)
"""Without a title: one with a title is a file, which a command of its page runs."""
AT_HOME = re.compile(r'Client\((?:"http://127.0.0.1:8000")?\)')
"""A client of the service at its usual address, which may be taken."""
BUDGET_POINTS = 3000
"""Of a design, in place of its default: whether the lines run does not depend on how far it searches."""
MACHINE: dict[str, Any] = {
    "name": "machine",
    "axes": {
        "clearance_ratio": [5.0, 5.5, 6.0],
        "friction_ratio": [0.5, 0.55, 0.6, 0.65],
        "frequency_ratio": 1.0,
    },
    "steady": {"tolerance": 0.1},
}
"""A study by the name of the tutorial's, small, and quick to compute."""
END = "--- end of a block ---"
PATIENCE_SECONDS = 1800


def pages() -> list[str]:
    """Name the pages that show Python."""
    every = (ROOT / "README.md", *(ROOT / "docs").rglob("*.md"))
    return sorted(path.relative_to(ROOT).as_posix() for path in every if SNIPPET.search(path.read_text()))


def key_of(page: str) -> str:
    """Name what a page shows of its Python, apart from what its commands print, in `docs.computed`."""
    return f"{page}: python"


def put_what_a_reader_has(text: str, folder: Path, url: str) -> None:
    """Write the files of a page and a record of the reader's own, and compute the study that pages speak of."""
    put_files(text, folder)
    for file in folder.glob("*.yaml"):
        if "\nchoose:" in file.read_text():  # a specification
            file.write_text(f"{file.read_text()}budget_points: {BUDGET_POINTS}\n")
    time = 0.01 * np.arange(500)
    record = np.column_stack([time, 0.1 * np.sin(2.0 * np.pi * time) * np.exp(-time)])
    np.savetxt(folder / "my-earthquake.csv", record, "%.6f", ",", header="time (s),acceleration", comments="")
    with Client(url) as client:
        client.submit(MACHINE).wait(progress=False)


def run_snippets(text: str, url: str, folder: Path) -> list[tuple[str, str | None]]:
    """Run the Python of a page as a program of its own.

    Parameters
    ----------
    text : str
        The page.
    url : str
        Of the service that its clients find.
    folder : path
        Where it runs.

    Returns
    -------
    list of (str, str or None)
        Of each block what it printed, and what the page shows of that.

    Raises
    ------
    RuntimeError
        Where it fails.
    """
    blocks = list(SNIPPET.finditer(text))
    program = f'print("{END}")\n'.join(AT_HOME.sub(f'Client("{url}")', block["code"]) for block in blocks)
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=folder, env=os.environ | {"MPLBACKEND": "agg"},
        capture_output=True, text=True, check=False, timeout=PATIENCE_SECONDS,
    )  # fmt: skip
    if done.returncode:
        raise RuntimeError(done.stderr[-3000:])
    return list(zip(done.stdout.split(f"{END}\n"), (block["printed"] for block in blocks), strict=True))


def renewed(text: str, url: str, folder: Path) -> str:
    """Give a page with what its Python prints now; what differs by chance alone stays as it is."""
    printed = (now for now, _ in run_snippets(text, url, folder))

    def block(found: re.Match[str]) -> str:
        now, shown = next(printed), found["printed"]
        if shown is None:
            return found[0]
        start, end = (place - found.start() for place in found.span("printed"))
        return found[0][:start] + shown_again(Shown("python", shown), now) + found[0][end:]

    return SNIPPET.sub(block, text)


def main() -> None:
    """Renew every page with Python that shows what it prints."""
    with service() as url:
        for name in pages():
            page = ROOT / name
            text = page.read_text()
            if not any(found["printed"] is not None for found in SNIPPET.finditer(text)):
                continue
            print(name, flush=True)
            with tempfile.TemporaryDirectory() as folder:
                put_what_a_reader_has(text, Path(folder), url)
                page.write_text(renewed(text, url, Path(folder)))
            record([key_of(name)])


if __name__ == "__main__":
    main()
