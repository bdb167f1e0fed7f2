"""Opening of a store on this machine."""

import os
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from damperlab.studies.store.store import Store


def default_data_dir() -> Path:
    """Return the default data folder: ``$XDG_DATA_HOME/damperlab``, else ``~/.local/share/damperlab``.

    Returns
    -------
    Path
        Absolute path of the folder, which is not created. A relative ``XDG_DATA_HOME`` is ignored, as the XDG base
        directory specification requires.
    """
    base = os.environ.get("XDG_DATA_HOME", "")
    root = Path(base) if Path(base).is_absolute() else Path.home() / ".local" / "share"
    return root / "damperlab"


def open_store(data_dir: str | Path | None = None, catalogue: str | None = None) -> "Store":
    """Open a folder of studies on this machine. No service is needed.

    Parameters
    ----------
    data_dir : path, optional
        The data folder; by default ``DAMPERLAB_DATA_DIR``, else ``~/.local/share/damperlab``. The folder is
        created if it is missing.
    catalogue : str, optional
        Address of a PostgreSQL catalogue, ``postgresql://…``; by default ``DAMPERLAB_CATALOGUE``, else a SQLite file
        in the folder.

    Returns
    -------
    Store
        The opened store. ``store.page()`` lists the studies, ``store.find("figure-11")`` returns a study's record, and
        ``store.cube(record.id)`` returns the results of the study as an xarray Dataset.

    Raises
    ------
    ImportError
        If only the client is installed.
    StoreFault
        If the folder or the catalogue cannot be used, or was made by a newer version of damperlab.

    Examples
    --------
    >>> store = open_store()  # doctest: +SKIP
    >>> store.cube(store.find("figure-11").id)["amplitude_ratio"]  # doctest: +SKIP
    """
    try:
        from damperlab.studies.store.store import Store
    except ModuleNotFoundError as error:
        raise ImportError(
            f"open_store needs {error.name}, which is not installed: pip install 'damperlab[service]'",
            name=error.name,
        ) from error
    folder = data_dir or os.environ.get("DAMPERLAB_DATA_DIR") or default_data_dir()
    return Store.open(Path(folder), catalogue or os.environ.get("DAMPERLAB_CATALOGUE") or None)
