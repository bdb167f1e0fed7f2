"""A study as one document to keep or to print: maps, designs, a tuned mass damper beside them, accuracy, cost, versions."""

import base64
import io
import json
from collections.abc import Iterable, Mapping
from html import escape
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from damperlab.studies.answers.faults import QueryFault
from damperlab.studies.answers.frequency_response import frequency_response
from damperlab.studies.answers.importance import importance
from damperlab.studies.answers.ranking import ranked_designs
from damperlab.studies.answers.resonance_map import resonance_map
from damperlab.studies.answers.selection import dimensions_of, main_metric
from damperlab.studies.answers.tmd_comparison import tmd_comparison
from damperlab.studies.answers.work_precision import work_precision
from damperlab.studies.kinds import SUITE, kind_of
from damperlab.studies.questions import Judging, Ranking, Selection, Varied
from damperlab.studies.store.record import Record
from damperlab.studies.units import InUnits, coordinates_in_units, results_in_units

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TOP = 5
MAPS = 3
"""Most maps: of the first three axes, each with each."""
PRIVATE = ("host", "user")
"""What a report, which may be handed on, leaves out of a study's provenance."""
STYLE = """
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, "Segoe UI", Roboto, "Noto Sans", sans-serif; color: #16202e; }
body { max-width: 56rem; margin: 2rem auto; padding: 0 1rem; }
h1 { line-height: 1.2; overflow-wrap: anywhere; } h2 { margin-top: 2rem; border-bottom: 1px solid #d5dbe3; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: .9rem; }
th, td { text-align: left; padding: .25rem .9rem .25rem 0; border-bottom: 1px solid #d5dbe3; vertical-align: baseline; }
.wide { overflow-x: auto; } figure { margin: 1rem 0; } figure img { max-width: 100%; height: auto; }
figcaption, .quiet { color: #4d5a6b; font-size: .9rem; }
pre { white-space: pre-wrap; overflow-wrap: anywhere; font-size: .8rem; }
@page { margin: 18mm 15mm; }
@media print { body { margin: 0; max-width: none; font-size: 10.5pt; } }
@media print { h2 { break-after: avoid; } figure, tr { break-inside: avoid; } }
"""


def study_report(record: Record, cube: xr.Dataset) -> str:
    """Write a study as one page of HTML that loads nothing.

    Parameters
    ----------
    record, cube : Record, Dataset
        The study, and its results as they are now.

    Returns
    -------
    str
        HTML; figures are in it as SVG. A study in SI units is told in them.
    """
    title = escape(record.name or record.id)
    suite = kind_of(cube.sizes) is SUITE
    ranked = ranked_designs(cube, Judging(), Ranking(top=TOP), lambda _: {})
    parts = [
        f"<h1>{title}</h1>",
        _said(
            f"Study {record.id}, {record.state}: {record.points_done:,} of {record.points_total:,} points, "
            f"{record.points_failed:,} failed."
        ),
        "<h2>Designs</h2>",
        *_designs(cube, ranked, suite),
        "<h2>Maps</h2>",
        *_maps(cube, None if suite else leading(ranked)),
    ]
    if not suite:
        parts += _best(cube, ranked)
    parts += [
        "<h2>What matters</h2>",
        *_matters(cube),
        "<h2>Accuracy and cost</h2>",
        *_cost(record, cube, suite),
    ]
    parts += [
        "<h2>Definition</h2>",
        f"<pre>{escape(json.dumps(record.definition, indent=2, ensure_ascii=False))}</pre>",
    ]
    versions = {name: text for name, text in record.provenance.items() if name not in PRIVATE}
    parts += ["<h2>Versions</h2>", _table("Versions of programs", ("What", "Version"), versions.items())]
    return (
        f'<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<title>{title} · damperlab</title>\n'
        f'<meta name="viewport" content="width=device-width">\n<style>{STYLE}</style>\n</head>\n<body>\n<main>\n'
        + "\n".join(parts)
        + "\n</main>\n</body>\n</html>\n"
    )


def leading(ranked: xr.Dataset) -> dict[str, Any] | None:
    """Give the design that a ranking leads to: the best whose damper does something, as the page and the verdict have it."""
    if ranked.sizes["rank"] == 0:
        return None
    first = {str(name): array.values[0].item() for name, array in ranked.variables.items()}
    acting = ranked.attrs.get("best_with_impacts")
    return dict(acting) if acting and first["impact_share"] == 0 else first


