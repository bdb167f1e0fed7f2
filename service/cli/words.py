"""Answers as sentences and tables for people."""

from typing import TYPE_CHECKING

from damperlab.service.cli.output import number
from damperlab.studies.ground.variables import DAMPER, RECORD
from damperlab.studies.registry import EVERY_DIMENSION
from damperlab.studies.variables import DIMENSIONS, VARIABLES, ResponseClass, Status

if TYPE_CHECKING:
    import xarray as xr

SYMBOLS = {
    "damping_ratio": "ζ",
    "restitution": "e",
    "mass_ratio": "β",
    "clearance_ratio": "d/Z",
    "friction_ratio": "γ_F",
    "frequency_ratio": "r",
}
"""The dimensions as the paper writes them."""

MAP_COLUMNS = 12
"""Most columns of a map on a terminal; what is left out is said."""

WITHOUT_IMPACTS = (ResponseClass.UNKNOWN, ResponseClass.LINEAR, ResponseClass.LOCKED, ResponseClass.NO_IMPACT)
ROUNDING = 1e-12
"""Of two values that are one response, computed with other parameters that do not act."""

Table = tuple[tuple[str, ...], list[tuple[str, ...]]]
"""Head and rows."""


def cell(name: str, value: float | str) -> str:
    """Spell one value of a variable: a code by its name, a number with six digits, a text as it is."""
    if isinstance(value, str):
        return value
    name = name.removeprefix("other_")  # of the second study, where two are compared
    flags = VARIABLES[name].flags if name in VARIABLES else None
    return number(float(value)) if flags is None else flags(int(value)).name.lower()


