"""The documentation site, if `make docs` has built it: sends its files, with a policy that allows each page its own
scripts.
"""

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
"""Its address in the service."""
FIRST = "index.html"

_SCRIPT = re.compile(rb"<script(?![^>]*\bsrc\b)[^>]*>(.*?)</script>", re.DOTALL)
_POLICY = (
    "default-src 'none'; script-src 'self'{scripts}; style-src 'self' 'unsafe-inline'; img-src 'self' data:; "
    "font-src 'self'; connect-src 'self'; worker-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
"""The policy allows scripts from the site's own files, inline scripts by their hashes, and style attributes, which
equations have.
"""


def built() -> Path | None:
    """Give the output folder of `make docs` in a checkout; None if it does not exist."""
    folder = Path(__file__).resolve().parents[1] / "site"
    return folder if (folder / FIRST).is_file() else None


class Documentation(StaticFiles):
    """ASGI application: sends the files of the site.

    Parameters
    ----------
    folder : Path
        The output of `mkdocs build`.
    """

    def __init__(self, folder: Path) -> None:
        super().__init__(directory=folder, html=True)

    async def get_response(self, path: str, scope: Scope) -> Response:
        """Send the file at a path; for a missing file, send a problem document, as everywhere."""
        response = await super().get_response(path, scope)
        if response.status_code == 404:
            raise HTTPException(404)
        return response

    def file_response(
        self, full_path: PathLike, stat_result: os.stat_result, scope: Scope, status_code: int = 200
    ) -> Response:
        """Send a file. A page of HTML gets its own policy, even in an answer 304 (Not Modified)."""
        response = super().file_response(full_path, stat_result, scope, status_code)
        response.headers["Cache-Control"] = "no-cache"
        if str(full_path).endswith(".html"):
            response.headers["Content-Security-Policy"] = policy_of(str(full_path), stat_result.st_mtime_ns)
        return response


@lru_cache(maxsize=64)
def policy_of(path: str, changed_ns: int) -> str:
    """Give the policy of a page: it allows the page's inline scripts by their SHA-256, so that an injected script does
    not run.
    """
    scripts = _SCRIPT.findall(Path(path).read_bytes())
    hashes = sorted({b64encode(sha256(script).digest()).decode() for script in scripts})
    return _POLICY.format(scripts="".join(f" 'sha256-{each}'" for each in hashes))
