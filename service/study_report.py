"""The report of a study, a page of HTML to store or to print."""

import json
from collections.abc import Iterable, Mapping
from html import escape
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from damperlab.service.html import drawing, page, said, table
from damperlab.service.questions.optimal_designs import OPTIMAL_DESIGNS
from damperlab.service.questions.question import Subject
from damperlab.studies.answers.frequency_response import frequency_response
from damperlab.studies.answers.leading import leading
from damperlab.studies.answers.phrases import Phrases
from damperlab.studies.answers.query_fault import QueryFault
from damperlab.studies.answers.resonance_map import resonance_map
from damperlab.studies.answers.selection import dimensions_of, main_metric
from damperlab.studies.answers.tmd_comparison import tmd_comparison
from damperlab.studies.answers.work_precision import work_precision
from damperlab.studies.kinds import HARMONIC, kind_of
from damperlab.studies.questions import Judging, Ranking, Selection
from damperlab.studies.rounding import ROUNDING_WORD, is_rounding
from damperlab.studies.spelling import without_unit
from damperlab.studies.store.provenance import PRIVATE
from damperlab.studies.store.record import Record
from damperlab.studies.units import InUnits, coordinates_in_units, place_in_units, results_in_units

if TYPE_CHECKING:
    import xarray as xr

TOP = 5
MAPS = 3
"""Largest number of maps. Three axes give three maps, one for each pair of axes."""


def study_report(study: Subject) -> str:
    """Return the report of a study as a self-contained page of HTML.

    Parameters
    ----------
    study : Subject
        The study.

    Returns
    -------
    str
        HTML with embedded SVG figures. If the study is given in SI units, the report uses SI units.
    """
    record, cube = study.record, study.cube
    title = escape(record.name or record.id)
    worst_case = kind_of(cube.sizes) is not HARMONIC
    ranked = OPTIMAL_DESIGNS.of(study, Judging(), Ranking(top=TOP))
    parts = [
        f"<h1>{title}</h1>",
        said(
            f"Study {record.id}, {record.state}: {record.points_done:,} of {record.points_total:,} points, "
            f"{record.points_failed:,} failed."
        ),
        "<h2>Designs</h2>",
        *_designs(cube, ranked, worst_case),
        "<h2>Maps</h2>",
        *_maps(cube, None if worst_case else leading(ranked)),
    ]
    if not worst_case:
        parts += _best(cube, ranked)
    parts += [
        "<h2>Accuracy and cost</h2>",
        *_cost(record, cube, worst_case),
        "<h2>Definition</h2>",
        f"<pre>{escape(json.dumps(record.definition, indent=2, ensure_ascii=False))}</pre>",
    ]
    versions = {name: text for name, text in record.provenance.items() if name not in PRIVATE}
    parts += ["<h2>Versions</h2>", table("Versions of programs", ("What", "Version"), versions.items())]
    return page(record.name or record.id, parts)


def _words(answer: "xr.Dataset") -> Mapping[str, Any]:
    return {**answer.attrs, **answer.attrs.get("in_units", {})}


def _designs(cube: "xr.Dataset", ranked: "xr.Dataset", worst_case: bool) -> Iterable[str]:
    words = _words(ranked)
    yield from (said(sentence) for sentence in words.get("verdict", ()))
    units = _units(cube)
    names = [name for name in dimensions_of(cube) if cube.sizes[name] > 1 and name in ranked.coords]
    columns = [
        ("value" if worst_case else "amplitude_ratio", "value"),
        *([("amplitude_error", "error")] if "error" in ranked else []),
        *((name, name) for name in names),
    ]
    head = ["rank", *(_head(ranked, units, name, column) for name, column in columns)]
    ranks = (
        {column: ranked[column].values[rank] for _, column in columns} for rank in range(ranked.sizes["rank"])
    )
    rows = [(str(rank), *_row(ranked, units, row, columns)) for rank, row in enumerate(ranks, 1)]
    best = None if worst_case else leading(ranked)
    if best is not None and best["value"] != ranked["value"].values[0]:
        rows.append(("best with impacts", *_row(ranked, units, best, columns)))
    yield table("Ranking", head, rows)
    yield said(words["note"], "quiet")


def _row(
    ranked: "xr.Dataset",
    units: Mapping[str, InUnits],
    row: Mapping[str, Any],
    columns: Iterable[tuple[str, str]],
) -> list[str]:
    """Return the table row of one design. An error as small as a rounding error is written as a word."""
    return [
        ROUNDING_WORD
        if column == "error" and is_rounding(row["value"], row["error"])
        else _number(row[column], _scale(ranked, units, name, column))
        for name, column in columns
    ]


def _unit(ranked: "xr.Dataset", units: Mapping[str, InUnits], name: str, column: str) -> str:
    return units[name].units if name in units else str(ranked[column].attrs.get("units", "1"))


def _head(ranked: "xr.Dataset", units: Mapping[str, InUnits], name: str, column: str) -> str:
    """Return the heading of a column with the unit, which is mm for lengths."""
    unit = _unit(ranked, units, name, column)
    label = without_unit(units[name].name if name in units else name)
    return label + ("" if unit in ("1", "") else f" [{'mm' if unit == 'm' else unit}]")


def _scale(ranked: "xr.Dataset", units: Mapping[str, InUnits], name: str, column: str) -> float:
    factor = units[name].factor if name in units else 1.0
    return 1e3 * factor if _unit(ranked, units, name, column) == "m" else factor


