"""The first page: what this service is and which addresses it has. Nothing on it is loaded from anywhere."""

from html import escape

from fastapi import APIRouter
from starlette.requests import Request
from starlette.responses import HTMLResponse

router = APIRouter(include_in_schema=False)

_PAGE = """\
<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<title>damperlab</title>
<style>
body {{ font: 16px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; }}
table {{ border-collapse: collapse; width: 100%; }}
td, th {{ text-align: left; vertical-align: top; padding: .3rem .8rem .3rem 0; border-bottom: 1px solid #8884; }}
code {{ font-size: .9em; }}
:root {{ color-scheme: light dark; }}
</style>
<h1>damperlab {version}</h1>
<p>{description}</p>
<p>Machine-readable: <a href="openapi.json">openapi.json</a>. Now: <a href="api/v1/studies">studies</a>,
<a href="health/ready">health</a>.</p>
<table>
<tr><th>method<th>path<th>what
{rows}
</table>
</html>
"""


@router.get("/", response_class=HTMLResponse)
def home(request: Request) -> HTMLResponse:
    """List the routes, from the same document that programs read."""
    document = request.app.openapi()
    rows = "\n".join(
        f"<tr><td><code>{method.upper()}</code><td><code>{escape(path)}</code><td>{escape(operation['summary'])}"
        for path, operations in document["paths"].items()
        for method, operation in operations.items()
    )
    info = document["info"]
    page = _PAGE.format(version=escape(info["version"]), description=escape(info["description"]), rows=rows)
    return HTMLResponse(
        page, headers={"Content-Security-Policy": "default-src 'none'; style-src 'unsafe-inline'"}
    )
