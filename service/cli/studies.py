"""Commands on the studies that are stored: studies, show, cancel, delete."""

from typing import TYPE_CHECKING, Annotated

import typer

from damperlab.service.cli.failures import CommandFailed
from damperlab.service.cli.options import AsJson, DataDir, StudyId, check_alone, check_name
from damperlab.service.cli.output import duration, note, print_json, print_table, say, working
from damperlab.service.cli.spelled import in_options
from damperlab.service.cli.store import label, open_store
from damperlab.studies.store.provenance import COARSE_OF
from damperlab.studies.variables import BEFORE, MADE_BY
from damperlab.studies.vocabulary import EXCITATIONS, STATES

if TYPE_CHECKING:
    from damperlab.studies.store.record import Record

LISTED_BY = dict.fromkeys(("axis", "from", "to"), "--within") | {
    name: f"--{name}" for name in ("state", "tag", "cursor")
}
"""What studies are listed by, as options."""


def studies(
    data_dir: DataDir = None,
    state: Annotated[
        str | None, typer.Option(help=f"Only studies in this state: {', '.join(STATES)}.")
    ] = None,
    name: Annotated[str | None, typer.Option(help="Only studies whose name contains this text.")] = None,
    tag: Annotated[
        str | None, typer.Option(help="Only studies with this tag; see `damperlab remark`.")
    ] = None,
    within: Annotated[
        str | None,
        typer.Option(
            metavar="NAME=LO,HI",
            help="Only studies whose values of this dimension reach into the range, as in clearance_ratio=2,5.",
        ),
    ] = None,
    coarse: Annotated[
        bool, typer.Option("--coarse", help="List the coarse grids too that large studies computed first.")
    ] = False,
    designs: Annotated[
        bool, typer.Option("--designs", help="List the studies too that designs and refinements asked for.")
    ] = False,
    limit: Annotated[int, typer.Option(min=1, max=1000, help="Largest number of studies to list.")] = 50,
    cursor: Annotated[
        str | None, typer.Option(help="Continue a list that was cut off: the cursor that it printed.")
    ] = None,
    named: Annotated[
        bool,
        typer.Option("--named", help="List the named studies that come with the program, ready to `run`."),
    ] = False,
    as_json: AsJson = False,
) -> None:
    """List the stored studies, newest first."""
    check_name("--state", state, STATES)
    if named:
        given = {"--state": state, "--name": name, "--tag": tag, "--within": within, "--cursor": cursor}
        check_alone(
            given | {"--coarse": coarse, "--designs": designs}, "stored studies, of which --named lists none"
        )
        _list_named(as_json)
        return
    from damperlab.studies.store.life_cycle.wanted import Wanted

    with in_options(LISTED_BY):
        wanted = Wanted(
            state,
            name,
            tag,
            *_read_range(within),
            coarse=coarse,
            designs=designs,
        )
        page = open_store(data_dir).page(limit, cursor, wanted)
    if as_json:
        print_json({"studies": [record.document() for record in page.records], "cursor": page.cursor})
        return
    if not page.records and page.cursor is None:
        narrowed = any(each is not None for each in (state, name, tag, within))
        advice = (
            "Without these options every study is listed."
            if narrowed
            else "`damperlab run figure-11` computes one."
        )
        note(f"No study matches. {advice}")
        return
    print_table(
        ("id", "name", "state", "tags", "points", "done", "failed", "created"),
        (
            (
                record.id,
                record.name,
                record.state
                + (", outdated" if record.outdated else "")
                + (f", priority {record.priority}" if record.priority else ""),
                " ".join(record.tags),
                str(record.points_total),
                str(record.points_done),
                str(record.points_failed),
                f"{record.created:%Y-%m-%d %H:%M:%S}",
            )
            for record in page.records
        ),
    )
    if page.cursor is not None:
        note(f"There are more: --cursor {page.cursor}")


def _list_named(as_json: bool) -> None:
    from damperlab.studies.reading import named_descriptions, named_studies

    words = named_descriptions()
    rows = [(name, study.points, words[name]) for name, study in named_studies().items()]
    if as_json:
        columns = ("name", "points", "description")
        print_json({"named": [dict(zip(columns, row, strict=True)) for row in rows]})
        return
    for name, points, description in rows:
        say(f"{name}: {points:,} points. {description}\n")


