"""What `mkdocs build` makes from the code itself: the HTTP reference from OpenAPI, and pages from the notebooks."""

import json
import re
from pathlib import Path
from typing import Any

import nbformat
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

OUTSIDE = re.compile(
    r"<(?:script|img|iframe|source|video|audio|object)\b[^>]*\b(?:src|data)\s*=\s*[\"']?(?:https?:)?//[^>]*>"
    r"|<link\b(?![^>]*rel=[\"']?(?:canonical|prev|next))[^>]*\bhref\s*=\s*[\"']?(?:https?:)?//[^>]*>"
    r"|(?:@import\s+|url\()\s*[\"']?(?:https?:)?//[^)\s]*",
    re.IGNORECASE,
)
"""What a browser would fetch from elsewhere; a link that a reader may follow is none."""

NOTEBOOKS = Path(__file__).parent / "notebooks"


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages that no file holds."""
    files.append(File.generated(config, "reference/http.md", content=http_reference()))
    for path in sorted(NOTEBOOKS.glob("*.ipynb")):
        files.append(File.generated(config, f"notebooks/{path.stem}.md", content=notebook_page(path)))
    return files


def on_post_page(output: str, page: Page, config: MkDocsConfig) -> str:
    """Refuse a page that loads anything from elsewhere: the site has to work without a network."""
    if found := outside(output):
        raise PluginError(f"{page.file.src_uri} loads from elsewhere: {', '.join(found)}")
    return output


def outside(html: str) -> list[str]:
    """Find what a page would load from elsewhere."""
    return [found[0] for found in OUTSIDE.finditer(html)]


def notebook_page(path: Path) -> str:
    """Write a notebook as Markdown: its words, and its code as code."""
    cells = nbformat.read(path, as_version=4).cells  # type: ignore[no-untyped-call]
    parts = [
        cell.source if cell.cell_type == "markdown" else f"```python\n{cell.source}\n```" for cell in cells
    ]
    return "\n\n".join(parts) + "\n"


def http_reference() -> str:
    """Write every route of the service with its parameters, from the document that the service itself gives."""
    from damperlab.service.app import create_app
    from damperlab.service.settings import Settings

    document = create_app(Settings()).openapi()
    lines = [
        "# HTTP",
        "",
        document["info"]["description"],
        "",
        "A running service has the same as a document for programs at `/openapi.json`. Errors are problem documents",
        "([RFC 9457](https://www.rfc-editor.org/rfc/rfc9457)).",
    ]
    for path, operations in document["paths"].items():
        for method, operation in operations.items():
            lines += ["", f"## {method.upper()} {path}", "", f"{operation['summary']}."]
            if text := operation.get("description"):
                lines += ["", text]
            lines += _parameters(operation.get("parameters", []))
            lines += _responses(operation)
    return "\n".join(lines) + "\n"


def _parameters(parameters: list[dict[str, Any]]) -> list[str]:
    if not parameters:
        return []
    lines = ["", "| parameter | in | type | meaning |", "|---|---|---|---|"]
    for each in parameters:
        schema = each.get("schema", {})
        words = each.get("description") or schema.get("description", "")
        if "default" in schema and schema["default"] is not None:
            words = f"{words} Default `{json.dumps(schema['default'])}`.".strip()
        needed = " (needed)" if each.get("required") else ""
        cells = (f"`{each['name']}`{needed}", each["in"], _type(schema), words)
        lines.append("| " + " | ".join(_cell(cell) for cell in cells) + " |")
    return lines


def _type(schema: dict[str, Any]) -> str:
    if "enum" in schema:
        return ", ".join(f"`{value}`" for value in schema["enum"])
    if "anyOf" in schema:
        return " or ".join(_type(each) for each in schema["anyOf"] if each.get("type") != "null")
    limits = [
        f"{sign} {schema[key]:g}"
        for key, sign in (
            ("minimum", "≥"),
            ("exclusiveMinimum", ">"),
            ("maximum", "≤"),
            ("exclusiveMaximum", "<"),
        )
        if key in schema
    ]
    return " ".join([str(schema.get("type", "")), *limits])


def _responses(operation: dict[str, Any]) -> list[str]:
    lines = ["", "| status | answer |", "|---|---|"]
    for status, response in sorted(operation["responses"].items()):
        kinds = ", ".join(f"`{kind}`" for kind in response.get("content", {}))
        lines.append(f"| {status} | {_cell(response['description'])}{': ' if kinds else ''}{kinds} |")
    return lines


def _cell(text: str) -> str:
    return re.sub(r"\s+", " ", text).replace("|", "\\|")
