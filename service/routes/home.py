"""Routes of the web page and its files. A header tells the browser to load nothing from other hosts."""

from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import Response

from damperlab.service.documentation import PLACE
from damperlab.service.page.files import PageFile, first_page, page_file, page_version
from damperlab.service.routes.late import LateRouter

router = LateRouter(include_in_schema=False)

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; style-src-attr 'unsafe-inline'; "
    "img-src 'self' data: blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
"""Policy that allows only scripts and styles of this service; the plotting library needs style attributes and blobs."""

YEAR_SECONDS = 31_536_000


@router.get("/")
def home(request: Request) -> Response:
    """Send the page. The browser must revalidate the page each time."""
    documented = request.app.state.settings.docs_dir is not None
    answer = _answer(request, first_page(PLACE.lstrip("/") if documented else ""), "no-cache")
    answer.headers["Content-Security-Policy"] = POLICY
    answer.headers["Referrer-Policy"] = "no-referrer"
    return answer


@router.get("/page/{version}/{name}")
def page(request: Request, version: str, name: str) -> Response:
    """Send a file of the page.

    The file at an address with the present version never changes, so a browser may keep the file. At any other address
    the browser must revalidate the file.
    """
    file = page_file(name)
    if file is None:
        raise HTTPException(404)
    lasting = version == page_version()
    return _answer(request, file, f"public, max-age={YEAR_SECONDS}, immutable" if lasting else "no-cache")


def _answer(request: Request, file: PageFile, caching: str) -> Response:
    headers = {
        "ETag": file.etag,
        "Cache-Control": caching,
        "Vary": "Accept-Encoding",
        "X-Content-Type-Options": "nosniff",
    }
    if file.etag in request.headers.get("if-none-match", ""):
        return Response(status_code=304, headers=headers)
    if "gzip" in request.headers.get("accept-encoding", ""):
        return Response(file.packed, 200, headers | {"Content-Encoding": "gzip"}, file.media_type)
    return Response(file.content, 200, headers, file.media_type)
