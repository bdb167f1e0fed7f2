"""Base of every part of the store: the data directory, the catalogue, the location of the cubes."""

import threading
from pathlib import Path

from damperlab.studies.store.catalogue.catalogue import Catalogue
from damperlab.studies.store.catalogue.home import cube_name
from damperlab.studies.store.catalogue.quota import Quota
from damperlab.studies.store.cube.chunks import Marks
from damperlab.studies.store.files.shelf import Shelf


class StoreBase:
    """The catalogue and the shelf of the cubes.

    Parameters
    ----------
    data_dir : Path
        The data directory; see `Store.open`.
    catalogue : Catalogue
        Its catalogue.
    shelf : Shelf
        The shelf of the cubes.
    quota : Quota
        Quota of all studies.
    """

    def __init__(self, data_dir: Path, catalogue: Catalogue, shelf: Shelf, quota: Quota) -> None:
        self.data_dir = data_dir
        self.catalogue = catalogue
        self.shelf = shelf
        self.quota = quota
        self._marks: dict[int, tuple[int, Marks]] = {}
        self._marks_lock = threading.Lock()
        # for every claimed study: its latest renewal, and when this process first saw it, by the monotonic clock
        self._renewals: dict[int, tuple[tuple[str, float], float]] = {}

    def close(self) -> None:
        """Close the catalogue's connections."""
        self.catalogue.close()

    def cube_shelf(self, study_id: str, number: int) -> Shelf:
        """Give the shelf of a cube by its study's id and number."""
        return self.shelf.at(cube_name(study_id, number))
