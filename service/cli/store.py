"""The store that a command works on."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from damperlab.service.settings import Settings
    from damperlab.studies.store.record import Record
    from damperlab.studies.store.store import Store


def settings_of(data_dir: Path | None, **given: Any) -> "Settings":
    """Read the settings: what is given, --data-dir above all, else DAMPERLAB_…, else the defaults.

    Raises
    ------
    BadParameter
        If one cannot be used.
    """
    from pydantic import ValidationError

    from damperlab.service.settings import Settings

    named = {"data_dir": data_dir, **given}
    try:
        return Settings(**{name: value for name, value in named.items() if value is not None})
    except ValidationError as error:
        # without what was found: an address may hold a password
        faults = "; ".join(
            f"{'_'.join(map(str, one['loc'])) or 'settings'}: {one['msg'].removeprefix('Value error, ')}"
            for one in error.errors(include_url=False, include_input=False)
        )
        raise typer.BadParameter(f"{faults} (an option, or DAMPERLAB_… in the environment)") from None


def data_folder(data_dir: Path | None) -> Path:
    """Resolve --data-dir into an absolute path."""
    return settings_of(data_dir).data_dir


def open_store(data_dir: Path | None, **given: Any) -> "Store":
    """Open the store under --data-dir, making it where it is missing; more settings may be given.

    Raises
    ------
    StoreFault
        If the folder, the catalogue or the place of the cubes cannot be used.
    """
    return settings_of(data_dir, **given).open_store()


def label(record: "Record") -> str:
    """Name a study in a sentence: its free text, which may be empty, and its id."""
    return f"{record.name} ({record.id})" if record.name else record.id
