"""Measurement of the data for the accuracy report, and the report in Markdown."""

import os
import platform
from collections.abc import Callable
from datetime import UTC, datetime
from itertools import islice
from typing import Any

from damperlab.worker.accuracy.cases import SCENES
from damperlab.worker.accuracy.extremes import LONG_RUN_CYCLES, extreme_cases
from damperlab.worker.accuracy.methods import METHODS
from damperlab.worker.accuracy.stability import STEPS, stability_table
from damperlab.worker.accuracy.steady_answers import every, extreme_answers, points, table
from damperlab.worker.accuracy.work_precision import Diagram, draw_diagrams
from damperlab.worker.jit import source_hash
from damperlab.worker.provenance import code_version

FIGURE = "work-precision.png"
STEADY_POINTS, STEADY_CYCLES, STEADY_SEED, EXTREME_CYCLES = 160, 4000, 7, 1000
"""Settings for checking steady responses: number of random points, cycles of each integration, seed of the points, and
cycles of each integration for extreme cases.
"""


def make_report(
    on_step: Callable[[str], None] = lambda what: None, long_run_cycles: int = LONG_RUN_CYCLES
) -> dict[str, Any]:
    """Measure every diagram and every extreme case on this machine.

    Parameters
    ----------
    on_step : callable
        Function called with the name of each step before it begins.
    long_run_cycles : int
        Number of excitation cycles of the long runs.

    Returns
    -------
    dict
        JSON-able report with `created`, `version`, `kernels`, `machine`, `diagrams`, `advantages`, `stability`,
        `steady` (a `table` of random points, and `extremes`) and `passed`.
    """
    diagrams = draw_diagrams(METHODS, SCENES, lambda name: on_step(f"work-precision: {name}"))
    cases = extreme_cases(long_run_cycles)
    rows = stability_table(cases, lambda name: on_step(f"stability: {name}"))
    return {
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
        "version": code_version(),
        "kernels": source_hash(),
        "machine": {"processor": platform.processor() or platform.machine(), "cores": os.cpu_count()},
        "diagrams": [one.document() for one in diagrams],
        "advantages": {one.scene: advantages(one) for one in diagrams},
        "stability": [row.document() for row in rows],
        "steady": {
            "table": table(list(every(islice(points(STEADY_SEED), STEADY_POINTS), STEADY_CYCLES))),
            "extremes": extreme_answers(cases, EXTREME_CYCLES),
        },
        "passed": all(row.passed for row in rows),
    }


def advantages(diagram: Diagram) -> dict[str, dict[str, float | None]]:
    """Compare the run times of other methods, at their smallest errors, with the run time of the event-driven solver.

    Returns
    -------
    dict
        For each method, `error` and `microseconds` of its most accurate run, and `times_slower`. `times_slower` is the
        ratio of this run time to the longest run time of the event-driven solver, or None if the method was more
        accurate than the event-driven solver. Methods without a result are omitted.
    """
    ours = [curve for curve in diagram.curves if not curve.setting]
    slowest = max(point.microseconds for curve in ours for point in curve.points)
    worst = max(point.error or 1.0 for curve in ours for point in curve.points)
    found: dict[str, dict[str, float | None]] = {}
    for curve in diagram.curves:
        usable = [point for point in curve.points if point.error is not None]
        if not curve.setting or not usable:
            continue
        best = min(usable, key=lambda point: point.error or 0.0)
        comparable = (best.error or 0.0) >= worst
        found[curve.method] = {
            "error": best.error,
            "microseconds": best.microseconds,
            "times_slower": best.microseconds / slowest if comparable else None,
        }
    return found


