"""Python sources without comments, docstrings and blank lines, so that an edit of prose does not outdate results."""

import hashlib
from collections.abc import Iterable, Iterator
from pathlib import Path

_QUOTES = '"' * 3


def hash_of(root: Path, names: Iterable[str]) -> str:
    """Hash the code of sources.

    Parameters
    ----------
    root : Path
        Folder of the package.
    names : iterable of str
        Files, and folders with all sources in them, relative to it.

    Returns
    -------
    str
        64 hex digits; the same for the same sources, whatever their line endings.
    """
    digest = hashlib.sha256()
    for name in names:
        place = root / name
        for source in sorted(place.rglob("*.py")) if place.is_dir() else [place]:
            text = "\n".join(computing_lines(source.read_text(encoding="utf-8")))
            digest.update(f"{source.relative_to(root).as_posix()}\n{len(text)}\n{text}".encode())
    return digest.hexdigest()


def computing_lines(text: str) -> Iterator[str]:
    """Give the lines of a source without comments, blank lines and docstrings, also those of values.

    A docstring begins a line with three quotes, as the formatter writes it. A comment after code is removed if the
    line has no double quote; otherwise the # could be part of a text.
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
