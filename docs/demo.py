"""The picture of the README, made by the commands of `make demo`: `python -m docs.demo`."""

import re
import tempfile
from collections.abc import Iterator
from pathlib import Path

from docs.computed import record
from docs.console import ROOT, run

PICTURE = "docs/figure-11.png"


def commands() -> Iterator[str]:
    """Give the commands of the target `demo`, as they run in a folder of their own."""
    recipe = re.search(r"^demo:.*\n((?:\t.*\n)+)", (ROOT / "Makefile").read_text(), re.MULTILINE)
    assert recipe is not None
    for line in recipe[1].splitlines():
        yield line.strip().replace("$(BIN)/", "").replace("$(DEMO)", "demo")


def make(folder: Path) -> Path:
    """Run the demonstration in a folder, and give the picture that it draws."""
    for command in commands():
        run(command, folder)
    return folder / "demo" / "figure-11.png"


def main() -> None:
    """Draw the picture again."""
    with tempfile.TemporaryDirectory() as folder:
        (ROOT / PICTURE).write_bytes(make(Path(folder)).read_bytes())
    record([PICTURE])
    print(PICTURE)


if __name__ == "__main__":
    main()