def remark(
    study: StudyId,
    data_dir: DataDir = None,
    tags: Annotated[
        str | None,
        typer.Option(help="All its tags from now on, with commas between them; an empty text for none."),
    ] = None,
    text: Annotated[
        str | None, typer.Option("--note", help="Its note from now on; an empty text for none.")
    ] = None,
    name: Annotated[
        str | None, typer.Option(help="What it is called from now on; its definition stays as it is.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Tag a study, to find it by with `studies --tag`, write a note to it, or rename it."""
    from damperlab.studies.remarks import read_remarks

    given = None if tags is None else [tag.strip() for tag in tags.split(",") if tag.strip()]
    every = {"tags": given, "note": text, "name": name}
    said = {key: value for key, value in every.items() if value is not None}
    if not said:
        raise typer.BadParameter(
            "found none of them; allowed: one or more", param_hint="--tags, --note, --name"
        )
    with in_options({key: f"--{key}" for key in every}):
        remarks = read_remarks(said)
    store = open_store(data_dir)
    record = store.remark(store.find(study).id, remarks)
    if as_json:
        print_json(record.document())
    else:
        say(summary(record))


def _read_range(within: str | None) -> "tuple[str | None, float | None, float | None]":
    """Read NAME=LO,HI; either end may be left out."""
    if within is None:
        return None, None, None
    name, _, ends = within.partition("=")
    low, comma, high = ends.partition(",")
    try:
        if not comma:
            raise ValueError
        first, last = (float(end) if end.strip() else None for end in (low, high))
        if None in (first, last) or first <= last:  # type: ignore[operator]
            return name.strip(), first, last
        raise typer.BadParameter(
            f"found {within!r}, allowed: lo not above hi; swap them", param_hint="--within"
        )
    except ValueError:
        raise typer.BadParameter(
            f"found {within!r}, allowed: a name, an equals sign, and two numbers of which one may be left out, as in "
            "clearance_ratio=2,5",
            param_hint="--within",
        ) from None


def show(
    study: StudyId,
    data_dir: DataDir = None,
    accuracy: Annotated[
        bool, typer.Option("--accuracy", help="Show the error of its points against their run time instead.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Show one study: its state, progress and definition."""
    if accuracy:
        from damperlab.service.cli.precision import precision

        precision(study, data_dir, as_json)
        return
    record = open_store(data_dir).find(study)
    if as_json:
        print_json(record.document())
    else:
        say(summary(record))


def cancel(study: StudyId, data_dir: DataDir = None, as_json: AsJson = False) -> None:
    """Stop a study wherever it runs; computed points are kept, and `resume` continues it."""
    store = open_store(data_dir)
    record = store.find(study)
    if record.state == "cancelled":
        note(f"Study {label(record)} is already cancelled.")
    elif record.ended:
        raise CommandFailed(
            "study-ended", f"study {label(record)} is {record.state} already; there is nothing to cancel."
        )
    else:
        record = store.set_state(record.id, "cancelled", only_from=("queued", "running"))
        note(
            f"Study {label(record)} is {record.state} at {record.points_done} of {record.points_total} points; "
            f"a process that runs it stops within seconds. Continue with: damperlab resume {record.id}"
        )
    if as_json:
        print_json(record.document())


def delete(
    study: StudyId,
    data_dir: DataDir = None,
    yes: Annotated[bool, typer.Option("--yes", "-y", help="Delete without asking.")] = False,
) -> None:
    """Delete a study and its cube for good."""
    store = open_store(data_dir)
    record = store.find(study)
    if not yes:
        question = f"Delete study {label(record)} with {record.points_done} computed points for good?"
        typer.confirm(question, abort=True, err=True)
    store.delete(record.id)
    note(f"Study {label(record)} is deleted.")
    with working("Removing its files; stopped, it is finished by the service, the next delete or gc"):
        store.bury()


def summary(record: "Record") -> str:
    """Describe a study in a few aligned lines.

    Parameters
    ----------
    record : Record
        As the store knows it.
    """
    share = 100 * record.points_done / record.points_total
    lines = [
        ("study", label(record)),
        ("state", record.state + (", outdated" if record.outdated else "")),
        (
            "points",
            f"{record.points_done} of {record.points_total} ({share:.4g} %), {record.points_failed} failed"
            + (f", {record.points_reused} reused from earlier studies" if record.points_reused else ""),
        ),
        ("blocks", f"{record.blocks_done} of {record.blocks_total}"),
        ("created", f"{record.created:%Y-%m-%d %H:%M:%S} UTC"),
    ]
    if record.priority:
        lines.insert(2, ("priority", str(record.priority)))
    if COARSE_OF in record.provenance:
        lines.append(("coarse grid", f"of {record.provenance[COARSE_OF]}"))
    if record.tags:
        lines.append(("tags", " ".join(record.tags)))
    if record.note:
        lines.append(("note", record.note))
    if record.started is not None and record.finished is not None:
        took = (record.finished - record.started).total_seconds()
        lines.append(
            ("finished", f"{record.finished:%Y-%m-%d %H:%M:%S} UTC, {duration(took)} after its start")
        )
    if record.kernel_seconds > 0.0:
        lines.append(
            ("in kernels", f"{duration(record.kernel_seconds)} of {duration(record.seconds)} in blocks")
        )
    if record.state == "running":
        lines.append(("time left", duration(record.seconds_left)))
    if record.message:
        lines.append(("message", record.message))
    if record.version > 1:
        lines.append(("version", str(record.version)))
    if record.outdated:
        lines.append(("outdated", f"computed by an earlier solver; damperlab recompute {record.id}"))
    if record.definition.get("excitation"):
        lines.append(("excitation", EXCITATIONS[record.definition["excitation"]]))
    records = [one["id"] for one in record.definition.get("records", [])]
    if records:
        lines.append(("records", ", ".join(records)))
    definition = record.definition
    given = {name: definition[name] for name in BEFORE if definition.get(name) is not None}
    physical = definition.get("physical") or {}
    given |= {name: value for name, value in physical.items() if name in MADE_BY.values()}
    for axis, value in (given | definition.get("axes", {})).items():
        lines.append((str(axis), _spell_axis(value)))
    width = max(len(label) for label, _ in lines)
    return "\n".join(f"{label:<{width}}  {text}" for label, text in lines)


def _spell_axis(value: object) -> str:
    if isinstance(value, dict):
        text = f"{value['start']:g} to {value['stop']:g}, {value['num']} values"
        return text + (", logarithmic" if value.get("spacing") == "log" else "")
    if isinstance(value, list):
        shown = ", ".join(f"{item:g}" for item in value[:6])
        return shown + (f", … ({len(value)} values)" if len(value) > 6 else "")
    return f"{value:g}" if isinstance(value, int | float) else str(value)
