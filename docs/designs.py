"""The named specifications designed: `python -m docs.designs [NAME …]` puts their answers and figures into a page.

An answer is kept as JSON beside the page, with the digest of the specification that it answers and the points on which it
stands. A test holds the page against the kept answers, their digests against today's specifications, and their points
against today's solver.
"""

import json
import re
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from docs.computed import record
from docs.console import ROOT
from docs.drawing.figures import ALONE, rounded

from damperlab.service.design_budget import budget_of
from damperlab.service.figures.design import draw_alternatives
from damperlab.service.figures.style import styled
from damperlab.studies.brief import lines_of
from damperlab.studies.definition import Study, parse_harmonic
from damperlab.studies.design.answer import answer_document
from damperlab.studies.design.build import Build
from damperlab.studies.design.design import designing
from damperlab.studies.design.found import Found
from damperlab.studies.design.score import Score
from damperlab.studies.design.verdict import called_of
from damperlab.studies.ground.paper import CLEARANCES_M, friction_force_n
from damperlab.studies.named import named_specifications
from damperlab.studies.plan import Block
from damperlab.studies.specification.reading import parse_specification
from damperlab.studies.specification.specification import Specification
from damperlab.studies.text import load_text
from damperlab.studies.variables import ResponseClass
from damperlab.worker.block import solve_block

PAGE = ROOT / "docs" / "examples" / "designs.md"
FIGURES = ROOT / "docs" / "figures"
BLOCK = re.compile(r"(<!-- ([\w-]+) -->\n).*?(<!-- end -->)", re.DOTALL)
NUMBERS = (
    "design", "worst", "nominal", "compared", "feasible", "limits", "probability", "probability_interval",
    "friction_alone", "particle_alone", "tuned_mass_damper", "points", "ended", "verdict",
)  # fmt: skip
"""What is kept of an answer."""
IRREGULAR_CLASSES = (ResponseClass.MODULATED, ResponseClass.CHAOTIC)
FREQUENCIES = 1001
"""Of the band of the prototype, at which the paper's damper is looked at."""


def specification(name: str) -> Specification:
    """Read a named specification."""
    return parse_specification(load_text(named_specifications()[name], "yaml"))


def solved(study: Study) -> xr.Dataset:
    """Compute a study in this process."""
    values = solve_block(study, Block.whole(study.shape))
    arrays = {name: (tuple(study.coordinates), array) for name, array in values.items()}
    return xr.Dataset(arrays, study.coordinates, {"study": json.dumps(study.document())})


def designed(asked: Specification) -> Found:
    """Follow a search to its end."""
    rounds = designing(asked, budget_of(asked))
    try:
        ask = next(rounds)
        while True:
            ask = rounds.send([solved(study) for study in ask.studies])
    except StopIteration as end:
        found: Found = end.value
        return found


def point_of(asked: Specification, score: Score) -> dict[str, Any]:
    """Give the point on which a worst case stands: its study, and what the measure is there."""
    build = score.build
    damping, restitution, mass, clearance, friction = build.place(asked.structure, score.amplitude_m)
    axes = {"friction_ratio": friction, "frequency_ratio": build.own(score.frequency_ratio)}
    if mass:
        axes |= {"restitution": restitution, "mass_ratio": mass, "clearance_ratio": clearance}
    study = {
        "damping_ratio": damping,
        "axes": axes,
        "particle": mass > 0.0,
        "metrics": [asked.measure.variable, "response_class"],
    }
    return {"study": study, "value": score.value / asked.measure.factor / score.amplitude_m}


def measured(point: dict[str, Any]) -> tuple[float, bool]:
    """Compute a kept point anew; the measure there, and whether the response repeats."""
    cube = solved(parse_harmonic(point["study"]))
    value = cube[point["study"]["metrics"][0]].item()
    return float(value), int(cube["response_class"].item()) not in IRREGULAR_CLASSES


def kept(found: Found) -> dict[str, Any]:
    """Give what is kept of an answer."""
    asked, answer = found.asked, answer_document(found)
    scores = (found.stated, found.nominal, *(each.score for each in found.alternatives.values()))
    return {
        "specification": asked.digest,
        "points_at": [point_of(asked, score) for score in scores],
        **{name: answer[name] for name in NUMBERS},
    }


