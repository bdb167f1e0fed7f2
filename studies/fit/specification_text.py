"""A specification that a fit made, as text: what was measured and what is guessed stands in comments."""

import textwrap
from collections.abc import Iterator
from typing import Any

import yaml

from damperlab.studies.fit.specified import Specified

WIDTH = 120


def specification_text(specified: Specified) -> str:
    """Write a specification as YAML.

    Parameters
    ----------
    specified : Specified
        Its sentences head the text; what is guessed has a comment above it.
    """
    lines = [line for sentence in specified.words for line in _comment(sentence)]
    for key, value in specified.document.items():
        lines += _entry(specified, key, value)
    return "\n".join(lines) + "\n"


def _entry(specified: Specified, key: str, value: Any) -> Iterator[str]:
    yield from _guess(specified, key)
    inside = any(place.startswith(f"{key}.") for place in specified.guesses)
    if not (inside and isinstance(value, dict)):
        yield from _dumped({key: value})
        return
    yield f"{key}:"
    for name, each in value.items():
        for line in (*_guess(specified, f"{key}.{name}"), *_dumped({name: each})):
            yield f"  {line}"


def _guess(specified: Specified, place: str) -> Iterator[str]:
    if place in specified.guesses:
        yield from _comment(f"GUESS, to be edited: {specified.guesses[place]}")


def _comment(sentence: str) -> list[str]:
    return [f"# {line}" for line in textwrap.wrap(sentence, WIDTH)]


def _dumped(document: dict[str, Any]) -> list[str]:
    """Write one entry: collections of plain values on one line."""
    (value,) = document.values()
    flow = None if isinstance(value, dict | list) else False
    text = yaml.safe_dump(
        document, allow_unicode=True, sort_keys=False, default_flow_style=flow, width=10_000
    )
    return text.splitlines()
