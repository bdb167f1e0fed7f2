"""The shelf at an address: a folder, or a prefix in a bucket."""

from damperlab.studies.store.files.folder import Folder
from damperlab.studies.store.files.shelf import Shelf


def open_shelf(address: str) -> Shelf:
    """Give the shelf at an address: `s3://bucket/prefix`, or a folder."""
    if address.startswith("s3://"):
        # only for who asks for it: not every installation has the library
        from damperlab.studies.store.files.bucket import open_bucket

        return open_bucket(address)
    return Folder(address)
