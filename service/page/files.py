"""The page's files as they are served: compressed once, with their digest in the address, so that browsers cache them."""

import gzip
import re
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path

from damperlab.service.page.words import MODULE, words_module

PLOTLY = "plotly.min.js"
SMALL = "plotly-cartesian.min.js"
"""Plotly's bundle of cartesian figures, a third of the size of all of Plotly. `make install-dev` and `make dist` put it
into the package.
"""
_BLOCK = rb"/\*\*(?:(?!\*/)[\s\S])*\*/"
_COMMENT = re.compile(rb"^[ \t]*(?:" + _BLOCK + rb"|//.*)\n|" + _BLOCK + rb" ?", re.MULTILINE)
"""Comments on complete lines, and comments with the type of an expression. No module has a multi-line text that could
contain one.
"""
MEDIA_TYPES = {
    ".html": "text/html; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".svg": "image/svg+xml",
}


@dataclass(frozen=True)
class PageFile:
    """One file of the page.

    Parameters
    ----------
    content, packed : bytes
        Plain, and with gzip.
    media_type : str
        Its ``Content-Type``.
    etag : str
        A digest of the content, in quotation marks as in HTTP.
    """

    content: bytes
    packed: bytes
    media_type: str
    etag: str

    @classmethod
    def of(cls, content: bytes, suffix: str) -> "PageFile":
        """Compress a file without a time stamp, so equal contents give equal bytes."""
        digest = sha256(content).hexdigest()[:20]
        return cls(content, gzip.compress(content, 6, mtime=0), MEDIA_TYPES[suffix], f'"{digest}"')


@cache
def page_version() -> str:
    """Digest of all files of the page. It is part of their addresses, which change when a file changes."""
    digest = sha256(version("plotly").encode() + b"\0" + plotly_path().name.encode())
    for name in page_names():
        digest.update(name.encode() + b"\0" + _read(name))
    return digest.hexdigest()[:12]


@cache
def page_names() -> tuple[str, ...]:
    """Names of the page's own files and of the module of its words, sorted."""
    folder = files("damperlab.service") / "page"
    written = {entry.name for entry in folder.iterdir() if Path(entry.name).suffix in MEDIA_TYPES}
    return tuple(sorted(written | {MODULE}))


@cache
def page_file(name: str) -> PageFile | None:
    """Give a file of the page by its name; None if there is no such file."""
    if name == PLOTLY:
        return PageFile.of(plotly_path().read_bytes(), ".js")
    if name not in page_names():
        return None
    return PageFile.of(_read(name), Path(name).suffix)


@cache
def first_page(docs: str) -> PageFile:
    """Give the start page, with the addresses of its files and of the documentation."""
    modules = [name for name in page_names() if name.endswith(".js")]
    links = "\n".join(f'<link rel="modulepreload" href="page/{page_version()}/{name}">' for name in modules)
    text = _read("index.html").decode()
    for name, what in (("{version}", page_version()), ("{modules}", links), ("{docs}", docs)):
        text = text.replace(name, what)
    return PageFile.of(text.encode(), ".html")


def _read(name: str) -> bytes:
    """Read a file. The comments of a module, a fifth of its size, are removed."""
    if name == MODULE:
        return words_module()
    content = (files("damperlab.service") / "page" / name).read_bytes()
    return _COMMENT.sub(b"", content) if name.endswith(".js") else content


def plotly_path() -> Path:
    """Give the plotting library: the small bundle if the package has it, else that of plotly's wheel."""
    small = Path(str(files("damperlab.service") / "page" / "library" / SMALL))
    if small.is_file():
        return small
    # Located without an import: the package takes seconds to import, and only one of its files is needed.
    spec = find_spec("plotly")
    assert spec is not None
    assert spec.submodule_search_locations is not None
    return Path(spec.submodule_search_locations[0]) / "package_data" / PLOTLY
