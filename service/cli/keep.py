"""Commands for maintaining the store: backup, restore, rebuild, gc."""

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from damperlab.service.cli.failures import FAILED
from damperlab.service.cli.options import AsJson, DataDir, StoreAddress
from damperlab.service.cli.output import note, print_json, working
from damperlab.service.cli.store import open_store, settings_of

if TYPE_CHECKING:
    from damperlab.studies.store.store import Store

_UNITS = {"s": 1.0, "min": 60.0, "h": 3600.0, "d": 86_400.0}


def backup(
    folder: Annotated[Path, typer.Argument(help="Folder to create, or an earlier backup.")],
    data_dir: DataDir = None,
    as_json: AsJson = False,
) -> None:
    """Copy every study, even while studies run; an earlier backup is updated. The copy is a usable data folder."""
    from damperlab.studies.store.store import Store

    source = open_store(data_dir)
    if folder.exists() and any(folder.iterdir()) and not (folder / "catalogue.sqlite").is_file():
        raise typer.BadParameter(
            f"found {str(folder)!r}, which holds other files; allowed: a new folder, or a backup"
        )
    _copy(source, Store.open(folder), as_json, f"Backed up to {folder}")


def restore(
    folder: Annotated[Path, typer.Argument(help="Folder that `damperlab store backup` created.")],
    data_dir: DataDir = None,
    place: StoreAddress = None,
    as_json: AsJson = False,
) -> None:
    """Copy a backup into a data folder that has no studies, and into the configured catalogue."""
    from damperlab.studies.store.store import Store

    if not (folder / "catalogue.sqlite").is_file():
        raise typer.BadParameter(
            f"found {str(folder)!r}, allowed: a folder that `damperlab store backup` made"
        )
    _copy(Store.open(folder), open_store(data_dir, store=place), as_json, f"Restored {folder}", for_good=True)


def rebuild(data_dir: DataDir = None, place: StoreAddress = None, as_json: AsJson = False) -> None:
    """Rebuild the catalogue from the cubes, or add missing studies to the catalogue.

    The command may be interrupted and repeated.
    """
    from damperlab.studies.store.care.rebuild import rebuild as from_cubes

    settings = settings_of(data_dir, store=place)
    with working("Reading every cube"):
        found = from_cubes(settings.data_dir, settings.catalogue, settings.store)
    if found.set_aside is not None:
        note(f"The damaged catalogue was renamed to {found.set_aside}.")
    for line in found.trouble:
        note(f"damperlab: left out {line}")
    known = f"{found.known} studies were already in the catalogue; {found.restored} of them were restored"
    note(f"Added {found.studies} studies and {found.blocks} blocks; {known}.")
    if found.deleted:
        note(f"{found.deleted} deleted studies stay deleted; `damperlab store gc` removes their files.")
    if as_json:
        print_json(vars(found))
    if found.trouble:
        raise typer.Exit(FAILED)


def gc(
    data_dir: DataDir = None,
    older_than: Annotated[
        str, typer.Option(metavar="TIME", help="Keep files younger than this, as in 90s, 30min, 12h or 7d.")
    ] = "1h",
    orphans_older_than: Annotated[
        str,
        typer.Option(
            "--orphans-older-than",
            metavar="TIME",
            help="Keep cubes without a study if they are younger than this.",
        ),
    ] = "7d",
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="List the files that would be removed, and change nothing.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Remove superseded files, cubes of deleted studies, and cubes without a study.

    Unknown files are kept and listed.
    """
    from damperlab.studies.store.care.sweep import collect_garbage

    seconds = lasting(older_than, "--older-than")
    orphan_seconds = lasting(orphans_older_than, "--orphans-older-than")
    store = open_store(data_dir)
    with working("Checking every file"):
        swept = collect_garbage(store, seconds, orphan_seconds=orphan_seconds, dry_run=dry_run)
    for line in swept.what:
        note(f"{'Would ' if dry_run else ''}{line}")
    for line in swept.unknown:
        note(f"Not touched: {line}. `damperlab store rebuild` adds it to the catalogue if it is a cube.")
    verb = "Would remove" if dry_run else "Removed"
    note(f"{verb} {swept.paths} files and folders, {swept.bytes} bytes.")
    if as_json:
        print_json(
            {
                "paths": swept.paths,
                "bytes": swept.bytes,
                "what": list(swept.what),
                "unknown": list(swept.unknown),
                "dry_run": dry_run,
            }
        )


def _copy(source: "Store", target: "Store", as_json: bool, done: str, for_good: bool = False) -> None:
    from damperlab.studies.store.care.backup import copy_store

    try:
        with working("Copying"):
            copied = copy_store(source, target, for_good=for_good)
    finally:
        target.close()
    note(f"{done}: {copied.studies} studies, {copied.blocks} blocks, {copied.bytes} bytes.")
    for line in copied.damaged:
        note(f"damperlab: left out: {line}")
    if as_json:
        print_json(vars(copied))
    if copied.damaged:
        raise typer.Exit(FAILED)


def lasting(text: str, option: str) -> float:
    """Convert a duration such as 12h into seconds. Raise BadParameter if the text is not a duration."""
    found = re.fullmatch(r"(\d{1,9}(?:\.\d{1,9})?)(s|min|h|d)", text)
    if found is None:
        raise typer.BadParameter(
            f"found {text!r}, allowed: a number and a unit, as in 90s, 30min, 12h, 7d",
            param_hint=option,
        )
    return float(found[1]) * _UNITS[found[2]]
