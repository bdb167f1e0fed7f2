"""Specifications of fits as text: read back as they were meant, and a line has room on a screen."""

from typing import Any

from damperlab.studies.fit.specification_text import WIDTH, specification_text
from damperlab.studies.fit.specified import Specified
from damperlab.studies.specification.reading import named_specifications
from damperlab.studies.text import load_text

DOCUMENT: dict[str, Any] = {
    "name": "bench: 3 % of #noise, corrigée",
    "structure": {"mass_kg": 1.6, "natural_frequency_hz": 2.5, "damping_ratio": 1e-05},
    "choose": {
        "clearance_m": {"start": 1e-4, "stop": 0.02},
        "restitution": [{"name": "rubber", "restitution": 0.3}, {"name": "steel", "restitution": 0.8}],
    },
    "particle_mass_kg": 0.16,
    "tolerances": {"damping_ratio": "50%"},
}


def test_what_is_written_is_read_back_with_comments_where_something_is_guessed() -> None:
    words = ("A sentence. " * 20, "Another one.")
    guesses = {"choose.clearance_m": "from nothing\nat all.", "particle_mass_kg": "a tenth."}
    text = specification_text(Specified(DOCUMENT, words, guesses))
    assert load_text(text, "yaml") == DOCUMENT
    lines = text.splitlines()
    assert lines[0].startswith("# A sentence. ")
    assert all(len(line) <= WIDTH + 4 for line in lines)
    above = lines.index("  clearance_m: {start: 0.0001, stop: 0.02}") - 1
    assert lines[above] == "  # GUESS, to be edited: from nothing at all."
    assert lines[lines.index("particle_mass_kg: 0.16") - 1] == "# GUESS, to be edited: a tenth."


def test_named_specifications_are_written_as_they_were_read() -> None:
    for name, written in named_specifications().items():
        document = load_text(written, "yaml")
        assert load_text(specification_text(Specified(document, (), {})), "yaml") == document, name
