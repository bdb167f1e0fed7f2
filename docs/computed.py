"""By which kernels and on what machine a page was computed: there, and nowhere else, it is the same to the last digit."""

import json
from collections.abc import Iterable
from importlib.metadata import version
from pathlib import Path

from damperlab.worker.provenance import computing

RECORD = Path(__file__).parent / "computed.json"
KEPT = ("kernels", "target", "libc", "numpy", "numba", "llvmlite")
"""Of the solver and the machine: what decides every bit that a kernel computes."""
LIBRARIES = ("matplotlib", "xarray")
"""Whose versions decide how it is shown."""


def is_of_here(page: str) -> bool:
    """Whether a page was computed by these kernels on a machine that computes the same bits.

    Parameters
    ----------
    page : str
        Its path from the root of the repository.
    """
    return _recorded().get(page) == _here()


def record(pages: Iterable[str]) -> None:
    """Note that pages have just been computed here."""
    recorded = _recorded() | dict.fromkeys(pages, _here())
    RECORD.write_text(json.dumps(recorded, indent=1, sort_keys=True) + "\n")


def _here() -> dict[str, str]:
    facts = computing()
    return {name: facts[name] for name in KEPT} | {name: version(name) for name in LIBRARIES}


def _recorded() -> dict[str, dict[str, str]]:
    if not RECORD.exists():
        return {}
    recorded: dict[str, dict[str, str]] = json.loads(RECORD.read_text())
    return recorded
