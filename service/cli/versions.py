"""`damperlab recompute` computes an outdated study again with the present solver."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

from damperlab.service.cli.computing import Computer, Means, computes
from damperlab.service.cli.failures import FAILED
from damperlab.service.cli.options import AsJson, DataDir, StudyId
from damperlab.service.cli.output import note, number, print_json, print_table, say, working
from damperlab.service.cli.store import find_study, label, open_store

if TYPE_CHECKING:
    from damperlab.studies.store.differences import Differences


@computes
def recompute(
    study: StudyId,
    data_dir: DataDir = None,
    *,
    means: Means,
    replace: Annotated[
        bool, typer.Option("--replace/--keep", help="Delete the older version once the new one is complete.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Compute an outdated study with today's solver.

    The older version is kept by default, and the command lists the differences.
    """
    from damperlab.studies.faults import counted
    from damperlab.studies.store.differences import differences_of
    from damperlab.worker.provenance import provenance

    store = open_store(data_dir)
    older = find_study(store, study)
    newer, created = store.recompute(older.id, provenance())
    if not created:
        note(f"Version {newer.version} of study {label(older)} is {newer.state}: {newer.id}.")
    if newer.state != "done":
        with Computer(store, means) as computer:
            newer = computer.compute(newer)
    with working("Comparing"):
        found = differences_of(store, newer, older)
    failed = len(store.given_up(newer.id))
    replaced = replace and newer.state == "done" and not failed
    if as_json:
        print_json({**newer.document(), "differences": found.document(), "replaced": replaced})
    else:
        _show(found)
    if newer.state != "done":
        note(
            f"damperlab: study {label(newer)} is {newer.state}; both versions are kept. "
            f"Continue with: damperlab recompute {older.id} --data-dir {store.data_dir}"
        )
        raise typer.Exit(FAILED)
    if replaced:
        store.delete(older.id)
        with working("Removing files"):
            store.bury()
        note(f"Version {older.version} of study {label(older)} is deleted; {newer.id} has taken its place.")
    elif replace:
        note(
            f"damperlab: {counted(failed, 'block')} of study {label(newer)} failed as a whole; both versions are kept. "
            f"Compute them with: damperlab run {newer.id} --retry --data-dir {store.data_dir}"
        )
        raise typer.Exit(FAILED)
    else:
        note(
            f"Both versions are kept: {older.id} and {newer.id}. Delete the older one with: damperlab delete {older.id}"
        )


def _show(found: "Differences") -> None:
    from damperlab.studies.store.differences import words

    for sentence in words(found):
        say(sentence)
    rows = [
        (
            each.variable,
            str(each.points),
            "" if each.largest_relative is None else f"{each.largest_relative:.3g}",
            _value(each.older),
            _value(each.newer),
            ", ".join(f"{name} = {_value(value)}" for name, value in (each.at or {}).items()),
        )
        for each in found.variables
        if each.points
    ]
    if rows:
        print_table(("variable", "points", "largest relative", "older", "newer", "at"), rows)


def _value(value: Any) -> str:
    return value if isinstance(value, str) else "nan" if value is None else number(float(value))
