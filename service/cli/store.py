"""The store that a command works on."""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from service.settings import Settings
    from studies.store.record import Record
    from studies.store.store import Store


def settings_of(data_dir: Path | None) -> "Settings":
    """Read the settings: --data-dir, else DAMPERLAB_DATA_DIR, else the user's data folder; the rest as the service does."""
    from service.settings import Settings

    return Settings() if data_dir is None else Settings(data_dir=data_dir)


def data_folder(data_dir: Path | None) -> Path:
    """Resolve --data-dir into an absolute path."""
    return settings_of(data_dir).data_dir


def open_store(data_dir: Path | None) -> "Store":
    """Open the store under --data-dir, making it where it is missing.

    Raises
    ------
    StoreFault
        If the folder or the catalogue cannot be used.
    """
    from studies.store.store import Store

    settings = settings_of(data_dir)
    return Store.open(settings.data_dir, settings.catalogue)


def label(record: "Record") -> str:
    """Name a study in a sentence: its free text, which may be empty, and its id."""
    return f"{record.name} ({record.id})" if record.name else record.id
