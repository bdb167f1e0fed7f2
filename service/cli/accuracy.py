"""`damperlab check accuracy` measures error against run time, and computes extreme cases."""

import json
from math import nan
from pathlib import Path
from typing import Annotated, Any

import typer

from damperlab.service.cli.options import AsJson, DataDir
from damperlab.service.cli.output import note, number, print_json, print_table, say, working
from damperlab.service.cli.places import folder_option
from damperlab.service.cli.store import data_folder
from damperlab.service.cli.warm import have_ready


def accuracy(
    output: Annotated[
        Path,
        folder_option(
            "--output",
            "-o",
            help="Folder of the report: accuracy.md, accuracy.json and a PNG.",
        ),
    ] = Path("accuracy"),
    data_dir: DataDir = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="Limit the long runs to 10,000 cycles; a million by default.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Measure the solver: error against run time, extreme cases."""
    from damperlab.service.documents import plain
    from damperlab.service.figures.accuracy import draw_work_precision
    from damperlab.service.figures.style import save
    from damperlab.service.reports import keep_report
    from damperlab.worker.accuracy.extremes import LONG_RUN_CYCLES
    from damperlab.worker.accuracy.report import FIGURE, in_markdown, make_report
    from damperlab.worker.scenes import accuracy_scenes

    output.mkdir(parents=True, exist_ok=True)
    have_ready(accuracy_scenes(), apart=True)
    steps = ["the solver"]
    with working(lambda: f"Measuring {steps[-1]}"):
        report = plain(make_report(steps.append, 10_000 if quick else LONG_RUN_CYCLES))
    (output / "accuracy.json").write_text(
        json.dumps(report, indent=1, ensure_ascii=False) + "\n", encoding="utf-8"
    )
    (output / "accuracy.md").write_text(in_markdown(report), encoding="utf-8")
    save(draw_work_precision(report["diagrams"]), output / FIGURE)
    keep_report(data_folder(data_dir), report)
    note(
        f"Wrote {output / 'accuracy.md'}, accuracy.json and {FIGURE}; the service gives this report at /api/v1/accuracy."
    )
    if as_json:
        print_json(report)
    else:
        _print(report)
    if not report["passed"]:
        raise typer.Exit(1)


def _print(report: dict[str, Any]) -> None:
    """Print short tables of the report."""
    rows = []
    for diagram in report["diagrams"]:
        for curve in diagram["curves"]:
            usable = [point for point in curve["points"] if point["error"] is not None]
            if usable:
                best = min(usable, key=lambda point: point["error"])
                order = "" if curve["order"] is None else f"{curve['order']:.2f}"
                rows.append(
                    (
                        diagram["scene"],
                        curve["method"],
                        number(best["error"], 2),
                        number(best["microseconds"], 3),
                        order,
                    )
                )
    print_table(("scene", "method", "smallest error", "µs per cycle", "order"), rows)
    say("")
    print_table(
        ("case", "status", "energy residual", "µs per cycle", "paper's method"),
        (
            (
                row["name"],
                row["status"] if row["passed"] or row["status"] != "arrived" else "FAILS",
                number(row["energy_residual"] or nan, 2),
                number(row["microseconds"], 3),
                row["paper"],
            )
            for row in report["stability"]
        ),
    )
    passed = sum(row["passed"] for row in report["stability"])
    say(f"{passed} of {len(report['stability'])} extreme cases pass.")
    answers = report["steady"]["table"]
    verdicts = ", ".join(
        f"{count} {name.removeprefix('verdict: ')}"
        for name, count in answers.items()
        if name.startswith("verdict")
    )
    say(
        f"{answers['answers compared']} random steady responses were compared with plain integrations. "
        f"Verdicts: {verdicts}."
    )
