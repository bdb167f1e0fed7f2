"""Figures of the documentation are those that the solver draws today."""

import re
from pathlib import Path

import pytest
from docs.computed import is_of_here
from docs.drawing.figures import FIGURES, key_of, write

from damperlab.studies.named import named_specifications

KEPT = Path(__file__).parents[2] / "docs" / "figures"
NUMBER = re.compile(r"-?\d+(?:\.\d+)?")
DRIFTING = ("contact", "cavity-friction", "cavity-standing")
"""Drawn through motions that do not repeat."""
FIXED = [name for name in FIGURES if name not in ("response-chaotic", "response-modulated", *DRIFTING)]
"""Motions that repeat, and sketches: another processor draws the same lines."""
AT_NIGHT = re.compile("cavity|response-(?!symmetric)")
"""Drawn by the lines that draw another figure, of other designs."""
POINTS = 0.25
"""Distance on paper: a coordinate is rounded to 0.1, and what is left of a path is chosen to 0.2."""


def test_every_figure_is_kept() -> None:
    designs = {f"design-{name}.svg" for name in named_specifications()}  # of `docs.designs`
    assert {f"{name}.svg" for name in FIGURES} | designs == {path.name for path in KEPT.glob("*.svg")}


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.night if AT_NIGHT.match(name) else ()) for name in FIGURES],
)
def test_figure_is_what_is_drawn_today(name: str, tmp_path: Path) -> None:
    same = name in FIXED or is_of_here(key_of(name))
    if not same and name in DRIFTING:
        pytest.skip("drawn by another solver or machine: motion that does not repeat differs there")
    new, old = write(name, tmp_path).read_text(), (KEPT / f"{name}.svg").read_text()
    if not same:
        return  # another motion, and still one of its class: drawing another class is refused
    assert NUMBER.sub("#", new) == NUMBER.sub("#", old)
    far = [
        (one, other)
        for one, other in zip(NUMBER.findall(new), NUMBER.findall(old), strict=True)
        if abs(float(one) - float(other)) > POINTS
    ]
    assert far == []
