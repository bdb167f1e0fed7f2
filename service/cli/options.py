"""Arguments and options that several commands share, and how their values are read."""

from pathlib import Path
from typing import Annotated

import typer

from studies.variables import DIMENSIONS

DataDir = Annotated[
    Path | None,
    typer.Option(
        "--data-dir",
        help="Folder of the catalogue and the cubes; DAMPERLAB_DATA_DIR or ~/.local/share/damperlab by default.",
    ),
]

StudyId = Annotated[
    str,
    typer.Argument(metavar="ID", help="A study's id, the start of it, or its name.", show_default=False),
]
AsJson = Annotated[
    bool, typer.Option("--json", help="One JSON document on standard output, nothing else there.")
]
Workers = Annotated[
    int | None,
    typer.Option(min=1, help="Worker processes of the embedded Dask cluster; one per core by default."),
]
Scheduler = Annotated[
    str | None,
    typer.Option(metavar="ADDRESS", help="Work on this Dask scheduler (tcp://host:8786) instead."),
]
At = Annotated[
    list[str] | None,
    typer.Option(
        metavar="DIMENSION=VALUE",
        help="Fix a dimension at the grid point nearest to a value; may be repeated.",
    ),
]


FIGURES = (".png", ".svg", ".pdf", ".csv")
"""What -o writes, by the suffix of the file."""


def check_cluster(workers: int | None, scheduler: str | None) -> None:
    """Refuse a number of workers for a scheduler that brings its own."""
    if workers is not None and scheduler is not None:
        raise typer.BadParameter(
            "found both --workers and --scheduler; a scheduler brings its own workers: leave one of them out"
        )


def read_at(assignments: list[str] | None) -> dict[str, float]:
    """Read `--at dimension=value …` into a mapping."""
    return {name: _float("--at", text) for name, text in _pairs("--at", assignments)}


def read_within(assignments: list[str] | None) -> dict[str, tuple[float, float]]:
    """Read `--within dimension=lo,hi …` into a mapping of ranges."""
    return {name: read_range("--within", text) for name, text in _pairs("--within", assignments)}


def read_range(option: str, text: str) -> tuple[float, float]:
    """Read `lo,hi`."""
    parts = text.split(",")
    if len(parts) != 2:
        raise typer.BadParameter(f"found {text!r}, allowed: two numbers, lo,hi", param_hint=option)
    low, high = (_float(option, part) for part in parts)
    if not low <= high:
        raise typer.BadParameter(f"found {text!r}, allowed: lo not above hi; swap them", param_hint=option)
    return low, high


def check_name(option: str, name: str | None, allowed: tuple[str, ...]) -> None:
    """Refuse a name that is not among `allowed`."""
    if name is not None and name not in allowed:
        raise typer.BadParameter(f"found {name!r}, allowed: {', '.join(allowed)}", param_hint=option)


def check_file(output: Path | None, suffixes: tuple[str, ...] = FIGURES) -> None:
    """Refuse, before any work is done, a file whose format nothing here writes."""
    if output is not None and output.suffix not in suffixes:
        raise typer.BadParameter(
            f"found {output.name!r}, allowed: a name that ends in {', '.join(suffixes)}", param_hint="-o"
        )


def _pairs(option: str, assignments: list[str] | None) -> list[tuple[str, str]]:
    pairs = []
    for assignment in assignments or []:
        name, equals, text = assignment.partition("=")
        if not equals:
            raise typer.BadParameter(f"found {assignment!r}, allowed: dimension=value", param_hint=option)
        check_name(option, name, DIMENSIONS)
        pairs.append((name, text))
    return pairs


def _float(option: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not abs(value) < float("inf"):
        raise typer.BadParameter(f"found {text!r}, allowed: a finite number", param_hint=option)
    return value
