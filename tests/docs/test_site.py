"""The documentation is made from the code, and loads nothing from elsewhere. `make docs` builds it; here are its parts."""

import importlib.util
from pathlib import Path
from typing import Any

import nbformat
import pytest
from docs.console import put_files
from tests.service.cli.commands import every_command

from damperlab.service.app import create_app
from damperlab.service.settings import Settings
from damperlab.studies.reading import read_study

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def hooks() -> Any:
    # mkdocs loads this file by its path, too
    found = importlib.util.spec_from_file_location("hooks", ROOT / "docs" / "hooks.py")
    assert found is not None
    assert found.loader is not None
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    return module


def test_http_reference_has_every_route_and_parameter(hooks: Any) -> None:
    page = hooks.http_reference()
    for path, operations in create_app(Settings()).openapi()["paths"].items():
        for method, operation in operations.items():
            section = page.partition(f"\n## {method.upper()} {path}\n")[2].partition("\n## ")[0]
            assert operation["summary"] in section
            for parameter in operation.get("parameters", []):
                assert f"| `{parameter['name']}`" in section
            for status in operation["responses"]:
                assert f"| {status} |" in section


def test_notebook_becomes_a_page(hooks: Any) -> None:
    path = ROOT / "docs" / "notebooks" / "figure-11.ipynb"
    page, figures = hooks.notebook_page(path)
    assert page.startswith("# Figure 11\n")
    assert len(figures) == 2
    for name, picture in figures.items():
        assert f"]({name})" in page
        assert picture.startswith(b"\x89PNG")
    for cell in nbformat.read(path, as_version=4).cells:
        assert cell.source in page


@pytest.mark.parametrize(
    "html",
    [
        '<script src="https://cdn.example/x.js"></script>',
        '<link rel="stylesheet" href="https://fonts.googleapis.com/css?family=Roboto">',
        '<img alt="a badge" src="http://badge.example/ok.svg">',
        "<style>@font-face { src: url('https://font.example/a.woff2') }</style>",
        "<style>@import 'https://style.example/a.css';</style>",
    ],
)
def test_what_would_be_loaded_from_elsewhere_is_found(hooks: Any, html: str) -> None:
    assert hooks.outside(f"<html>{html}</html>")
    assert hooks.outside('<a href="https://x.example/">RFC</a><img src="figure-11.png">') == []


def test_study_of_the_tutorial_is_what_its_words_say(tmp_path: Path) -> None:
    text = (ROOT / "docs" / "tutorial.md").read_text()
    put_files(text, tmp_path)
    study = read_study(str(tmp_path / "damper.yaml"))
    # what the tutorial says of it: 5 mm over 1 mm, and 0.3 N over M·(2π·2.5 Hz)²·1 mm
    assert 5.0 in study.coordinates["clearance_ratio"]
    assert abs(study.coordinates["friction_ratio"] - 0.61).min() < 5e-3


def test_equations_are_drawn_and_keep_their_words(hooks: Any) -> None:
    page = hooks.with_equations(
        "With $`\\gamma_F \\ge r^2`$ it is\n\n```math\nX = \\frac{1}{2}\n```\n\nand `$x$` stays.\n"
    )
    assert page.count("<svg") == 2
    assert 'aria-label="\\gamma_F \\ge r^2"' in page
    assert "```" not in page
    assert "`$x$` stays" in page
    # a drawing is a line of Markdown: a blank one in it would end it
    assert all("\n\n" not in part for part in page.split("<svg")[1:] if "</svg>" not in part)


def test_command_reference_has_every_command_and_option(hooks: Any) -> None:
    page = hooks.command_reference()
    for name, command in every_command():
        section = page.partition(f"\n## damperlab {name}\n")[2].partition("\n## ")[0]
        assert command.help in section
        for parameter in command.params:
            if not getattr(parameter, "hidden", False) and parameter.param_type_name == "option":
                assert parameter.opts[0] in section


def test_every_figure_is_shown_somewhere() -> None:
    pages = "".join(path.read_text() for path in (ROOT / "docs").rglob("*.md"))
    unused = [path.name for path in (ROOT / "docs" / "figures").iterdir() if path.name not in pages]
    assert unused == []
