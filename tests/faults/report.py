"""What a campaign did and found, as JSON and as a table."""

from dataclasses import asdict, dataclass, field
from typing import Any


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

    def document(self) -> dict[str, Any]:
        """Give the report as JSON-able values."""
        return {**asdict(self), "good": self.good}

    def table(self) -> str:
        """Give the report as a Markdown table."""
        kills = ", ".join(f"{count} {name}" for name, count in sorted(self.kills.items()))
        rows = [
            ("catalogue and cubes", f"{self.backend}, seed {self.seed}"),
            ("faults", f"{sum(self.kills.values())}: {kills}"),
            ("studies ended, blocks done", f"{self.studies}, {self.blocks}"),
            *(
                [
                    (
                        "attempts at blocks",
                        f"{self.attempts}, of which {self.attempts - self.blocks} were cut short",
                    )
                ]
                if self.attempts
                else []
            ),
            ("looks at the catalogue", str(self.looks)),
            ("answers 503 or none", str(self.unavailable)),
            *([("rounds of backup, gc and scrub", str(self.rounds))] if self.rounds else []),
            *([("workers left out, by name", str(self.left_out))] if self.left_out else []),
            ("files of killed attempts, swept", str(self.strays_before_gc)),
            *((text, str(getattr(self, name))) for name, text in FAULTS.items()),
            ("time", f"{self.seconds:.0f} s"),
            ("verdict", "nothing was lost" if self.good else "**FAILED**"),
        ]
        return "\n".join(
            ["| | |", "|---|---|", *(f"| {name} | {value} |" for name, value in rows)],
        )


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
