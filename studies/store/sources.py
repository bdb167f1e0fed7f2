"""Hash of Python sources without comments, docstrings and blank lines."""

import hashlib
from collections.abc import Iterable, Iterator
from pathlib import Path

_QUOTES = '"' * 3


def hash_of(root: Path, names: Iterable[str]) -> str:
    """Return the SHA-256 hash of the code in source files.

    Parameters
    ----------
    root : Path
        Folder of the package.
    names : iterable of str
        Paths relative to `root`, of files and of folders. All sources in a folder are included.

    Returns
    -------
    str
        64 hex digits. Line endings have no effect.
    """
    digest = hashlib.sha256()
    for name in names:
        place = root / name
        for source in sorted(place.rglob("*.py")) if place.is_dir() else [place]:
            text = "\n".join(computing_lines(source.read_text(encoding="utf-8")))
            digest.update(f"{source.relative_to(root).as_posix()}\n{len(text)}\n{text}".encode())
    return digest.hexdigest()


def computing_lines(text: str) -> Iterator[str]:
    """Yield the lines of a source without comments, blank lines and docstrings, including docstrings of constants.

    A line that begins with three quotes starts a docstring. A comment after code is kept if the line has a double
    quote, because the # may then be part of a string.
    """
    prose = string = False
    for line in text.splitlines():
        bare = line.strip()
        if prose:
            prose = _QUOTES not in bare
        elif not string and bare.startswith((_QUOTES, "r" + _QUOTES)):
            prose = bare.count(_QUOTES) == 1
        elif string or (bare and not bare.startswith("#")):
            string ^= bare.count(_QUOTES) % 2 == 1
            yield line if string or '"' in line else line.partition("  #")[0].rstrip()