def _words(answer: xr.Dataset) -> Mapping[str, Any]:
    return {**answer.attrs, **answer.attrs.get("in_units", {})}


def _designs(cube: xr.Dataset, ranked: xr.Dataset, suite: bool) -> Iterable[str]:
    words = _words(ranked)
    yield from (_said(sentence) for sentence in words.get("verdict", ()))
    units = _units(cube)
    names = [name for name in dimensions_of(cube) if cube.sizes[name] > 1 and name in ranked.coords]
    value = units.get("amplitude_ratio")
    columns = [
        ("value" if suite else "amplitude_ratio", "value"),
        *([("amplitude_error", "error")] if "error" in ranked else []),
        *((name, name) for name in names),
    ]
    head = ["rank", *(_head(ranked, units, name, column, value) for name, column in columns)]
    rows = [_row(ranked, units, rank, columns) for rank in range(ranked.sizes["rank"])]
    best = None if suite else leading(ranked)
    if best is not None and best["value"] != ranked["value"].values[0]:
        cells = [_number(best[column], units.get(name)) for name, column in columns]
        rows.append(("best with impacts", *cells))
    yield _table("Ranking", head, rows)
    yield _said(words["note"], "quiet")


def _row(
    ranked: xr.Dataset, units: Mapping[str, InUnits], rank: int, columns: Iterable[tuple[str, str]]
) -> tuple[str, ...]:
    cells = (_number(ranked[column].values[rank], units.get(name)) for name, column in columns)
    return (str(rank + 1), *cells)


def _head(
    ranked: xr.Dataset, units: Mapping[str, InUnits], name: str, column: str, value: InUnits | None
) -> str:
    if name in units:
        return f"{units[name].name.removesuffix('_m').removesuffix('_n').replace('_', ' ')} [{units[name].units}]"
    unit = ranked[column].attrs.get("units", "1")
    return name.replace("_", " ") + ("" if unit in ("1", "") else f" [{unit}]")


def _number(value: Any, unit: InUnits | None) -> str:
    if isinstance(value, str | np.str_):
        return str(value)
    return f"{float(value) * (1.0 if unit is None else unit.factor):.6g}"


def _units(cube: xr.Dataset) -> dict[str, InUnits]:
    return {each.source: each for each in (*coordinates_in_units(cube), *results_in_units(cube))}


def _maps(cube: xr.Dataset, best: Mapping[str, Any] | None) -> Iterable[str]:
    """Draw maps through the design that the ranking leads to."""
    from damperlab.service.figures.resonance_map import draw_map

    kind = kind_of(cube.sizes)
    units = {source: each.name for source, each in _units(cube).items()}
    varied = [name for name in kind.axes if name in cube.sizes and cube.sizes[name] > 1]
    designs = [name for name in varied if name != kind.uncontrolled]
    axes = designs if len(designs) > 1 else varied
    metric = main_metric(cube)
    shown = units.get(metric, metric)
    if len(axes) < 2:
        yield _said("Only one parameter varies, so there is no map.")
    for x, y in list(combinations(axes, 2))[:MAPS]:
        at = {} if best is None else {name: best[name] for name in designs if name not in (x, y)}
        answer = resonance_map(cube, units.get(x, x), units.get(y, y), Selection(shown, at))
        yield _figure(
            draw_map(answer, shown), f"{answer[shown].attrs['long_name']}. {_words(answer)['note']}"
        )


def _best(cube: xr.Dataset, ranked: xr.Dataset) -> Iterable[str]:
    from damperlab.service.figures.comparison import draw_comparison
    from damperlab.service.figures.curves import draw_response

    best = leading(ranked)
    if best is None:
        return
    at = {name: best[name] for name in dimensions_of(cube) if name != "frequency_ratio"}
    yield "<h2>The design beside a tuned mass damper</h2>"
    units = _units(cube)
    shown = units["amplitude_ratio"].name if "amplitude_ratio" in units else "amplitude_ratio"
    curve = frequency_response(cube, Selection(shown, at))
    if curve.sizes["frequency_ratio"] > 1:
        yield _figure(
            draw_response(_over_hertz(curve, units), shown),
            f"{curve[shown].attrs['long_name']}. {_words(curve)['note']}",
        )
    try:
        compared = tmd_comparison(cube, at=at)
    except QueryFault as refused:
        yield _said(f"No comparison: {refused.fault.found}; {refused.fault.advice}.")
        return
    words = _words(compared)
    yield from (_said(sentence) for sentence in words["verdict"])
    yield _figure(draw_comparison(_in_metres(_over_hertz(compared, units), units)), words["note"])


