"""What `mkdocs build` makes: references of HTTP and commands from the code, pages from executed notebooks, equations as SVG."""

import base64
import html
import json
import re
import warnings
from enum import Enum
from pathlib import Path
from typing import Any, get_args

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
    files.append(File.generated(config, "reference/commands.md", content=command_reference()))
    for path in sorted(NOTEBOOKS.glob("*.ipynb")):
        page, figures = notebook_page(path)
        files.append(File.generated(config, f"notebooks/{path.stem}.md", content=page))
        for name, picture in figures.items():
            files.append(File.generated(config, f"notebooks/{name}", content=picture))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Set the equations of a page."""
    return with_equations(markdown)


def on_post_page(output: str, page: Page, config: MkDocsConfig) -> str:
    """Refuse a page that loads anything from elsewhere: the site has to work without a network."""
    if found := outside(output):
        raise PluginError(f"{page.file.src_uri} loads from elsewhere: {', '.join(found)}")
    return output


def outside(html: str) -> list[str]:
    """Find what a page would load from elsewhere."""
    return [found[0] for found in OUTSIDE.finditer(html)]


def with_equations(markdown: str) -> str:
    """Set blocks of ```math and spans of $`…`$ as drawings, which need neither a script nor a font; GitHub sets both, too."""
    markdown = re.sub(r"^```math\n(.*?)^```$", _displayed, markdown, flags=re.MULTILINE | re.DOTALL)
    return re.sub(r"\$`([^`]+)`\$", lambda found: _equation(found[1], inline=True), markdown)


def _displayed(found: re.Match[str]) -> str:
    return "\n".join(
        f'<div class="equation">{_equation(line, inline=False)}</div>'
        for line in found[1].split("\n\n")
        if line.strip()
    )


def _equation(source: str, inline: bool) -> str:
    """Draw one equation; a reader who listens hears its LaTeX."""
    with warnings.catch_warnings():
        warnings.simplefilter(
            "ignore", DeprecationWarning
        )  # it finds its font in the way of older versions of Python
        from ziamath import Latex

    drawn = Latex(" ".join(source.split()), size=16 if inline else 19, color="currentColor", inline=inline)
    spoken = html.escape(" ".join(source.split()), quote=True)
    place = f' style="vertical-align: {drawn.getyofst():.2f}px"' if inline else ""
    shape = drawn.svg().replace("<svg ", f'<svg role="img" aria-label="{spoken}"{place} ', 1)
    return re.sub(r"-?\d+\.\d{3,}", lambda number: f"{float(number[0]):.2f}", shape)


def notebook_page(path: Path) -> tuple[str, dict[str, bytes]]:
    """Write an executed notebook as Markdown: its words, its code, what the code printed, and its figures beside it.

    Returns
    -------
    page : str
        Markdown.
    figures : dict of bytes
        PNG by file name; the page shows them.
    """
    parts: list[str] = []
    figures: dict[str, bytes] = {}
    for cell in nbformat.read(path, as_version=4).cells:  # type: ignore[no-untyped-call]
        if cell.cell_type == "markdown":
            parts.append(cell.source)
            continue
        parts.append(f"```python\n{cell.source}\n```")
        for output in cell.get("outputs", []):
            data = output.get("data", {})
            if "image/png" in data:
                name = f"{path.stem}-{len(figures) + 1}.png"
                figures[name] = base64.b64decode(data["image/png"])
                parts.append(f"![Figure {len(figures)} of this notebook]({name})")
            elif "text/html" in data:
                parts.append(f'<div class="output">{_table(data["text/html"])}</div>')
            elif text := output.get("text") or data.get("text/plain"):
                parts.append(f"```text\n{text.rstrip()}\n```")
    return "\n\n".join(parts) + "\n", figures


def _table(text: str) -> str:
    """Take the style sheet and the blank lines out of a table; Markdown would end it at one."""
    text = re.sub(r"<style.*?</style>", "", text, flags=re.DOTALL)
    return re.sub(r"\n\s*", "\n", text).strip()


def command_reference() -> str:
    """Write every command with its arguments and options, from the parser itself."""
    from typer.main import get_command

    from damperlab.service.cli.main import app

    commands = get_command(app)
    lines = ["# Commands", "", f"{commands.help}", "", *(commands.epilog or "").strip().splitlines(), ""]
    panels: dict[str, list[str]] = {}
    for name, command in commands.commands.items():  # type: ignore[attr-defined]
        panels.setdefault(command.rich_help_panel or "Commands", []).append(name)
    for panel, names in panels.items():
        lines += [f"**{panel}:** " + ", ".join(f"[`{name}`](#damperlab-{name})" for name in names), ""]
    for names in panels.values():
        for name in names:
            lines += _command(name, commands.commands[name])  # type: ignore[attr-defined]
    return "\n".join(lines) + "\n"


def _command(name: str, command: Any) -> list[str]:
    if group := getattr(command, "commands", None):
        lines = [f"## damperlab {name}", "", str(command.help), ""]
        return lines + [line for each in group for line in _command(f"{name} {each}", group[each])]
    shown = [each for each in command.params if not getattr(each, "hidden", False) and each.name != "help"]
    arguments = [each for each in shown if each.param_type_name == "argument"]
    usage = " ".join(["damperlab", name, *(_argument(each) for each in arguments), "[OPTIONS]"])
    lines = [f"## damperlab {name}", "", str(command.help), "", f"```text\n{usage}\n```", ""]
    lines += ["| argument or option | value | meaning |", "|---|---|---|"]
    for each in shown:
        spelt = (
            _argument(each)
            if each.param_type_name == "argument"
            else ", ".join([*each.opts, *each.secondary_opts])
        )
        flag = getattr(each, "is_bool_flag", False)
        value = "" if flag else each.metavar or _kind(each.type_descriptor.annotation)
        words = getattr(each, "help", None) or ""
        default = each.default
        if each.show_default and isinstance(default, str | int | float) and not flag and default != "":
            words += f" Default `{getattr(default, 'value', default)}`."
        lines.append(f"| `{spelt}` | {_cell(value)} | {_cell(words)} |")
    return [*lines, ""]


def _kind(annotation: Any) -> str:
    if isinstance(annotation, type) and issubclass(annotation, Enum):
        return " | ".join(str(each.value) for each in annotation)
    if words := get_args(annotation):
        return " | ".join(str(word) for word in words)
    return {"int": "whole number", "float": "number", "str": "text", "Path": "path"}.get(
        annotation.__name__, ""
    )


def _argument(parameter: Any) -> str:
    name = parameter.metavar or parameter.name.upper()
    return name if parameter.required else f"[{name}]"


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
