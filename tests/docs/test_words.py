"""Messages, help texts, the web page and descriptions use the words of the glossary, and none that it has retired."""

import ast
import re
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from tests.service.cli.commands import every_command

from damperlab.service.app import create_app
from damperlab.service.settings import Settings

ROOT = Path(__file__).parents[2]
OF_OTHERS = ("worker/solver/", "worker/steady/", "worker/accuracy/")


@cache
def retired() -> re.Pattern[str]:
    """Match what stands in the first column of the glossary's last table."""
    table = (ROOT / "docs/glossary.md").read_text().split("## Retired words")[1]
    rows = [line.split("|")[1].strip() for line in table.splitlines() if line.startswith("|")]
    return re.compile(rf"\b(?:{'|'.join(map(re.escape, rows[2:]))})(?:s|ed)?\b", re.IGNORECASE)


def command_texts() -> Iterator[tuple[str, str]]:
    for name, command in every_command():
        yield name, command.help
        for parameter in command.params:
            if not getattr(parameter, "hidden", False):
                yield f"{name} {'/'.join(parameter.opts)}", getattr(parameter, "help", None) or ""


def message_texts() -> Iterator[tuple[str, str]]:
    """Give the texts of several words, without docstrings, of files that hold a retired word anywhere."""
    for part in ("service", "studies", "worker"):
        for file in sorted((ROOT / part).rglob("*.py")):
            place, source = file.relative_to(ROOT).as_posix(), file.read_text()
            if place.startswith(OF_OTHERS) or not retired().search(source):
                continue
            nodes = list(ast.walk(ast.parse(source)))
            docstrings = {node.value for node in nodes if isinstance(node, ast.Expr)}
            for node in nodes:
                text = node.value if isinstance(node, ast.Constant) and node not in docstrings else None
                if isinstance(text, str) and " " in text.strip():
                    yield f"{place}:{node.lineno}", text


def page_texts() -> Iterator[tuple[str, str]]:
    """Give what the scripts and the pages of the web page say: texts of several words that name no classes, and its HTML."""
    for file in sorted((ROOT / "service/page").glob("*.js")):
        source = re.sub(r"/\*.*?\*/|^\s*//.*?$", "", file.read_text(), flags=re.DOTALL | re.MULTILINE)
        for found in re.finditer(r'(class(?:Name)?: )?(?:"((?:[^"\\\n]|\\.)*)"|`((?:[^`\\]|\\.)*)`)', source):
            text = found[2] or found[3] or ""
            if found[1] is None and " " in text:
                yield file.name, text
    for file in sorted((ROOT / "service/page").glob("*.html")):
        yield file.name, re.sub(r"<[^>]*>", " ", file.read_text())


def described(document: Any, place: str) -> Iterator[tuple[str, str]]:
    if isinstance(document, dict):
        for key, value in document.items():
            if key in ("description", "summary") and isinstance(value, str):
                yield f"{place}/{key}", value
            else:
                yield from described(value, f"{place}/{key}")
    elif isinstance(document, list):
        for index, value in enumerate(document):
            yield from described(value, f"{place}/{index}")


def test_every_command_and_option_is_described_in_a_sentence() -> None:
    odd = [
        (place, text) for place, text in command_texts() if not re.match(r"^[A-Z].*\.\)?$", text, re.DOTALL)
    ]
    assert odd == []


def http_texts() -> Iterator[tuple[str, str]]:
    return described(create_app(Settings(data_dir=Path("nowhere"))).openapi(), "")


@pytest.mark.parametrize("texts", [command_texts, message_texts, page_texts, http_texts])
def test_nothing_that_is_said_uses_a_retired_word(texts: Callable[[], Iterable[tuple[str, str]]]) -> None:
    assert [(place, words) for place, text in texts() if (words := retired().findall(text))] == []


def test_no_page_of_the_documentation_uses_the_retired_name_of_a_suite() -> None:
    for page in (ROOT / "docs").rglob("*.md"):
        text = page.read_text().split("## Retired words")[0]
        assert not re.search(r"\bsurveys?\b", text, re.IGNORECASE), page.name
