"""The documentation site, where `make docs` has built it: its files, and a policy that lets each page run its own scripts."""

import re
from base64 import b64encode
from functools import lru_cache
from hashlib import sha256
from pathlib import Path

from starlette.responses import FileResponse, Response
from starlette.staticfiles import StaticFiles
from starlette.types import Scope

PLACE = "/docs/"
"""Its address in the service."""
FIRST = "index.html"

_SCRIPT = re.compile(rb"<script(?![^>]*\bsrc\b)[^>]*>(.*?)</script>", re.DOTALL)
_POLICY = (
    "default-src 'none'; script-src 'self'{scripts}; style-src 'self' 'unsafe-inline'; img-src 'self' data:; "
    "font-src 'self'; connect-src 'self'; worker-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
"""Scripts from its own files, and those that stand in the page, by their hashes; its equations have attributes of style."""


def built() -> Path | None:
    """Give the folder into which `make docs` builds in a checkout; None where it has not, or this is no checkout."""
    folder = Path(__file__).resolve().parents[1] / "site"
    return folder if (folder / FIRST).is_file() else None


class Documentation(StaticFiles):
    """ASGI application: sends the files of the site.

    Parameters
    ----------
    folder : Path
        What `mkdocs build` made.
    """

    def __init__(self, folder: Path) -> None:
        super().__init__(directory=folder, html=True)

    async def get_response(self, path: str, scope: Scope) -> Response:
        """Send a file; a page of HTML with the policy that fits it."""
        response = await super().get_response(path, scope)
        response.headers["Cache-Control"] = "no-cache"
        if isinstance(response, FileResponse) and str(response.path).endswith(".html"):
            response.headers["Content-Security-Policy"] = policy_of(Path(response.path).read_bytes())
        return response


@lru_cache(maxsize=64)
def policy_of(page: bytes) -> str:
    """Give the policy of a page: the scripts that it holds are named by their SHA-256, and no other may be put into it."""
    hashes = sorted({b64encode(sha256(script).digest()).decode() for script in _SCRIPT.findall(page)})
    return _POLICY.format(scripts="".join(f" 'sha256-{each}'" for each in hashes))
