"""Every figure of the documentation by name, and how one is written."""

import re
from collections.abc import Callable
from functools import partial
from pathlib import Path

from docs.drawing.cavity import draw_friction_of_the_particle, draw_standing, draw_table_3
from docs.drawing.contact import draw_contact
from docs.drawing.motion import EXAMPLES, draw_class
from docs.drawing.sketches import draw_cluster, draw_friction, draw_layers, draw_scene, draw_stores
from docs.drawing.speed import draw_speed
from matplotlib.figure import Figure

from damperlab.service.figures.style import styled

FIGURES: dict[str, Callable[[], Figure]] = {
    **{f"response-{name}": partial(draw_class, name) for name in EXAMPLES},
    "contact": draw_contact,
    "cavity-friction": draw_friction_of_the_particle,
    "cavity-standing": draw_standing,
    "cavity-table-3": draw_table_3,
    "scene": draw_scene,
    "friction": draw_friction,
    "cluster": draw_cluster,
    "stores": draw_stores,
    "layers": draw_layers,
    "speed": draw_speed,
}
"""Drawn by the function of its name."""

# letters as shapes: a picture in a page has no access to the fonts of this machine
ALONE = {"svg.fonttype": "path", "path.simplify_threshold": 0.2}


def write(name: str, folder: Path) -> Path:
    """Write a figure as SVG; the same solver writes the same bytes.

    Parameters
    ----------
    name : str
        One of `FIGURES`.
    folder : path
        Exists.
    """
    path = folder / f"{name}.svg"
    with styled(ALONE):
        FIGURES[name]().savefig(path, metadata={"Date": None}, facecolor="white")
    path.write_text(rounded(path.read_text()))
    return path


def key_of(name: str) -> str:
    """Name a figure in `docs.computed`."""
    return f"docs/figures/{name}.svg"


def rounded(svg: str) -> str:
    """Round the coordinates of a drawing to a tenth of a point, which no eye sees: half of its bytes remain."""

    def shorter(path: re.Match[str]) -> str:
        numbers = re.sub(r"-?\d+\.\d+", lambda number: f"{round(float(number[0]), 1):g}", path[0])
        return re.sub(r"\s*\n", " ", numbers)

    return re.sub(r' (?:d|x|y)="[^"]*"', shorter, svg)