def _over_hertz(answer: xr.Dataset, units: Mapping[str, InUnits]) -> xr.Dataset:
    """Give a curve over the frequency in Hz, where the study is given in units."""
    if "frequency_ratio" not in units:
        return answer
    each = units["frequency_ratio"]
    hertz = ("frequency_ratio", each.of(answer["frequency_ratio"].values), each.attributes)
    answer = answer.assign_coords(frequency_ratio=hertz)
    if "hybrid_better" in answer.attrs:
        better = [[end * each.factor for end in run] for run in answer.attrs["hybrid_better"]]
        answer.attrs = {**answer.attrs, "hybrid_better": better}
    return answer


def _in_metres(answer: xr.Dataset, units: Mapping[str, InUnits]) -> xr.Dataset:
    if "amplitude_ratio" not in units:
        return answer
    each = units["amplitude_ratio"]
    names = [name for name in ("hybrid", "tmd", "no_damper", "amplitude_error") if name in answer]
    return answer.assign(
        {name: ("frequency_ratio", each.of(answer[name].values), each.attributes) for name in names}
    )


def _matters(cube: xr.Dataset) -> Iterable[str]:
    from damperlab.service.figures.importance import draw_importance

    metric = main_metric(cube)
    units = _units(cube)
    answer = importance(cube, Varied(units[metric].name if metric in units else metric))
    if answer.sizes["dimension"] and np.isfinite(answer["share"]).all():
        names = [
            units[name].long_name if name in units else name for name in answer["dimension"].values.tolist()
        ]
        yield _figure(draw_importance(answer.assign_coords(dimension=names)), _words(answer)["note"])
    else:
        yield _said(_words(answer)["note"])


def _cost(record: Record, cube: xr.Dataset, suite: bool) -> Iterable[str]:
    rows = [
        ("time in kernels", f"{record.kernel_seconds:.4g} s"),
        (
            "time in blocks",
            f"{record.seconds:.4g} s in {record.blocks_done:,} of {record.blocks_total:,} blocks",
        ),
        ("points taken from earlier studies", f"{record.points_reused:,}"),
        ("finished", "not yet" if record.finished is None else f"{record.finished:%Y-%m-%d %H:%M} UTC"),
    ]
    if not suite:
        try:
            found = work_precision(cube)
        except QueryFault as refused:
            yield _said(f"Errors: {refused.fault.found}.")
        else:
            number = found["number"].values
            limited = float(found["max_cycles_share"].values @ number)
            worst = max(found["error_high"].values.tolist(), default=float("nan"))
            rows += [
                ("relative error that nine points in ten do not exceed, slowest bin", f"{worst:.2g}"),
                ("points that reached the cycle limit", f"{limited:.0f} of {int(number.sum()):,}"),
            ]
    yield _table("Cost", ("What", "How much"), rows)


def _said(text: str, kind: str = "") -> str:
    return f"<p{f' class={kind}' if kind else ''}>{escape(text)}</p>"


def _table(label: str, head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    heads = "".join(f'<th scope="col">{escape(text)}</th>' for text in head)
    body = "".join(
        "<tr>" + "".join(f"<td>{escape(str(cell))}</td>" for cell in row) + "</tr>" for row in rows
    )
    region = f'class="wide" tabindex="0" role="region" aria-label="{label}"'
    return f"<div {region}><table><thead><tr>{heads}</tr></thead><tbody>{body}</tbody></table></div>"


def _figure(figure: "Figure", caption: str) -> str:
    from damperlab.service.figures.style import styled

    drawn = io.BytesIO()
    for axes in figure.axes:
        axes.set_title("", loc="left")  # the caption says it, in the units of the study
    # letters as outlines: another machine's fonts are of other widths
    with styled({"svg.fonttype": "path"}):
        figure.savefig(drawn, format="svg", metadata={"Date": None})
    # in a picture of its own, so that the names of two drawings' parts are never mixed up
    data = base64.b64encode(drawn.getvalue()).decode()
    text = escape(caption)
    return f'<figure><img alt="{text}" src="data:image/svg+xml;base64,{data}"><figcaption>{text}</figcaption></figure>'
