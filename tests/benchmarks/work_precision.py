"""Work-precision diagrams with general-purpose integrators beside ours and the paper's.

`python -m tests.benchmarks.work_precision [-o DIR]`; as part of `make bench` it prints its figures only.
"""

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from tests.benchmarks._peers import peers

from damperlab.service.figures.accuracy import draw_work_precision
from damperlab.service.figures.style import save
from damperlab.worker.accuracy.cases import SCENES
from damperlab.worker.accuracy.methods import METHODS
from damperlab.worker.accuracy.report import advantages
from damperlab.worker.accuracy.work_precision import draw_diagrams


def run() -> dict[str, Any]:
    """Every method on every scene: the diagrams, and by how much each method is slower at its own best error."""
    methods, missing = peers()

    def say(name: str) -> None:
        print(f"  {name} …", file=sys.stderr)

    diagrams = draw_diagrams((*METHODS, *methods), SCENES, say)
    return {
        "missing": missing,
        "diagrams": [one.document() for one in diagrams],
        "advantages": {one.scene: advantages(one) for one in diagrams},
    }


def main() -> None:
    """Measure, print, and write the figure where asked."""
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.work_precision", description=__doc__)
    parser.add_argument("-o", "--output", type=Path, metavar="DIR")
    folder = parser.parse_args().output
    figures = run()
    for diagram in figures["diagrams"]:
        print(f"{diagram['scene']}: µs per cycle / relative error")
        for curve in diagram["curves"]:
            points = (
                "✗" if p["error"] is None else f"{p['microseconds']:.3g} / {p['error']:.0e}"
                for p in curve["points"]
            )
            order = "" if curve["order"] is None else f"   order {curve['order']:.2f}"
            print(f"  {curve['method']:38} {'   '.join(points)}{order}")
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "work-precision.json").write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")
        save(draw_work_precision(figures["diagrams"]), folder / "work-precision.png")


if __name__ == "__main__":
    main()
