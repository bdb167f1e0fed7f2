"""Files of the page, each compressed once, at addresses that contain a digest so that browsers can cache the files."""

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
"""Plotly's bundle for cartesian figures, which `make install-dev` and `make dist` put into the package."""
_BLOCK = rb"/\*\*(?:(?!\*/)[\s\S])*\*/"
_COMMENT = re.compile(rb"^[ \t]*(?:" + _BLOCK + rb"|//.*)\n|" + _BLOCK + rb" ?", re.MULTILINE)
"""Pattern of comments in modules of the page. No module has a multi-line string that looks like a comment."""
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
        Content of the file, plain and compressed with gzip.
    media_type : str
        Media type, sent as ``Content-Type``.
    etag : str
        Digest of the content, in quotation marks as in HTTP.
    """

    content: bytes
    packed: bytes
    media_type: str
    etag: str

    @classmethod
    def of(cls, content: bytes, suffix: str) -> "PageFile":
        """Compress a file. The time stamp of gzip is left out, so that equal contents give equal bytes."""
        digest = sha256(content).hexdigest()[:20]
        return cls(content, gzip.compress(content, 6, mtime=0), MEDIA_TYPES[suffix], f'"{digest}"')


@cache
def page_version() -> str:
    """Return a digest of all files of the page. The address of every file contains the digest."""
    digest = sha256(version("plotly").encode() + b"\0" + plotly_path().name.encode())
    for name in page_names():
        digest.update(name.encode() + b"\0" + _read(name))
    return digest.hexdigest()[:12]


@cache
def page_names() -> tuple[str, ...]:
    """Return the sorted names of the page's own files and of the module `MODULE`."""
    folder = files("damperlab.service") / "page"
    written = {entry.name for entry in folder.iterdir() if Path(entry.name).suffix in MEDIA_TYPES}
    return tuple(sorted(written | {MODULE}))


@cache
def page_file(name: str) -> PageFile | None:
    """Return a file of the page by its name, or None if there is no such file."""
    if name == PLOTLY:
        return PageFile.of(plotly_path().read_bytes(), ".js")
    if name not in page_names():
        return None
    return PageFile.of(_read(name), Path(name).suffix)


@cache
def first_page(docs: str) -> PageFile:
    """Return the start page, into which the addresses of its files and of the documentation are written."""
    modules = [name for name in page_names() if name.endswith(".js")]
    links = "\n".join(f'<link rel="modulepreload" href="page/{page_version()}/{name}">' for name in modules)
    text = _read("index.html").decode()
    for name, what in (("{version}", page_version()), ("{modules}", links), ("{docs}", docs)):
        text = text.replace(name, what)
    return PageFile.of(text.encode(), ".html")


def _read(name: str) -> bytes:
    """Read a file. Comments, which are a fifth of the size of a module, are removed."""
    if name == MODULE:
        return words_module()
    content = (files("damperlab.service") / "page" / name).read_bytes()
    return _COMMENT.sub(b"", content) if name.endswith(".js") else content


def plotly_path() -> Path:
    """Return the path of the plotting library: the small bundle if the package has it, else plotly's own bundle."""
    small = Path(str(files("damperlab.service") / "page" / "library" / SMALL))
    if small.is_file():
        return small
    # The package plotly is not imported: the import takes seconds, and only one file of the package is needed.
    spec = find_spec("plotly")
    assert spec is not None
    assert spec.submodule_search_locations is not None
    return Path(spec.submodule_search_locations[0]) / "package_data" / PLOTLY
