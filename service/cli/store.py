"""Functions that open the store for a command."""

import os
import shlex
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from damperlab.service.cli.failures import UsageFault
from damperlab.service.cli.output import note
from damperlab.studies.faults import Fault, nearest, sentence
from damperlab.studies.field import option_of

if TYPE_CHECKING:
    from damperlab.service.settings import Settings
    from damperlab.studies.design.kept import Kept
    from damperlab.studies.store.record import Record
    from damperlab.studies.store.store import Store


_OPTIONS = {"quota_bytes": "--quota"}
"""Command-line option for each setting whose option has another name."""
_SECRET = ("catalogue", "store")
"""Settings whose values may hold a password."""


def settings_of(data_dir: Path | None, **given: Any) -> "Settings":
    """Read the settings: --data-dir takes precedence, then DAMPERLAB_…, then the defaults.

    Raises
    ------
    UsageFault
        If a setting cannot be used.
    """
    from pydantic import ValidationError

    from damperlab.service.settings import Settings

    named = {"data_dir": data_dir, **given}
    try:
        return Settings(**{name: value for name, value in named.items() if value is not None})
    except ValidationError as error:
        options = [name for name, value in named.items() if value is not None]
        raise UsageFault(*(_fault(one, options) for one in error.errors(include_url=False))) from None


def warn_of_unknown_variables() -> None:
    """Report environment variables DAMPERLAB_… that are not settings, for example because of a spelling mistake."""
    if not any(name.upper().startswith("DAMPERLAB_") for name in os.environ):
        return
    from damperlab.service.settings import OTHER_VARIABLES, PREFIX, Settings

    known = {_variable(name) for name in (*Settings.model_fields, *OTHER_VARIABLES)}
    for name in sorted(os.environ):
        if name.upper().startswith(PREFIX) and name.upper() not in known:
            own = [each.removeprefix(PREFIX).lower() for each in known]
            near = nearest(name.upper().removeprefix(PREFIX), own)
            meant = f"did you mean {PREFIX}{near.upper()}?" if near else "remove it."
            note(f"damperlab: the variable {name} is not a setting and is ignored; {meant}")


def _fault(entry: Mapping[str, Any], options: Collection[str]) -> Fault:
    """Describe a fault of a setting. The description names the option or variable that gave the value."""
    from damperlab.studies.pydantic_faults import value_fault

    if not entry["loc"]:  # the fault concerns several settings, and its text names these settings
        return Fault("settings", "", "", "", sentence(str(entry["msg"]).removeprefix("Value error, ")))
    name = str(entry["loc"][0])
    field = _OPTIONS.get(name, option_of(name)) if name in options else _variable(name)
    fault = value_fault(field, entry)
    if name in _SECRET:
        return Fault(
            field, "another text", fault.allowed, fault.advice, f"{{field}} must be {fault.allowed}."
        )
    return fault


def _variable(name: str) -> str:
    return f"DAMPERLAB_{name.upper()}"


def data_folder(data_dir: Path | None) -> Path:
    """Resolve --data-dir into an absolute path."""
    return settings_of(data_dir).data_dir


def folder_option(data_dir: Path) -> str:
    """Return the text ` --data-dir FOLDER` with a leading space, or an empty text for the default folder."""
    return "" if data_dir == data_folder(None) else f" --data-dir {shlex.quote(str(data_dir))}"


def open_store(data_dir: Path | None, **given: Any) -> "Store":
    """Open the store in the folder of --data-dir. A missing store is created; `given` holds further settings.

    Raises
    ------
    StoreFault
        If the folder, the catalogue or the location of the cubes cannot be used.
    """
    return settings_of(data_dir, **given).open_store()


def find_study(store: "Store", ref: str) -> "Record":
    """Find a study by its id or name. A note names the study if other studies have the same name.

    Raises
    ------
    StudyNotFound
        If `Store.find` raises it.
    """
    record = store.find(ref)
    if ref and ref == record.name != record.id and (others := _namesakes(store, record)):
        note(f"Using {record.id}, the newest study named {ref}; {others} this name. To choose, give an id.")
    return record


def note_namesakes(store: "Store", record: "Record") -> None:
    """Print a note if other studies have the same name as `record`."""
    if others := _namesakes(store, record):
        note(f"{others} the name {record.name}. To choose, give an id.")


def _namesakes(store: "Store", record: "Record") -> str:
    """Begin a sentence with the number of other studies that have the same name. Return "" if there are none."""
    others = store.namesakes(record)
    if others == 0:
        return ""
    return "1 other study has" if others == 1 else f"{others:,} other studies have"


def has_store(data_dir: Path | None) -> bool:
    """Return whether a store exists. A missing store is not created."""
    from damperlab.studies.store.catalogue.catalogue import SQLITE_FILE

    settings = settings_of(data_dir)
    return settings.catalogue is not None or (settings.data_dir / SQLITE_FILE).is_file()


def label(kept: "Record | Kept") -> str:
    """Write the name, which may be empty, and the id of a study or a design, for use in a sentence."""
    return f"{kept.name} ({kept.id})" if kept.name else kept.id


def unfinished(record: "Record") -> str:
    """Say at the end of a sentence how many points of a study are not computed yet; empty if none are missing."""
    missing = record.points_total - record.points_done
    if not missing:
        return ""
    if not record.points_done:
        return f"; none of its {record.points_total:,} points is computed yet"
    return f"; {missing:,} of its {record.points_total:,} points are not computed yet"
