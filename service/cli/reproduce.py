"""`damperlab check paper` computes the paper's figures and tables again, and writes one report."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from damperlab.service.cli.computing import Computer, Means, computes
from damperlab.service.cli.failures import CommandFailed
from damperlab.service.cli.options import AsJson, DataDir
from damperlab.service.cli.output import duration, note, number, print_json, print_table, say
from damperlab.service.cli.places import folder_option
from damperlab.service.cli.run import find_or_submit
from damperlab.service.cli.store import label, open_store, settings_of

if TYPE_CHECKING:
    import xarray as xr

    from damperlab.service.reproduction.section import Solve
    from damperlab.studies.definition import Study

REPORT = "reproduction"


@computes
def reproduce(
    output: Annotated[
        Path,
        folder_option(
            "--output",
            "-o",
            help=f"Folder of the report: {REPORT}.md, {REPORT}.json and PNGs.",
        ),
    ] = Path(REPORT),
    data_dir: DataDir = None,
    *,
    means: Means,
    quick: Annotated[
        bool, typer.Option("--quick", help="Compute coarse grids only, to try the command.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Compute the paper's figures and tables again.

    Every number is compared with the published number. The studies are stored, so a second run computes only missing
    points.
    """
    output.mkdir(parents=True, exist_ok=True)
    from damperlab.service.documents import plain
    from damperlab.service.figures.style import save
    from damperlab.service.reproduction.report import in_markdown, make_report

    with _solver(data_dir, means) as solve:
        report, figures = make_report(solve, quick, lambda what: note(f"Reproducing {what} …"))
    report = plain(report)
    for name, figure in figures.items():
        save(figure, output / name)
    (output / f"{REPORT}.json").write_text(
        json.dumps(report, indent=1, ensure_ascii=False) + "\n", encoding="utf-8"
    )
    (output / f"{REPORT}.md").write_text(in_markdown(report), encoding="utf-8")
    note(
        f"Wrote {output / REPORT}.md, {REPORT}.json and {len(figures)} PNGs in {duration(report['seconds'])}."
    )
    if as_json:
        print_json(report)
    else:
        _print(report)


@contextmanager
def _solver(data_dir: Path | None, means: Means) -> "Iterator[Solve]":
    """Yield a function that computes studies.

    All studies share one cluster, which is started for the first study that needs a cluster.
    """
    store = open_store(data_dir)
    reuse = settings_of(data_dir).reuse
    with Computer(store, means) as computer:

        def solve(study: "Study") -> "xr.Dataset":
            record = find_or_submit(store, study, reuse)
            if record.state != "done":
                record = computer.compute(record)
            if record.state != "done":
                left = record.points_total - record.points_done
                raise CommandFailed(
                    "stopped",
                    f"study {label(record)} is {record.state} with {left:,} points left; computed points are kept. "
                    "Run the same command again to continue.",
                )
            return store.cube(record.id)

        yield solve


def _print(report: dict[str, Any]) -> None:
    """Print the rows for which the paper gives a number, in one table per section."""
    for section in report["sections"]:
        rows = [row for row in section["rows"] if row["paper"] is not None]
        if not rows:
            continue
        say(f"\n{section['title']}")
        print_table(
            ("quantity", "paper", "ours", "difference", "contact", "assumption"),
            (
                (
                    row["quantity"],
                    number(row["paper"]),
                    "—" if row["ours"] is None else number(row["ours"]),
                    "" if row["difference"] is None else f"{row['difference']:+.1%}",
                    row["contact"],
                    row["assumption"],
                )
                for row in rows
            ),
        )
