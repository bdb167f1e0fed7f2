"""On which solver and machine what a page shows was computed: there, and nowhere else, it is the same to the last digit."""

import json
from collections.abc import Iterable
from pathlib import Path

from damperlab.worker.provenance import computing

RECORD = Path(__file__).parent / "computed.json"
KEPT = ("identity", "solver", "target", "libc")
"""`identity` decides; the others say the same for people."""


def is_of_here(page: str) -> bool:
    """Whether a page was computed by this solver on a machine that computes the same bits.

    Parameters
    ----------
    page : str
        Its path from the root of the repository.
    """
    found = _recorded().get(page)
    return found is not None and found["identity"] == computing()["identity"]


def record(pages: Iterable[str]) -> None:
    """Note that pages have just been computed here."""
    facts = computing()
    recorded = _recorded() | {key: {name: facts[name] for name in KEPT} for key in pages}
    RECORD.write_text(json.dumps(recorded, indent=1, sort_keys=True) + "\n")


def _recorded() -> dict[str, dict[str, str]]:
    if not RECORD.exists():
        return {}
    recorded: dict[str, dict[str, str]] = json.loads(RECORD.read_text())
    return recorded
