"""Numbers printed in the paper, read from a single file."""

from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import yaml


@dataclass(frozen=True)
class PaperNumber:
    """A number as printed in the paper.

    Parameters
    ----------
    value : float
        Value in the unit at the end of the name; a ratio if the name has no unit.
    place : str
        Table or section of the paper that prints the number.
    """

    value: float
    place: str


@cache
def paper_numbers() -> dict[str, PaperNumber]:
    """Return every number of `studies/paper.yaml` by name."""
    document = yaml.safe_load((files("damperlab.studies") / "paper.yaml").read_text(encoding="utf-8"))
    return {name: PaperNumber(float(entry["value"]), entry["place"]) for name, entry in document.items()}
