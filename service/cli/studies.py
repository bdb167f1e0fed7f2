"""Commands on stored studies: studies, show, cancel, delete."""

import json
from typing import TYPE_CHECKING, Annotated

import typer

from damperlab.service.cli.failures import CommandFailed
from damperlab.service.cli.options import AsJson, DataDir, StudyId, check_alone, check_name
from damperlab.service.cli.output import duration, note, print_json, print_table, say, working
from damperlab.service.cli.spelled import in_options
from damperlab.service.cli.store import (
    data_folder,
    find_study,
    folder_option,
    label,
    note_namesakes,
    open_store,
)
from damperlab.studies.vocabulary import EXCITATIONS, STATES

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from damperlab.studies.store.record import Record

LISTED_BY = dict.fromkeys(("axis", "from", "to"), "--within") | {
    name: f"--{name}" for name in ("state", "tag", "cursor")
}
"""Command-line option for each filter of the list of studies."""


def studies(
    data_dir: DataDir = None,
    state: Annotated[
        str | None, typer.Option(help=f"Only studies in this state: {', '.join(STATES)}.")
    ] = None,
    name: Annotated[str | None, typer.Option(help="Only studies whose name contains this text.")] = None,
    tag: Annotated[
        str | None, typer.Option(help="Only studies with this tag; see `damperlab show --tags`.")
    ] = None,
    within: Annotated[
        str | None,
        typer.Option(
            metavar="NAME=LO,HI",
            help="Only studies whose values of a dimension overlap a range, as in clearance_ratio=2,5.",
        ),
    ] = None,
    designs: Annotated[
        bool, typer.Option("--designs", help="Also list the studies of designs and refinements.")
    ] = False,
    trash: Annotated[
        bool, typer.Option("--trash", help="List deleted studies that can be restored.")
    ] = False,
    limit: Annotated[int, typer.Option(min=1, max=1000, help="Largest number of studies to list.")] = 50,
    cursor: Annotated[
        str | None,
        typer.Option(help="Continue a list that was cut off. Give the cursor that the list printed."),
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
            given | {"--designs": designs, "--trash": trash},
            "the list of stored studies, which --named replaces",
        )
        _list_named(as_json)
        return
    from damperlab.studies.store.life_cycle.lookup import Wanted

    axis, low, high = _read_range(within)
    with in_options(LISTED_BY):
        wanted = Wanted(
            state=state,
            name=name,
            tag=tag,
            axis=axis,
            low=low,
            high=high,
            designs=designs,
            trash=trash,
        )
        page = open_store(data_dir).page(limit, cursor, wanted)
    if as_json:
        print_json({"studies": [record.document() for record in page.records], "cursor": page.cursor})
        return
    if not page.records and page.cursor is None:
        if trash:
            note("No study is in the trash.")
            return
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


def _read_range(within: str | None) -> "tuple[str | None, float | None, float | None]":
    """Read NAME=LO,HI, where either number may be omitted."""
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
    tags: Annotated[
        str | None,
        typer.Option(help="Set the tags of the study, separated by commas; an empty text removes them."),
    ] = None,
    text: Annotated[
        str | None, typer.Option("--note", help="Set the note of the study; an empty text removes the note.")
    ] = None,
    name: Annotated[str | None, typer.Option(help="Rename the study; the definition is unchanged.")] = None,
    as_json: AsJson = False,
) -> None:
    """Show the state, progress and definition of a study. Options set its tags, its note or its name."""
    given = None if tags is None else [tag.strip() for tag in tags.split(",") if tag.strip()]
    changes = {"tags": given, "note": text, "name": name}
    said = {key: value for key, value in changes.items() if value is not None}
    remarks = None
    if said:
        from damperlab.studies.remarks import read_remarks

        with in_options({key: f"--{key}" for key in changes}):
            remarks = read_remarks(said)
    store = open_store(data_dir)
    record = find_study(store, study)
    if remarks is not None:
        record = store.remark(record.id, remarks)
        if name:
            note_namesakes(store, record)
    if as_json:
        print_json(record.document())
    else:
        say(summary(record, _defined(record)))


def cancel(study: StudyId, data_dir: DataDir = None, as_json: AsJson = False) -> None:
    """Stop a study, whichever machine computes it.

    Computed points are kept, and `damperlab run ID` continues with them.
    """
    store = open_store(data_dir)
    record = find_study(store, study)
    if record.state == "cancelled":
        note(f"Study {label(record)} is already cancelled.")
    elif record.ended:
        raise CommandFailed(
            "study-ended", f"study {label(record)} is {record.state} already; there is nothing to cancel."
        )
    else:
        record = store.set_state(record.id, "cancelled", only_from=("queued", "running"))
        note(
            f"Study {label(record)} is {record.state} at {record.points_done:,} of {record.points_total:,} points; "
            f"a process that runs it stops within seconds. Continue with: damperlab run {record.id}"
        )
    if as_json:
        print_json(record.document())


