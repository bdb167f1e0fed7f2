"""What a campaign did and found, as a table, and the folder that stays where something was wrong."""

import shutil
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol


def spelled(counts: Mapping[str, int]) -> str:
    """Give counts by name in one line, their sum first."""
    parts = ", ".join(f"{count} {name}" for name, count in sorted(counts.items()))
    return f"{sum(counts.values())}: {parts}"


def markdown(rows: Iterable[tuple[str, str]]) -> str:
    """Give rows of a name and a value as a Markdown table."""
    return "\n".join(["| | |", "|---|---|", *(f"| {name} | {value} |" for name, value in rows)])


class Judged(Protocol):
    """A report that says whether it is good."""

    @property
    def good(self) -> bool:
        """Whether everything held, and there was something to hold."""

    def table(self) -> str:
        """Give the report as a Markdown table."""


@contextmanager
def traces(name: str) -> Iterator[tuple[Path, list[Judged]]]:
    """Give a folder, which stays and is named unless a good report is put into the list beside it."""
    folder = Path(tempfile.mkdtemp(prefix=f"damperlab-{name}-"))
    reports: list[Judged] = []
    try:
        yield folder, reports
    finally:
        if reports and reports[-1].good:
            shutil.rmtree(folder)
        else:
            print(f"data and logs are left in {folder}", file=sys.stderr)


@dataclass
class Report:
    """Counts of one campaign; those of `FAULTS` must be zero."""

    backend: str
    seed: int
    kills: dict[str, int] = field(default_factory=dict)
    studies: int = 0
    blocks: int = 0
    attempts: int = 0
    seconds: float = 0.0
    looks: int = 0
    unavailable: int = 0
    strays_before_gc: int = 0
    rounds: int = 0
    left_out: int = 0

    marks_lost: int = 0
    blocks_run_twice: int = 0
    studies_lost: int = 0
    studies_not_done: int = 0
    counts_wrong: int = 0
    unequal_variables: int = 0
    damaged_blocks: int = 0
    strays_after_gc: int = 0
    deeds_undone: int = 0
    backups_unlike: int = 0
    false_alarms: int = 0
    defects: int = 0
    """Answers with status 500."""

    @property
    def good(self) -> bool:
        """Whether everything held, and there was something to hold."""
        return self.blocks > 0 and not any(getattr(self, name) for name in FAULTS)

    def table(self) -> str:
        """Give the report as a Markdown table."""
        rows = [
            ("catalogue and cubes", f"{self.backend}, seed {self.seed}"),
            ("faults", spelled(self.kills)),
            ("studies ended, blocks done", f"{self.studies}, {self.blocks}"),
            ("attempts at blocks, where they are noted", str(self.attempts)),
            ("looks at the catalogue", str(self.looks)),
            ("answers 503 or none", str(self.unavailable)),
            ("rounds of backup, gc and scrub", str(self.rounds)),
            ("workers left out, by name", str(self.left_out)),
            ("files of killed attempts, swept", str(self.strays_before_gc)),
            *((text, str(getattr(self, name))) for name, text in FAULTS.items()),
            ("time", f"{self.seconds:.0f} s"),
            ("verdict", "nothing was lost" if self.good else "**FAILED**"),
        ]
        return markdown(rows)


FAULTS = {
    "marks_lost": "acknowledged blocks lost",
    "blocks_run_twice": "acknowledged blocks run again",
    "studies_lost": "acknowledged studies lost",
    "studies_not_done": "studies not done",
    "counts_wrong": "records whose sums are wrong",
    "unequal_variables": "variables unlike the undisturbed ones",
    "damaged_blocks": "blocks whose checksum does not hold",
    "strays_after_gc": "stray files left",
    "deeds_undone": "recomputed, retried or deleted studies unlike what was asked",
    "backups_unlike": "studies unlike in their backup",
    "false_alarms": "things called damaged that were not, and tracebacks",
    "defects": "answers 500",
}
"""What must not happen, in words."""
