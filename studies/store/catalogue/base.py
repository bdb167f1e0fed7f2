"""Base class of all parts of a store, with the data directory, the catalogue, and the location of the cubes."""

import threading
from pathlib import Path

from damperlab.studies.store.catalogue.catalogue import Catalogue
from damperlab.studies.store.catalogue.home import cube_name
from damperlab.studies.store.catalogue.quota import Quota
from damperlab.studies.store.cube.packed import Marks
from damperlab.studies.store.files.shelf import Shelf


class StoreBase:
    """Base class of the parts of a store.

    Parameters
    ----------
    data_dir : Path
        The data directory; see `Store.open`.
    catalogue : Catalogue
        Catalogue of the store.
    shelf : Shelf
        Storage location of the cubes.
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
        # for every claimed study: the latest renewal, and the monotonic time when this process first saw the renewal
        self._renewals: dict[int, tuple[tuple[str, float], float]] = {}

    def close(self) -> None:
        """Close the connections to the catalogue."""
        self.catalogue.close()

    def cube_shelf(self, study_id: str, number: int) -> Shelf:
        """Return the storage location of a study's cube, given the id and the number of the study."""
        return self.shelf.at(cube_name(study_id, number))