def in_markdown(report: dict[str, Any], figure: str = FIGURE) -> str:
    """Return a report as Markdown.

    Parameters
    ----------
    report : dict
        Report from `make_report`.
    figure : str
        Path of the image, relative to the text.
    """
    lines = [
        "# Accuracy and stability",
        "",
        f"Measured {report['created']} with damperlab {report['version']} (kernels {report['kernels']}) on "
        f"{report['machine']['cores']} cores, {report['machine']['processor']}. All numbers were measured for this report.",
        "",
        "## Error against run time",
        "",
        f"![Error of the end state against run time, one panel per scene]({figure})",
        "",
        "Error: largest difference of u, u', p, p' from a reference in 40 digits after the given number of cycles from "
        "rest, relative to the largest of the four. Run time: the smallest of several runs, one core, kernels compiled. The "
        "event-driven integration has no step to vary, so it has one point. The order p in error ∝ setting⁻ᵖ is "
        "the median slope over all pairs of settings.",
        "",
    ]
    for diagram in report["diagrams"]:
        lines += _diagram_lines(diagram)
    passed = sum(row["passed"] for row in report["stability"])
    lines += [
        "## Stability",
        "",
        f"{passed} of {len(report['stability'])} extreme cases pass. In these cases the integration "
        "reaches its end, and every value is finite. The energy residual is within its limit, and "
        "penetration and momentum error are at most rounding (1e-12). The column "
        f"`paper's method` gives the outcome of that method with {STEPS} steps per cycle.",
        "",
        "| case | cycles | status | impacts | turns | attachments | energy residual | penetration | momentum error | "
        "µs per cycle | paper's method | |",
        "|---|---:|---|---:|---:|---:|---:|---:|---:|---:|---|---|",
    ]
    for row in report["stability"]:
        lines.append(
            f"| {row['name']} | {row['cycles']} | {row['status']} | {row['impacts']} | {row['turns']} | "
            f"{row['attachments']} | {_small(row['energy_residual'])} | {_small(row['penetration'])} | "
            f"{_small(row['momentum_error'])} | {row['microseconds']:.3g} | {row['paper']} | "
            f"{'' if row['passed'] else '**fails**'} |"
        )
    return "\n".join([*lines, *_steady_lines(report["steady"])]) + "\n"


def _steady_lines(steady: dict[str, Any]) -> list[str]:
    lines = [
        "",
        "## Steady answers",
        "",
        f"{STEADY_POINTS} random points of the whole cube, of every contact model, solved as in a study and "
        f"compared with a plain integration of {2 * STEADY_CYCLES} half cycles from rest. If a point has several "
        "responses, the solver and the integration may reach different ones.",
        "",
        "| | |",
        "|---|---:|",
        *(f"| {name} | {value:.6g} |" for name, value in steady["table"].items()),
        "",
        f"The extreme cases, solved in the same way and compared with integrations over {2 * EXTREME_CYCLES} half cycles. "
        "Without damping, or with very little, neither the search nor the integration has settled by then.",
        "",
        "| case | class | period | X/Z | error | cycles | status | compared with the integration |",
        "|---|---|---:|---:|---:|---:|---|---|",
    ]
    lines.extend(
        f"| {row['name']} | {row['response_class']} | {row['period']} | {_small(row['amplitude_ratio'])} | "
        f"{_small(row['amplitude_error'])} | {row['cycles']} | {row['status']} | {row['verdict']} |"
        for row in steady["extremes"]
    )
    return lines


def _diagram_lines(diagram: dict[str, Any]) -> list[str]:
    lines = [
        f"### {diagram['title'].capitalize()}, {diagram['cycles']} cycles",
        "",
        "| method | smallest error | at | µs per cycle | order |",
        "|---|---:|---|---:|---:|",
    ]
    for curve in diagram["curves"]:
        usable = [point for point in curve["points"] if point["error"] is not None]
        if not usable:
            lines.append(f"| {curve['method']} | failed at every setting | | | |")
            continue
        best = min(usable, key=lambda point: point["error"])
        at = f"{best['setting']:g} {curve['setting']}" if curve["setting"] else "nothing to vary"
        order = "" if curve["order"] is None else f"{curve['order']:.2f}"
        lines.append(
            f"| {curve['method']} | {_small(best['error'])} | {at} | {best['microseconds']:.3g} | {order} |"
        )
    return [*lines, ""]


def _small(value: float | None) -> str:
    return "" if value is None else f"{value:.1e}"