def delete(
    study: StudyId,
    data_dir: DataDir = None,
    yes: Annotated[bool, typer.Option("--yes", "-y", help="Delete without asking.")] = False,
    trash: Annotated[bool, typer.Option("--trash", help="Move the study to the trash for a week.")] = False,
) -> None:
    """Delete a study and its cube permanently, or move it to the trash."""
    from damperlab.studies.store.record import TRASH_DAYS

    store = open_store(data_dir)
    record = find_study(store, study)
    if trash:
        store.delete(record.id, 86_400.0 * TRASH_DAYS)
        restore = f"damperlab undelete {record.id}{folder_option(data_folder(data_dir))}"
        note(f"Study {label(record)} is in the trash. Restore it with: {restore}")
        return
    several = study == record.name and store.namesakes(record)
    # a command that is repeated would delete another version of the study
    earlier = study != record.id and store.existed(study)
    if yes and (several or earlier):
        what = "the name of several studies" if several else f"an earlier version of {record.id}"
        message = f"found {study}, {what}; allowed with --yes: an id, from `damperlab studies`"
        raise typer.BadParameter(message, param_hint="STUDY")
    if not yes:
        question = f"Delete study {label(record)} with {record.points_done:,} computed points for good?"
        typer.confirm(question, abort=True, err=True)
    store.delete(record.id)
    note(f"Study {label(record)} is deleted.")
    with working(
        "Removing its files. If you interrupt this, the service, the next delete or gc removes the rest"
    ):
        store.bury()


def undelete(
    study: Annotated[
        str,
        typer.Argument(
            metavar="STUDY", help="Id or name of a deleted study, from `damperlab studies --trash`."
        ),
    ],
    data_dir: DataDir = None,
) -> None:
    """Restore a study from the trash."""
    store = open_store(data_dir)
    record = store.undelete(store.trashed(study).id)
    note(f"Study {label(record)} is restored.")


def summary(record: "Record", more: "Iterable[tuple[str, str]]" = ()) -> str:
    """Describe a study in a few aligned lines.

    Parameters
    ----------
    record : Record
        Record of the study in the store.
    more : iterable of (str, str)
        Titles and texts of further lines.
    """
    share = 100 * record.points_done / record.points_total
    lines = [
        ("study", label(record)),
        ("state", record.state + (", outdated" if record.outdated else "")),
        (
            "points",
            f"{record.points_done:,} of {record.points_total:,} ({share:.4g} %), {record.points_failed:,} failed"
            + (f", {record.points_reused:,} reused from earlier studies" if record.points_reused else ""),
        ),
        ("blocks", f"{record.blocks_done} of {record.blocks_total}"),
        ("created", f"{record.created:%Y-%m-%d %H:%M:%S} UTC"),
    ]
    if record.priority:
        lines.insert(2, ("priority", str(record.priority)))
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
    lines += more
    width = max(len(label) for label, _ in lines)
    return "\n".join(f"{label:<{width}}  {text}" for label, text in lines)


def _defined(record: "Record") -> "Iterator[tuple[str, str]]":
    """Yield the title and the text of each line that describes a study's definition.

    Values equal to defaults are omitted.
    """
    from damperlab.studies.definition import Study

    plain = Study(axes={"clearance_ratio": 1, "frequency_ratio": 1}).document() | {"damping_ratio": None}
    for key, value in record.definition.items():
        if key in ("axes", "physical"):
            yield from ((name, _spell(one)) for name, one in value.items())
        elif key == "excitation":
            yield (key, EXCITATIONS[value])
        elif key == "records":
            yield (key, ", ".join(one["id"] for one in value))
        elif key != "name" and value != plain.get(key):
            yield (key, _spell(value))


def _spell(value: object) -> str:
    """Write a value of a definition on one line."""
    if isinstance(value, dict) and "num" in value:
        text = f"{value['start']:g} to {value['stop']:g}, {value['num']} values"
        return text + (", logarithmic" if value.get("spacing") == "log" else "")
    if isinstance(value, dict):
        return ", ".join(f"{name} {_spell(one)}" for name, one in value.items())
    if isinstance(value, list):
        return ", ".join(map(_spell, value[:6])) + (f", … ({len(value)} values)" if len(value) > 6 else "")
    return f"{value:g}" if isinstance(value, float) else json.dumps(value).strip('"')