def _number(value: Any, scale: float) -> str:
    return str(value) if isinstance(value, str | np.str_) else f"{float(value) * scale:.6g}"


def _units(cube: "xr.Dataset") -> dict[str, InUnits]:
    return {each.source: each for each in (*coordinates_in_units(cube), *results_in_units(cube))}


def _maps(cube: "xr.Dataset", best: Mapping[str, Any] | None) -> Iterable[str]:
    """Draw a map for each pair of axes. All other parameters have the values of the best design."""
    from damperlab.service.figures.resonance_map import draw_map

    kind = kind_of(cube.sizes)
    units = {source: each.name for source, each in _units(cube).items()}
    varied = [name for name in kind.axes if name in cube.sizes and cube.sizes[name] > 1]
    designs = [name for name in varied if name != kind.uncontrolled]
    axes = designs if len(designs) > 1 else varied
    metric = main_metric(cube)
    shown = units.get(metric, metric)
    if len(axes) < 2:
        yield said("Only one parameter varies, so there is no map.")
    for x, y in list(combinations(axes, 2))[:MAPS]:
        at = {} if best is None else {name: best[name] for name in designs if name not in (x, y)}
        answer = resonance_map(cube, units.get(x, x), units.get(y, y), Selection(metric=shown, at=at))
        yield drawing(draw_map(answer, shown), f"{_captioned(cube, answer, shown)}. {_words(answer)['note']}")


def _best(cube: "xr.Dataset", ranked: "xr.Dataset") -> Iterable[str]:
    from damperlab.service.figures.comparison import draw_comparison
    from damperlab.service.figures.curves import draw_response

    best = leading(ranked)
    if best is None:
        return
    at = {name: best[name] for name in dimensions_of(cube) if name != "frequency_ratio"}
    yield "<h2>The design compared with a tuned mass damper</h2>"
    units = _units(cube)
    shown = units["amplitude_ratio"].name if "amplitude_ratio" in units else "amplitude_ratio"
    curve = frequency_response(cube, Selection(metric=shown, at=at))
    if curve.sizes["frequency_ratio"] > 1:
        yield drawing(
            draw_response(_over_hertz(curve, units), shown),
            f"{_captioned(cube, curve, shown)}. {_words(curve)['note']}",
        )
    try:
        compared = tmd_comparison(cube, at=at)
    except QueryFault as refused:
        yield said(f"No comparison: {refused.fault.found}; {refused.fault.advice}.")
        return
    words = _words(compared)
    yield from (said(sentence) for sentence in words["verdict"])
    yield drawing(
        draw_comparison(place_in_units(cube, _in_metres(_over_hertz(compared, units), units))), words["note"]
    )


def _captioned(cube: "xr.Dataset", answer: "xr.Dataset", shown: str) -> str:
    """Return the name of the quantity that a figure shows, with the unit."""
    return Phrases.of(cube).as_named(shown).shown(shown, answer[shown])


def _over_hertz(answer: "xr.Dataset", units: Mapping[str, InUnits]) -> "xr.Dataset":
    """Convert the frequencies of a curve to Hz if the study is given in SI units."""
    if "frequency_ratio" not in units:
        return answer
    each = units["frequency_ratio"]
    hertz = ("frequency_ratio", each.of(answer["frequency_ratio"].values), each.attributes)
    answer = answer.assign_coords(frequency_ratio=hertz)
    if "hybrid_better" in answer.attrs:
        better = [[end * each.factor for end in run] for run in answer.attrs["hybrid_better"]]
        exact = answer.attrs["exact"]
        exact = {**exact, "frequency_ratio": [r * each.factor for r in exact["frequency_ratio"]]}
        answer.attrs = {**answer.attrs, "hybrid_better": better, "exact": exact}
    return answer


def _in_metres(answer: "xr.Dataset", units: Mapping[str, InUnits]) -> "xr.Dataset":
    if "amplitude_ratio" not in units:
        return answer
    each = units["amplitude_ratio"]
    names = [name for name in ("hybrid", "tmd", "no_damper", "amplitude_error") if name in answer]
    answer = answer.assign(
        {name: ("frequency_ratio", each.of(answer[name].values), each.attributes) for name in names}
    )
    exact = dict(answer.attrs["exact"])
    exact |= {name: [x * each.factor for x in exact[name]] for name in ("tmd", "no_damper")}
    answer.attrs = {**answer.attrs, "exact": exact}
    return answer


def _cost(record: Record, cube: "xr.Dataset", worst_case: bool) -> Iterable[str]:
    rows = [
        ("time in kernels", f"{record.kernel_seconds:.4g} s"),
        (
            "time in blocks",
            f"{record.seconds:.4g} s in {record.blocks_done:,} of {record.blocks_total:,} blocks",
        ),
        ("points reused from earlier studies", f"{record.points_reused:,}"),
        ("finished", "not yet" if record.finished is None else f"{record.finished:%Y-%m-%d %H:%M} UTC"),
    ]
    if not worst_case:
        try:
            found = work_precision(cube)
        except QueryFault as refused:
            yield said(f"Errors: {refused.fault.found}.")
        else:
            number = found["number"].values
            limited = float(found["max_cycles_share"].values @ number)
            worst = max(found["error_high"].values.tolist(), default=float("nan"))
            rows += [
                (
                    "90 % quantile of the relative error, the largest over groups of similar run time",
                    f"{worst:.2g}",
                ),
                ("points that reached the cycle limit", f"{limited:.0f} of {int(number.sum()):,}"),
            ]
    yield table("Cost", ("What", "How much"), rows)
