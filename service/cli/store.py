"""The store that a command works on."""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from studies.store.record import Record
    from studies.store.store import Store


def data_folder(data_dir: Path | None) -> Path:
    """Resolve --data-dir: the option, else DAMPERLAB_DATA_DIR, else the user's data folder; absolute."""
    from service.settings import Settings

    return (Settings() if data_dir is None else Settings(data_dir=data_dir)).data_dir


def open_store(data_dir: Path | None) -> "Store":
    """Open the store under --data-dir, making it where it is missing.

    Raises
    ------
    StoreFault
        If the folder cannot be used.
    """
    from studies.store.store import Store

    return Store.open(data_folder(data_dir))


def label(record: "Record") -> str:
    """Name a study in a sentence: its free text, which may be empty, and its id."""
    return f"{record.name} ({record.id})" if record.name else record.id
