"""A store that an earlier version made, which every later version reads.

Until 0.2.0 is tagged, `python -m tests.studies.store.kept` makes the store again after a change of its layout. Afterwards the
file stays as it is: a version that changes the layout keeps reading it, and adds a store of its own.
"""

import tempfile
from contextlib import closing
from pathlib import Path
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

from tests.filling import fill, make_study

from damperlab.studies.store.store import Store

KEPT = Path(__file__).with_name("store-0.2.0.zip")
STUDY = make_study("kept")


def unpack(folder: Path) -> Path:
    """Unpack the store into a folder, and return its data directory."""
    with ZipFile(KEPT) as archive:
        archive.extractall(folder)
    return folder / "data"


def make() -> None:
    """Make the store, with nothing in it about the machine or the time at which its files were written."""
    with tempfile.TemporaryDirectory() as folder:
        with closing(Store.open(Path(folder) / "data")) as store:
            fill(store, STUDY)
        with ZipFile(KEPT, "w") as archive:
            for path in sorted(Path(folder).rglob("*")):
                if path.is_file() and not path.name.endswith("-writer"):
                    archive.writestr(ZipInfo(str(path.relative_to(folder))), path.read_bytes(), ZIP_DEFLATED)


if __name__ == "__main__":
    make()
