"""Answers as sentences and tables."""

import math
from typing import TYPE_CHECKING, Any

from damperlab.service.cli.output import number
from damperlab.studies.brief import Brief
from damperlab.studies.kinds import EVERY_DIMENSION
from damperlab.studies.rounding import ROUNDING_WORD, is_rounding, value_of_error
from damperlab.studies.variables import VARIABLES, ResponseClass, Status

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    import xarray as xr
    from numpy.typing import NDArray

    from damperlab.studies.answers.phrases import Phrases

MAP_COLUMNS = 12
"""Largest number of columns of a map on a terminal; if columns are left out, a note says so."""

HEADINGS = {
    "locked_share": "frequencies locked",
    "impact_share": "frequencies with impacts",
    "alike": "equal designs",
}
"""Headings of columns that are not named as in the answer. Shares are written in per cent."""

Table = tuple[tuple[str, ...], list[tuple[str, ...]]]
"""Head and rows of a table."""


def cell(name: str, value: float | str) -> str:
    """Write one value of a variable: a code as its name, a number with six significant digits, a text unchanged."""
    if isinstance(value, str):
        return value
    name = name.removeprefix("other_")  # a variable of the second study in a comparison
    flags = VARIABLES[name].flags if name in VARIABLES else None
    return number(float(value)) if flags is None else flags(int(value)).name.lower()


