"""Serves the documentation site that `make docs` builds, with a content security policy for each page."""

import os
import re
from base64 import b64encode
from functools import lru_cache
from hashlib import sha256
from pathlib import Path

from starlette.exceptions import HTTPException
from starlette.responses import Response
from starlette.staticfiles import PathLike, StaticFiles
from starlette.types import Scope

PLACE = "/docs/"
"""Path of the documentation site in the service."""
FIRST = "index.html"

_SCRIPT = re.compile(rb"<script(?![^>]*\bsrc\b)[^>]*>(.*?)</script>", re.DOTALL)
_POLICY = (
    "default-src 'none'; script-src 'self'{scripts}; style-src 'self' 'unsafe-inline'; img-src 'self' data:; "
    "font-src 'self'; connect-src 'self'; worker-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
"""Content security policy of a page, with the hashes of inline scripts. Equations contain style attributes."""


def built() -> Path | None:
    """Return the folder of the site that `make docs` has built in a checkout; None if there is no site."""
    folder = Path(__file__).resolve().parents[1] / "site"
    return folder if (folder / FIRST).is_file() else None


class Documentation(StaticFiles):
    """ASGI application that serves the files of the documentation site.

    Parameters
    ----------
    folder : Path
        Output folder of `mkdocs build`.
    """

    def __init__(self, folder: Path) -> None:
        super().__init__(directory=folder, html=True)

    async def get_response(self, path: str, scope: Scope) -> Response:
        """Return the file at a path. If the file is missing, raise an exception that causes a problem document."""
        response = await super().get_response(path, scope)
        if response.status_code == 404:
            raise HTTPException(404)
        return response

    def file_response(
        self, full_path: PathLike, stat_result: os.stat_result, scope: Scope, status_code: int = 200
    ) -> Response:
        """Return a file. The response for an HTML page, even with status 304, contains the policy of the page."""
        response = super().file_response(full_path, stat_result, scope, status_code)
        response.headers["Cache-Control"] = "no-cache"
        if str(full_path).endswith(".html"):
            response.headers["Content-Security-Policy"] = policy_of(str(full_path), stat_result.st_mtime_ns)
        return response


@lru_cache(maxsize=64)
def policy_of(path: str, changed_ns: int) -> str:
    """Return the content security policy of a page, with the SHA-256 hashes of the page's inline scripts.

    Parameters
    ----------
    path : str
        Path of the page.
    changed_ns : int
        Time of the last change of the page [ns], so that the policy of a changed page is not taken from the cache.
    """
    scripts = _SCRIPT.findall(Path(path).read_bytes())
    hashes = sorted({b64encode(sha256(script).digest()).decode() for script in scripts})
    return _POLICY.format(scripts="".join(f" 'sha256-{each}'" for each in hashes))