def beside_the_paper(found: Found) -> list[dict[str, float]]:
    """Measure the recommended damper and the paper's: at resonance, over the band, and with the corners of the tolerances."""
    asked = found.asked
    amplitude_m = asked.excitations[0].highest_m
    force = friction_force_n(amplitude_m, asked.structure.stiffness_n_per_m, asked.structure.damping_ratio)
    paper = replace(found.build, clearance_m=CLEARANCES_M[0], friction_force_n=force)
    rows = []
    for build in (found.build, paper):
        corners = [
            build.moved(asked, {"clearance_m": one, "friction_force_n": other})
            for one in (-1.0, 1.0)
            for other in (-1.0, 1.0)
        ]
        band = np.linspace(asked.excitations[0].low, asked.excitations[0].high, FREQUENCIES)
        curves = [amplitude_m * curve(asked, each, band) for each in (build, *corners)]
        rows.append(
            {
                "clearance_m": build.clearance_m,
                "friction_force_n": build.friction_force_n,
                "at_resonance_m": amplitude_m * float(curve(asked, build, np.array([1.0])).item()),
                "over_band_m": float(curves[0].max()),
                "at_hz": float(band[curves[0].argmax()]) * asked.structure.natural_frequency_hz,
                "with_tolerances_m": float(max(each.max() for each in curves)),
            }
        )
    return rows


def curve(asked: Specification, build: Build, r: np.ndarray) -> np.ndarray:
    """Compute the displacement of a build over Z, shape (n,), under the largest base amplitude."""
    damping, restitution, mass, clearance, friction = build.place(
        asked.structure, asked.excitations[0].highest_m
    )
    axes = {"restitution": restitution, "mass_ratio": mass, "clearance_ratio": clearance}
    axes |= {"friction_ratio": friction, "frequency_ratio": r.tolist()}
    study = parse_harmonic({"damping_ratio": damping, "axes": axes, "metrics": ["amplitude_ratio"]})
    return solved(study)["amplitude_ratio"].values.ravel()


def block_of(name: str, answer: dict[str, Any]) -> str:
    """Write the part of the page about one specification: the document, the figure, the verdict."""
    text = named_specifications()[name].decode().strip()
    lines = [
        f'```yaml title="{name}.yaml"\n{text}\n```',
        f"![Response over the band: the recommended damper of {name}, other dampers and none](../figures/design-{name}.svg)",
        "\n".join(["```text", *lines_of(answer["verdict"]), "```"]),
    ]
    if rows := answer.get("paper"):
        lines.append(_table(rows))
    return "\n".join(f"{part}\n" for part in lines)


def _table(rows: list[dict[str, float]]) -> str:
    head = "| | clearance | friction force | at 2.5 Hz | worst of the band | with the corners of the tolerances |\n"
    return f"{head}|---|---|---|---|---|---|\n" + "\n".join(
        f"| {called} | {1e3 * row['clearance_m']:.3g} mm | {row['friction_force_n']:.3g} N | "
        f"{1e3 * row['at_resonance_m']:.3g} mm | {1e3 * row['over_band_m']:.3g} mm, at {row['at_hz']:.3g} Hz | "
        f"{1e3 * row['with_tolerances_m']:.3g} mm |"
        for called, row in zip(("recommended", "the paper's"), rows, strict=True)
    )


def answer_path(name: str) -> Path:
    """Say where an answer is kept."""
    return PAGE.parent / f"{name}.json"


def page_of(text: str) -> str:
    """Give the page with what the kept answers say."""

    def block(found: re.Match[str]) -> str:
        answer = json.loads(answer_path(found[2]).read_text())
        return f"{found[1]}\n{block_of(found[2], answer)}\n{found[3]}"

    return BLOCK.sub(block, text)


def main() -> None:
    """Design those that are named, or all, and write the page."""
    for name in sys.argv[1:] or named_specifications():
        found = designed(specification(name))
        answer = kept(found)
        if name == "prototype":
            answer["paper"] = beside_the_paper(found)
        answer_path(name).write_text(json.dumps(answer, indent=1, ensure_ascii=False) + "\n")
        path = FIGURES / f"design-{name}.svg"
        with styled(ALONE):
            called = called_of(found, answer["verdict"]["damper"])
            draw_alternatives(found, called).savefig(path, metadata={"Date": None}, facecolor="white")
        path.write_text(rounded(path.read_text()))
        record([answer_path(name).relative_to(ROOT).as_posix()])
        print(name, answer["points"], flush=True)
    PAGE.write_text(page_of(PAGE.read_text()))


if __name__ == "__main__":
    main()
