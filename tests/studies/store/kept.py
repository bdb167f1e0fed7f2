"""A store that an earlier version made, which every later version reads.

Until 0.2.0 is tagged, `python -m tests.studies.store.kept` makes the store again after a change of its layout. Afterwards the
file stays as it is: a version that changes the layout keeps reading it, and adds a store of its own.
"""

import tarfile
import tempfile
from contextlib import closing
from pathlib import Path

from tests.filling import fill, make_study

from damperlab.studies.store.store import Store

KEPT = Path(__file__).with_name("store-0.2.0.tar.xz")
STUDY = make_study("kept")
NAMELESS = {"uid": 0, "gid": 0, "uname": "", "gname": "", "mtime": 0}


def unpack(folder: Path) -> Path:
    """Unpack the store into a folder, and return its data directory."""
    with tarfile.open(KEPT) as archive:
        archive.extractall(folder, filter="data")
    return folder / "data"


def make() -> None:
    """Make the store, with nothing in it about the machine or the time at which its files were written."""

    def plain(file: tarfile.TarInfo) -> tarfile.TarInfo | None:
        return None if file.name.endswith("-writer") else file.replace(**NAMELESS, deep=False)

    with tempfile.TemporaryDirectory() as folder:
        with closing(Store.open(Path(folder) / "data")) as store:
            fill(store, STUDY)
        with tarfile.open(KEPT, "w:xz") as archive:
            archive.add(Path(folder) / "data", "data", filter=plain)


if __name__ == "__main__":
    make()