def map_table(answer: "xr.Dataset", metric: str) -> Table:
    """Lay a map out with y upwards and x across, as a figure has it.

    Parameters
    ----------
    answer : Dataset
        Of `damperlab.studies.answers.resonance_map`, dimensions (y, x).
    metric : str
        Which variable.
    """
    y, x = (str(name) for name in answer[metric].dims)
    step = -(-answer.sizes[x] // MAP_COLUMNS)
    shown = answer.isel({x: slice(None, None, step)})
    head = (f"{SYMBOLS.get(y, y)} \\ {SYMBOLS.get(x, x)}", *(f"{value:.6g}" for value in shown[x].values))
    rows = [
        (f"{shown[y].values[row]:.6g}", *(cell(metric, value) for value in shown[metric].values[row]))
        for row in reversed(range(shown.sizes[y]))
    ]
    return head, rows


def columns_left_out(answer: "xr.Dataset", metric: str) -> str:
    """Say which columns of a map `map_table` left out, if any."""
    x = str(answer[metric].dims[1])
    step = -(-answer.sizes[x] // MAP_COLUMNS)
    if step == 1:
        return ""
    return f"Every {step}th of {answer.sizes[x]} columns is shown; --json and -o FILE have all."


def rows_table(answer: "xr.Dataset") -> Table:
    """Lay an answer with one dimension out, one row for each of its values; what all rows share is left out."""
    (dimension,) = (str(name) for name in answer.sizes)
    names = [dimension] if dimension in DIMENSIONS else []
    names += [
        name
        for name in EVERY_DIMENSION
        if name != dimension
        and name in answer.coords
        and answer[name].ndim == 1
        and len(set(answer[name].values.tolist())) > 1
    ]
    names += [str(name) for name in answer.data_vars]
    columns = {name: answer[name].values.tolist() for name in names}
    head = tuple(f"{name} {SYMBOLS[name]}" if name in SYMBOLS else name for name in names)
    return head, [
        tuple(cell(name, columns[name][row]) for name in names) for row in range(answer.sizes[dimension])
    ]


def slice_sentence(answer: "xr.Dataset", metric: str, study: str) -> str:
    """Say what a map or a curve shows, and of what."""
    long_name = str(answer[metric].attrs.get("long_name", metric))
    reduced = f", {answer.attrs['reduce']} over {answer.attrs['over']}" if "over" in answer.attrs else ""
    return f"{study}: {long_name}{reduced}. {answer.attrs['note']}"


def completeness_sentence(answer: "xr.Dataset") -> str:
    """Say how much of a slice was computed and how much of it failed; nothing where all is well."""
    points, failed = int(answer.attrs["points"]), int(answer.attrs["points_failed"])
    missing = points - round(float(answer.attrs["complete"]) * points)
    phrases = []
    if missing:
        phrases.append(f"{missing} of {points} points are not computed yet.")
    if failed:
        kinds = {Status(int(code)) for code in answer["status"].values.ravel() if code > Status.MAX_CYCLES}
        phrases.append(
            f"{failed} of {points} points failed: {' '.join(kind.sentence for kind in sorted(kinds))}"
        )
    return " ".join(phrases)


def best_sentences(answer: "xr.Dataset") -> list[str]:
    """Say the optimum in words: where it is, what it is, how many are as good, and what the particle brings.

    Parameters
    ----------
    answer : Dataset
        Of `damperlab.studies.answers.optimal_designs`, with as many designs as there are.
    """
    if answer.sizes["rank"] == 0:
        return ["There is no optimum."]
    values = answer["value"].values
    errors = [0.0 if error != error else error for error in answer["error"].values.tolist()]
    kinds = answer["response_class"].values.tolist()
    sentences = [f"Optimum: {_design(answer, 0)}"]
    ties = sum(
        value - values[0] <= errors[0] + error + ROUNDING * abs(value)
        for value, error in zip(values[1:].tolist(), errors[1:], strict=True)
    )
    if ties:
        sentences.append(
            f"{ties} more {'design is' if ties == 1 else 'designs are'} as good within the errors."
        )
    if kinds[0] in WITHOUT_IMPACTS:
        active = next((rank for rank, kind in enumerate(kinds) if kind not in WITHOUT_IMPACTS), None)
        if active is not None:
            sentences.append(f"Best design with impacts: {_design(answer, active)}")
    return sentences


def worst_sentence(answer: "xr.Dataset") -> str:
    """Say which of a survey's dampers is best, and where its worst case is; nothing where none is left."""
    if answer.sizes["rank"] == 0:
        return ""
    best = answer.isel(rank=0)
    told = {str(name): best[name].item() for name in best.coords if name != "rank"}
    damper = ", ".join(f"{name} = {told.pop(name):.6g}" for name in DAMPER)
    record = told.pop(RECORD)
    case = ", ".join(f"{name} = {value:.6g}" for name, value in told.items())
    units = best["value"].attrs["units"]
    value = f"{float(best['value']):.6g}" + ("" if units == "1" else f" {units}")
    return f"Best damper: {damper}. Its worst case, {value}, is under {record} at {case}."


def _design(answer: "xr.Dataset", rank: int) -> str:
    design = answer.isel(rank=rank)
    error = float(design["error"])
    doubt = f" ± {error:.2g}" if error == error else ""
    fixed = [name for name in DIMENSIONS if name != "frequency_ratio"]
    at = ", ".join(f"{SYMBOLS[name]} = {float(design[name]):.6g}" for name in fixed)
    # unknown is the class of a computed design only where the study does not store it
    kind = ResponseClass(int(design["response_class"]))
    said = kind.sentence if kind is not ResponseClass.UNKNOWN else ""
    r = f"{SYMBOLS['frequency_ratio']} = {float(design['frequency_ratio']):.6g}"
    value = f"{float(design['value']):.6g}{doubt}"
    if answer.attrs["frequencies"] == 1:
        return f"X/Z = {value} at {at}, {r}. {said}".strip()
    largest = f"At its largest, {r}: {said}" if said else f"It is largest at {r}."
    return f"{design['value'].attrs['long_name']} {value} at {at}. {largest}"
