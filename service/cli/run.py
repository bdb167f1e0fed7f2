"""`damperlab run` computes a study in this process or with Dask workers."""

from collections.abc import Mapping
from contextlib import ExitStack, closing, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from damperlab.service.cli.computing import NO_LIMITS, Computer, Limits, Means, computes
from damperlab.service.cli.failures import FAILED
from damperlab.service.cli.options import (
    AsJson,
    Budget,
    DataDir,
    Priority,
    QuotaBytes,
    StoreAddress,
    Until,
    read_time,
)
from damperlab.service.cli.output import duration, note, print_json, say, working
from damperlab.service.cli.store import data_folder, find_study, has_store, label, open_store, settings_of
from damperlab.service.cli.studies import summary
from damperlab.service.cli.verify import require_own_solver
from damperlab.studies.faults import counted

if TYPE_CHECKING:
    from damperlab.studies.kind import AnyStudy
    from damperlab.studies.store.record import Record
    from damperlab.studies.store.store import Store

BYTES_PER_MEGABYTE = 1e6
SHORT = 0.1
"""Run time below which no estimate is printed [s], because estimates are rounded to tenths of a second."""


@computes
def run(
    study: Annotated[
        str,
        typer.Argument(
            metavar="STUDY",
            help="A .json or .yaml file; a named study (`damperlab studies --named` lists them); or the id "
            "or name of a stored one, to continue it.",
        ),
    ],
    data_dir: DataDir = None,
    *,
    means: Means,
    place: StoreAddress = None,
    quota: QuotaBytes = None,
    budget: Budget = None,
    until: Until = None,
    priority: Priority = 0,
    dry_run: Annotated[
        bool,
        typer.Option(
            "--dry-run", help="Print the size of the study and its expected run time; store nothing."
        ),
    ] = False,
    reuse: Annotated[
        bool, typer.Option("--reuse/--no-reuse", help="Reuse points already computed by earlier studies.")
    ] = True,
    retry: Annotated[
        bool,
        typer.Option(
            "--retry",
            help="Compute again the blocks that failed as a whole, for example because a worker died.",
        ),
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Compute a study, or continue a stored one.

    Stored points are not computed again.
    """
    ends = read_time(until)
    from damperlab.studies.ground.shelf import Shelf
    from damperlab.studies.reading import read_study
    from damperlab.studies.store.cube.definition import parse_stored

    record = _stored(study, data_dir)
    if record is None:
        asked = read_study(study, Shelf(data_folder(data_dir)))
    else:
        asked = parse_stored(record.definition, record.digest)
    if dry_run:
        _print_size(asked, data_dir, as_json)
        return
    if record is None and not as_json:
        from damperlab.studies.understood import understood

        for line in understood(asked):
            note(line)
    store = open_store(data_dir, store=place, quota_bytes=quota)
    reuse = reuse and settings_of(data_dir).reuse
    record = record or find_or_submit(store, asked, reuse, priority=priority)
    if retry:
        record = store.retry(record.id)
    with Computer(store, means) as computer:
        finish(computer, record, as_json, Limits(budget, ends))


def _stored(study: str, data_dir: Path | None) -> "Record | None":
    """Find a stored study by its id or name.

    Return None if the text names a file or a built-in study, or if no stored study has this id or name.
    """
    from damperlab.studies.reading import is_known
    from damperlab.studies.store.faults import StudyNotFound

    if is_known(study) or not has_store(data_dir):
        return None
    with closing(open_store(data_dir)) as store:
        try:
            return find_study(store, study)
        except StudyNotFound as error:
            # the error is raised again if the text resembles a stored name, or if several ids begin with the text
            if "damperlab studies" not in error.fault.advice:
                raise
    return None


def find_or_submit(
    store: "Store",
    asked: "AnyStudy",
    reuse: bool,
    more: "Mapping[str, str] | None" = None,
    priority: int = 0,
) -> "Record":
    """Return the record of a study. If the study is not in the store, it is submitted.

    Parameters
    ----------
    store : Store
        The store.
    asked : AnyStudy
        The study.
    reuse : bool
        Whether to reuse points of earlier studies.
    more : mapping, optional
        Additional provenance of a new study.
    priority : int
        Priority of a new study.
    """
    known = store.newest(asked.digest)
    if known is not None:
        return known
    # only a new study needs a plan and the cost model
    from damperlab.studies.plan import make_plan
    from damperlab.worker.dispatch.cost_model import seconds_per_point
    from damperlab.worker.provenance import provenance

    with working("Planning"):
        plan = make_plan(asked, seconds_per_point)
        record, _ = store.submit(asked, plan, provenance() | dict(more or {}), reuse=reuse, priority=priority)
    return record


def finish(
    computer: Computer,
    record: "Record",
    as_json: bool,
    limits: Limits = NO_LIMITS,
) -> None:
    """Compute the missing points of a study, and print its record."""
    store = computer.store
    # blocks that are marked as done but have lost their files are reported and computed again
    lost = store.lost_blocks(record.id)
    if lost:
        require_own_solver(record)
        note(
            f"Study {label(record)} has lost the files of {counted(len(lost), 'block')}; computing them again."
        )
    elif record.state != "done" and record.blocks_done and record.outdated:
        require_own_solver(record)
    if record.state == "done" and not lost:
        note(f"Study {label(record)} is complete; nothing was computed.")
        if record.outdated:
            note(
                "An earlier solver computed it. To compute it with today's solver and keep both versions: "
                f"damperlab recompute {record.id}"
            )
    else:
        record = computer.compute(record, limits)
    if as_json:
        print_json(record.document())
    else:
        say(summary(record))
    if record.state != "done":
        left = record.points_total - record.points_done
        note(
            f"damperlab: study {label(record)} is {record.state} with {left:,} points left; computed points are kept. "
            f"Continue with: {computer.go_on(record.id)}"
        )
        raise typer.Exit(FAILED)


def _print_size(asked: "AnyStudy", data_dir: Path | None, as_json: bool) -> None:
    """Print the size and the expected run time of a study."""
    from damperlab.service.estimates import estimate_document
    from damperlab.studies.plan import make_plan
    from damperlab.studies.store.faults import StoreFault
    from damperlab.worker.dispatch.cost_model import seconds_per_point

    with working("Planning"), ExitStack() as stack:
        store = None
        if has_store(data_dir):
            # stored studies improve the estimate; a missing store is not created
            with suppress(StoreFault):
                store = stack.enter_context(closing(open_store(data_dir)))
        size = estimate_document(asked, make_plan(asked, seconds_per_point), store)
    if as_json:
        print_json(size)
    else:
        compiling = size["compiling_seconds"]
        first = f", {duration(compiling)} of it for kernels that are compiled first" if compiling else ""
        low, high = duration(size["seconds_low"]), duration(size["seconds_high"])
        around = f" (between {low} and {high})"
        taken = f"about {duration(size['seconds'])} of one core{first}{around}"
        if size["seconds_high"] < SHORT:
            taken = f"less than {SHORT:g} s of one core"
        elif size["seconds_low"] < SHORT:
            taken = f"at most {high} of one core{first}"
        say(
            f"{asked.name or 'The study'}: {counted(size['points'], 'point')} in {counted(size['blocks'], 'block')}, "
            f"{size['bytes'] / BYTES_PER_MEGABYTE:.3g} MB before compression, {taken}. Nothing was stored."
        )
        if size["points_stored"]:
            say(f"Already stored: {size['points_stored']:,} of {counted(size['points'], 'point')}.")
        for line in size["understood"]:
            say(line)
