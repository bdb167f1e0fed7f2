"""Commands that the documentation shows, run again: `python -m docs.console [PAGE …]` writes what they print into the pages.

A block marked ```console holds commands behind `$ ` and below each what it prints. A block with a title, as in
```yaml title="damper.yaml", is a file that the commands find. `…` stands for what is chance: a time, a duration, or for
lines left out.
"""

import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from docs.computed import record

ROOT = Path(__file__).parents[1]
FIGURES = ROOT / "docs" / "figures"
BLOCK = re.compile(r"^```console\n(.*?)^```$", re.MULTILINE | re.DOTALL)
TITLED = re.compile(r'^```\w+ title="([^"]+)"\n(.*?)^```$', re.MULTILINE | re.DOTALL)
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w.]*\w)")

CHANCE = (
    (re.compile(r"\d{4}-\d\d-\d\d \d\d:\d\d:\d\d(?: UTC)?"), "…"),
    (re.compile(r"(?<![\w.])\d+(?:\.\d+)? (s|min|h)\b"), r"… \1"),
    (re.compile(r"^(run_time +)\S+ +", re.MULTILINE), r"\1…  "),
    (re.compile(r"\b\d+ (sets of parameters|histories computed)\b"), r"… \1"),
)
"""What differs from run to run, or from processor to processor: where a fit ends its search, rounding may decide."""

SAME = 2e-5
"""Relative: two roundings to six digits."""
ROUNDING = 1e-9
"""Absolute: distances from periodicity and balances of energy are rounding."""
IRREGULAR = 0.12
"""Relative, where responses are chaotic: four times √2 standard errors of 2 %, to which a mean is known on any processor."""
UNSURE = 0.05
"""Absolute, where responses are chaotic: how far stated errors move, which are estimates themselves."""
HOW = "If that is right, `make docs-figures` renews all that the documentation shows, `python -m docs.console PAGE` one page."
ELSEWHERE = 0.05
"""Share of the values in a map that may lie further off: where two responses are possible, rounding may decide between them."""


@dataclass(frozen=True)
class Shown:
    """A command of a page and what the page says that it prints."""

    command: str
    printed: str


def shown_in(text: str) -> Iterator[Shown]:
    """Find the commands of a page in order."""
    for block in BLOCK.finditer(text):
        for part in re.split(r"^\$ ", block[1], flags=re.MULTILINE)[1:]:
            command, _, printed = part.partition("\n")
            while command.endswith("\\"):
                more, _, printed = printed.partition("\n")
                command = f"{command}\n{more}"
            yield Shown(command, printed)


def put_files(text: str, folder: Path) -> None:
    """Write the titled blocks of a page as the files that its commands read."""
    for block in TITLED.finditer(text):
        (folder / block[1]).write_text(block[2])