def map_table(answer: "xr.Dataset", metric: str, phrases: "Phrases", variable: str | None = None) -> Table:
    """Return a table of a map, in which y increases upwards and x to the right, as in a figure.

    Parameters
    ----------
    answer : Dataset
        Map from `damperlab.studies.answers.resonance_map`, with dimensions (y, x).
    metric : str
        The mapped variable.
    phrases : Phrases
        Phrases of the study.
    variable : str, optional
        Variable that is shown in place of the metric, in the unit of the metric.
    """
    y, x = (str(name) for name in answer[metric].dims)
    step = -(-answer.sizes[x] // MAP_COLUMNS)
    shown = answer.isel({x: slice(None, None, step)})
    head = (
        " \\ ".join(_corner(name, phrases) for name in (y, x)),
        *(_spelled(x, value, phrases) for value in shown[x].values.tolist()),
    )
    rows = [
        (_spelled(y, at, phrases), *(_spelled(metric, value, phrases) for value in row))
        for at, row in zip(shown[y].values.tolist(), shown[variable or metric].values.tolist(), strict=True)
    ]
    return head, rows[::-1]


def map_brief(
    answer: "xr.Dataset", metric: str, phrases: "Phrases", subtracted: bool, sizes: "Mapping[Any, int]"
) -> Brief:
    """Describe the smallest and largest values of a map, or the largest difference of two maps.

    For a map of classes, give the share of each class.

    Parameters
    ----------
    answer : Dataset
        The map.
    metric : str
        The shown variable.
    phrases : Phrases
        Phrases of the study.
    subtracted : bool
        Whether the map is the difference of two maps.
    sizes : mapping of int
        Number of points along each dimension of the study. The text gives the value of each dimension that has several
        points and is no axis of the map, and the frequency even if it is the only one.
    """
    import numpy as np

    y, x = (str(name) for name in answer[metric].dims)
    values = answer["difference" if subtracted else metric].values
    known = values[np.isfinite(values)]
    if not known.size:
        return Brief(
            None, ("Nothing of this map is known yet.",), (), "compute the rest with `damperlab run`."
        )
    what = phrases.shown(metric, answer[metric]).partition(" in ")[0]
    fixed = [name for name in sizes if name in answer.coords and not answer[name].ndim]
    fixed = [name for name in fixed if sizes[name] > 1 or name == "frequency_ratio"]
    if fixed:
        what += f" at {', '.join(_at(str(name), answer[name].item(), phrases) for name in fixed)}"
    if (shares := _class_shares(metric, known, "places")) is not None:
        told = f"{what[:1].upper()}{what[1:]} over {known.size:,} places."
        return Brief(None, (told,), shares, "-o map.png")

    def spelled(place: int) -> tuple[str, str]:
        j, i = np.unravel_index(place, values.shape)
        at = ((x, answer[x].values[i]), (y, answer[y].values[j]))
        where = ", ".join(_at(name, value, phrases) for name, value in at)
        return phrases.value(metric, float(values[j, i]), ".3g"), where

    finite = np.where(np.isfinite(values), values, np.nan)
    least, largest = spelled(int(np.nanargmin(finite))), spelled(int(np.nanargmax(finite)))
    told = f"{what}: least {least[0]} at {least[1]}; largest {largest[0]} at {largest[1]}."
    if subtracted:
        from damperlab.studies.answers.map_difference import where_apart

        told = f"{what}, first study minus second study. {where_apart(answer, metric, phrases)}"
    unknown = values.size - known.size
    missing = f"{unknown:,} of {values.size:,} points have no value." if unknown else ""
    differ = words_of(answer).get("studies_differ", "")
    return Brief(
        None,
        (_extreme(answer), f"{told[:1].upper()}{told[1:]}", differ, missing),
        (),
        "-o map.png, or `damperlab optimum` for one damper.",
    )


def _at(name: str, value: Any, phrases: "Phrases") -> str:
    """Write the symbol of a dimension with a value, which is a text or a number."""
    if isinstance(value, str):
        return f"{phrases.symbol(name)} = {value}"
    return phrases.equal(name, float(value), ".3g")


def _class_shares(
    metric: str, known: "NDArray[Any]", points: str
) -> "tuple[tuple[str, str, str], ...] | None":
    """Return the share of each class, the most frequent first; None if the metric has no classes."""
    import numpy as np

    if metric not in VARIABLES or VARIABLES[metric].flags is None:
        return None
    codes, counts = np.unique(known, return_counts=True)
    often = sorted(zip(codes.tolist(), counts.tolist(), strict=True), key=lambda each: -each[1])
    return tuple(
        (cell(metric, code), f"{count / known.size:.0%}", f"of the {points}") for code, count in often
    )


def response_brief(
    answer: "xr.Dataset", metric: str, phrases: "Phrases", cavity: "Sequence[str]" = ()
) -> Brief:
    """Describe the smallest and largest values of a curve, and the difference from the curve of a second study.

    For a curve of classes, give the share of each class. `cavity` lists the assumptions of the study about the cavity.
    """
    import numpy as np

    values, frequency = answer[metric].values, answer["frequency_ratio"].values
    known = values[np.isfinite(values)]
    what = phrases.shown(metric, answer[metric]).partition(" in ")[0]
    what = f"{what[:1].upper()}{what[1:]}"
    unknown = completeness_sentence(answer)
    if not known.size:
        return Brief(
            None,
            (f"{what}: nothing is known yet.", unknown),
            (),
            "compute the rest with `damperlab run`.",
        )
    following = "-o response.png for the figure, -o response.csv for the table."
    if (shares := _class_shares(metric, known, "frequencies")) is not None:
        return Brief(None, (f"{what} at {known.size:,} frequencies.", unknown), shares, following)

    def told(place: int) -> str:
        value = phrases.value(metric, float(values[place]), ".3g")
        return f"{value} at {phrases.equal('frequency_ratio', float(frequency[place]), '.4g')}"

    largest, least = int(np.nanargmax(values)), int(np.nanargmin(values))
    first = f"{what}: largest {told(largest)}; least {told(least)}."
    second = str(words_of(answer)["note"])
    if "differs" in answer:
        from damperlab.studies.answers.compared_response import say_difference

        second = say_difference(answer, metric, phrases, ".4g")
    rows: tuple[tuple[str, str, str], ...] = ()
    if "acceleration_g" in answer.attrs:
        from damperlab.studies.answers.largest_acceleration import acceleration_row

        rows = (acceleration_row(answer.attrs["acceleration_g"], cavity),)
    return Brief(None, (_extreme(answer), first, second, unknown), rows, following)


def _extreme(answer: "xr.Dataset") -> str:
    """Say that responses are unbounded, or that friction clamps the structure at every point; otherwise empty."""
    status, kinds = answer["status"].values, answer.get("response_class")
    if count := int((status == Status.UNBOUNDED).sum()):
        return f"The response grows without bound at {count:,} of {status.size:,} points."
    if kinds is not None and bool((kinds.values == ResponseClass.LOCKED).all()):
        return "Friction clamps the structure to its base at every point: nothing is damped."
    return ""


def _corner(name: str, phrases: "Phrases") -> str:
    """Write the symbol of an axis with its unit."""
    unit = phrases.unit(name).strip()
    return f"{phrases.symbol(name)} [{unit}]" if unit else phrases.symbol(name)


def _spelled(name: str, value: float | str, phrases: "Phrases") -> str:
    return cell(name, value if isinstance(value, str) else phrases.printed(name, value))


def columns_left_out(answer: "xr.Dataset", metric: str) -> str:
    """Say which columns of a map `map_table` shows. The text is empty if the table shows all columns."""
    x = str(answer[metric].dims[1])
    step = -(-answer.sizes[x] // MAP_COLUMNS)
    if step == 1:
        return ""
    return f"The table shows one in {step} of the {answer.sizes[x]} columns; --json and -o FILE have all of them."


def rows_table(
    answer: "xr.Dataset",
    phrases: "Phrases",
    meant: "Mapping[str, str] | None" = None,
    varied: "Collection[str]" = (),
) -> Table:
    """Return a table of a one-dimensional answer, with one row for each value.

    Coordinates that have the same value in all rows are left out.

    Parameters
    ----------
    answer : Dataset
        Answer about one study.
    phrases : Phrases
        Phrases of the study.
    meant : mapping of str, optional
        For each name that occurs only in answers, a variable whose values are printed in the same format.
    varied : collection of str, optional
        Coordinates that are shown even if all rows have the same value, because nothing else shows the value.
    """
    (dimension,) = (str(name) for name in answer.sizes)
    names = [dimension] if dimension in EVERY_DIMENSION else []
    names += [
        name
        for name in EVERY_DIMENSION
        if name != dimension
        and name in answer.coords
        and answer[name].ndim == 1
        and (name in varied or len(set(answer[name].values.tolist())) > 1)
    ]
    names += [str(name) for name in answer.data_vars]
    means = {name: name for name in names} | dict(meant or {})

    def column(name: str) -> list[str]:
        if value := value_of_error(name, answer):
            return _errors(answer, value, name, means[name], phrases)
        values = answer[name].values.tolist()
        if name.endswith("_share"):
            return ["—" if math.isnan(share) else f"{100 * share:.0f} %" for share in values]
        return [_spelled(means[name], value, phrases) for value in values]

    head = tuple(HEADINGS.get(name) or phrases.column(name, means[name]) for name in names)
    return head, list(zip(*map(column, names), strict=True))


def _errors(answer: "xr.Dataset", value_name: str, name: str, means: str, phrases: "Phrases") -> list[str]:
    """Write a column of errors. An error that is only rounding is written as `ROUNDING_WORD`."""
    values = answer[value_name].values.tolist()
    return [
        ROUNDING_WORD if is_rounding(value, error) else _spelled(means, error, phrases)
        for value, error in zip(values, answer[name].values.tolist(), strict=True)
    ]


def axes_of(cube: "xr.Dataset") -> list[str]:
    """Return the names of the dimensions along which a study has more than one value."""
    return [str(name) for name, size in cube.sizes.items() if size > 1]


def words_of(answer: "xr.Dataset") -> "Mapping[str, Any]":
    """Return the attributes of an answer. If a text exists in SI units and in ratios, return the text in SI units."""
    return {**answer.attrs, **answer.attrs.get("in_units", {})}


def slice_sentence(answer: "xr.Dataset", metric: str, study: str, phrases: "Phrases") -> str:
    """Write a sentence that names the study, the metric and the slice of a map or a curve."""
    shown = phrases.shown(metric, answer[metric])
    reduced = (
        f", {answer.attrs['reduce']} over {phrases.label(answer.attrs['over'])}"
        if "over" in answer.attrs
        else ""
    )
    return f"{study}: {shown}{reduced}. {words_of(answer)['note']}"


def found_sentence(found: "Mapping[str, Any]", phrases: "Phrases") -> str:
    """Describe the result of a search: a design with its value, or the interval that contains a class boundary."""
    along = str(found.get("along", ""))
    parts = []
    for name, value in found.items():
        if name == "value":
            parts.append(f"value = {phrases.measured(value, found.get('error', math.nan))}")
        elif name == "along":
            parts.append(f"along {phrases.label(along)}")
        elif name in ("low", "high"):
            parts.append(f"{name} = {phrases.value(along, value)}")
        elif name != "error":
            parts.append(f"{name} = {value}" if isinstance(value, str) else _equal(name, value, phrases))
    return ", ".join(parts)


def completeness_sentence(answer: "xr.Dataset") -> str:
    """Say how many points of a slice are missing or have failed; the text is empty if there are none."""
    points, failed = int(answer.attrs["points"]), int(answer.attrs["points_failed"])
    missing = points - round(float(answer.attrs["complete"]) * points)
    phrases = []
    if missing:
        phrases.append(f"{missing:,} of {points:,} points are not computed yet.")
    if failed:
        kinds = {Status(int(code)) for code in answer["status"].values.ravel() if code > Status.MAX_CYCLES}
        why = f": {' '.join(kind.sentence for kind in sorted(kinds))}" if kinds else "."
        phrases.append(f"{failed:,} of {points:,} points failed{why}")
    return " ".join(phrases)


def _equal(name: str, value: float, phrases: "Phrases") -> str:
    return f"{phrases.label(name)} = {phrases.value(name, value)}"
