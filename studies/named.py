"""The named studies and specifications of the package, as YAML text in UTF-8 with comments."""

from functools import cache
from importlib.resources import files


@cache
def named_texts() -> dict[str, bytes]:
    """Return the text of each named study, by its name."""
    return _texts("catalog")


@cache
def named_specifications() -> dict[str, bytes]:
    """Return the text of each named specification, by its name."""
    return _texts("specification/catalog")


def _texts(folder: str) -> dict[str, bytes]:
    entries = sorted((files("damperlab.studies") / folder).iterdir(), key=lambda entry: entry.name)
    return {
        entry.name.removesuffix(".yaml"): entry.read_bytes()
        for entry in entries
        if entry.name.endswith(".yaml")
    }
