"""Archives unpacked alike by every Python that is supported: the filter of `tarfile` came with patch releases."""

import tarfile
from pathlib import Path


def extract_all(archive: tarfile.TarFile, folder: Path) -> None:
    """Unpack an archive into a folder, by the filter for data where there is one."""
    if hasattr(tarfile, "data_filter"):
        archive.extractall(folder, filter="data")
    else:
        archive.extractall(folder)
