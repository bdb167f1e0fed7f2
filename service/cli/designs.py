"""Commands on stored designs: list, rename, delete, undelete."""

from typing import Annotated

import typer

from damperlab.service.cli.options import AsJson, DataDir
from damperlab.service.cli.output import note, print_json, print_table
from damperlab.service.cli.spelled import in_options
from damperlab.service.cli.store import data_folder, folder_option, label, settings_of

designs = typer.Typer(help="List, rename, delete and restore designs.", no_args_is_help=True)

DesignId = Annotated[
    str,
    typer.Argument(
        metavar="DESIGN", help="Id of a design, its name, or at least the first four digits of its id."
    ),
]


@designs.command("list")
def list_(
    data_dir: DataDir = None,
    trash: Annotated[
        bool, typer.Option("--trash", help="List deleted designs that can be restored.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """List the designs, newest first."""
    found = settings_of(data_dir).designs.every(trash)
    if as_json:
        print_json({"designs": [each.document() for each in found]})
    elif not found:
        note(
            "No design is in the trash."
            if trash
            else "There are no designs. `damperlab design SPEC` makes one."
        )
    else:
        rows = [(each.id, each.name, each.state, each.created[:19].replace("T", " ")) for each in found]
        print_table(("id", "name", "state", "created"), rows)


@designs.command("rename")
def rename(
    design: DesignId,
    name: Annotated[str, typer.Argument(help="The new name.")],
    data_dir: DataDir = None,
) -> None:
    """Rename a design. The name in the specification is unchanged."""
    from damperlab.studies.remarks import read_remarks

    with in_options({"name": "NAME"}):
        read = read_remarks({"name": name})
    shelf = settings_of(data_dir).designs
    kept = shelf.find(design)
    shelf.rename(kept.id, read.name or "")
    note(f"Design {kept.id} is called {read.name!r} now.")


@designs.command("delete")
def delete(
    design: DesignId,
    data_dir: DataDir = None,
    yes: Annotated[bool, typer.Option("--yes", "-y", help="Delete without asking.")] = False,
    trash: Annotated[bool, typer.Option("--trash", help="Keep it in the trash for a week.")] = False,
) -> None:
    """Delete a design and its answer permanently, or move the design to the trash. Its studies stay."""
    shelf = settings_of(data_dir).designs
    kept = shelf.find(design)
    if not (yes or trash):
        typer.confirm(f"Delete design {label(kept)} for good?", abort=True, err=True)
    shelf.delete(kept, trash)
    option = folder_option(data_folder(data_dir))
    restore = f"in the trash. Restore it with: damperlab designs undelete {kept.id}{option}"
    note(f"Design {label(kept)} is {restore if trash else 'deleted.'}")


@designs.command("undelete")
def undelete(design: DesignId, data_dir: DataDir = None) -> None:
    """Restore a design from the trash, which `damperlab designs list --trash` lists."""
    kept = settings_of(data_dir).designs.undelete(design)
    note(f"Design {label(kept)} is restored.")