def run(command: str, folder: Path) -> str:
    """Run a command as a reader would, in a folder of its own, and give what it prints on standard output.

    Raises
    ------
    RuntimeError
        Where it fails.
    """
    environment = os.environ | {"DAMPERLAB_DATA_DIR": str(folder / "data"), "COLUMNS": "110", "NO_COLOR": "1"}
    environment["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    command = command.replace(".venv/bin/damperlab", "damperlab")
    done = subprocess.run(
        ["/bin/bash", "-c", command], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise RuntimeError(f"{command}: exit status {done.returncode}\n{done.stderr[-2000:]}")
    return "\n".join(line.rstrip() for line in done.stdout.splitlines()) + "\n" * bool(done.stdout)


def difference(shown: Shown, found: str, exact: bool = False) -> str:
    """Compare what a page shows with what was printed; "" where nothing but chance differs.

    Parameters
    ----------
    shown : Shown
        `…` stands for anything.
    found : str
        What the command prints now.
    exact : bool
        Whether the page was computed by this solver on such a machine (`docs.computed.is_of_here`): numbers are then the
        same, digit by digit. Else they agree as far as two processors do.
    """
    mapped = shown.command.split()[1:2] == ["map"]
    irregular = mapped or re.search(r"\b(chaotic|modulated|changes the answer)\b", found, re.IGNORECASE)
    absolute, relative = (UNSURE, IRREGULAR) if irregular else (ROUNDING, SAME)
    numbers, match = _matched(shown, found)
    if match is None:
        return f"$ {shown.command}\n--- the page shows\n{shown.printed}--- it prints\n{found}{HOW}\n"
    pairs = zip(numbers, match.groups(), strict=True)
    if exact:
        far = [f"{told} is {now}" for told, now in pairs if now != told]
    else:
        far = [
            f"{told} is {now}"
            for told, now in pairs
            if abs(float(now) - float(told)) > absolute + relative * abs(float(told))
        ]
    if len(far) <= (ELSEWHERE * len(numbers) if mapped and not exact else 0):
        return ""
    return f"$ {shown.command}\n" + "; ".join(far) + f"\n{HOW}\n"


def _matched(shown: Shown, found: str) -> tuple[list[str], "re.Match[str] | None"]:
    """Find the numbers that a page shows, and where what was printed has those in their places."""
    pattern, numbers = "", []
    for line in shown.printed.splitlines():
        pattern += r"(?:.*\n)*?" if line.strip() == "…" else _pattern(line, numbers) + r"\s*\n"
    return numbers, re.fullmatch(pattern, found)


def _pattern(line: str, numbers: list[str]) -> str:
    """Write a line as an expression: any number where one stands, anything for `…`, any white space for some."""
    parts, end = [], 0
    for found in NUMBER.finditer(line):
        parts += [_words(line[end : found.start()]), r"([-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?)"]
        numbers.append(found[0])
        end = found.end()
    return "".join([*parts, _words(line[end:].rstrip())])


def _words(text: str) -> str:
    pieces = (r"\s+".join(map(re.escape, re.split(r"\s+", piece))) for piece in text.split("…"))
    return ".*?".join(pieces)


def renewed(text: str, folder: Path) -> str:
    """Give a page with what its commands print now; `…` stays where it stands as long as the words around it do."""
    put_files(text, folder)

    def block(found: re.Match[str]) -> str:
        parts = []
        for shown in shown_in(found[0]):
            print("$", shown.command, flush=True)
            parts.append(f"$ {shown.command}\n{shown_again(shown, run(shown.command, folder))}")
        return "```console\n" + "".join(parts) + "```"

    return BLOCK.sub(block, text)


def shown_again(shown: Shown, found: str) -> str:
    """Give what a page is to show of what was printed now: the same lines left out, and other numbers where they are others."""
    if not difference(shown, found, exact=True):
        return shown.printed
    _, match = _matched(shown, found)
    if match is None or "…" not in shown.printed:
        for what, instead in CHANCE:
            found = what.sub(instead, found)
        return found
    now = iter(match.groups())
    return NUMBER.sub(lambda _: next(now), shown.printed)


def pages() -> list[str]:
    """Name the pages that show commands with what they print."""
    every = (ROOT / "README.md", *(ROOT / "docs").rglob("*.md"))
    return sorted(path.relative_to(ROOT).as_posix() for path in every if "```console" in path.read_text())


def figures_of(page: Path, folder: Path) -> Iterator[tuple[Path, Path]]:
    """Pair each figure that commands of a page wrote with its place in the documentation, `figures/PAGE-NAME`."""
    for made in sorted(folder.glob("*.png")):
        yield made, FIGURES / f"{page.stem.lower()}-{made.name}"


def main() -> None:
    """Renew the pages that are named, or all."""
    for name in sys.argv[1:] or pages():
        page = ROOT / name
        print(name, flush=True)
        with tempfile.TemporaryDirectory() as folder:
            page.write_text(renewed(page.read_text(), Path(folder)))
            for made, kept in figures_of(page, Path(folder)):
                kept.write_bytes(made.read_bytes())
        record([page.resolve().relative_to(ROOT).as_posix()])


if __name__ == "__main__":
    main()
