"""The documentation is made from the code, and loads nothing from elsewhere. `make docs` builds it; here are its parts."""

import importlib.util
from pathlib import Path
from typing import Any

import nbformat
import pytest
import yaml

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


def test_table_cells_stay_in_their_table(hooks: Any) -> None:
    for line in hooks.http_reference().splitlines():
        if line.startswith("| `"):
            assert line.replace("\\|", "").count("|") == 5


def test_notebook_becomes_a_page(hooks: Any) -> None:
    path = ROOT / "docs" / "notebooks" / "figure-11.ipynb"
    page = hooks.notebook_page(path)
    assert page.startswith("# Figure 11\n")
    for cell in nbformat.read(path, as_version=4).cells:
        assert cell.source in page


@pytest.mark.parametrize(
    "html",
    [
        '<script src="https://cdn.example/x.js"></script>',
        "<script async src='//cdn.example/x.js'></script>",
        '<link rel="stylesheet" href="https://fonts.googleapis.com/css?family=Roboto">',
        '<link href="https://fonts.gstatic.com" rel="preconnect" crossorigin>',
        '<img alt="a badge" src="http://badge.example/ok.svg">',
        "<style>@font-face { src: url('https://font.example/a.woff2') }</style>",
        "<style>@import 'https://style.example/a.css';</style>",
    ],
)
def test_what_would_be_loaded_from_elsewhere_is_found(hooks: Any, html: str) -> None:
    assert hooks.outside(f"<html>{html}</html>")


def test_links_and_own_files_are_not_loaded_from_elsewhere(hooks: Any) -> None:
    html = (
        '<a href="https://www.rfc-editor.org/rfc/rfc9457">RFC</a><link rel="canonical" href="https://x.example/">'
        '<link rel="stylesheet" href="../assets/a.css"><script src="../a.js"></script><img src="figure-11.png">'
    )
    assert hooks.outside(html) == []


def test_study_of_the_tutorial_is_one() -> None:
    study = read_study(str(ROOT / "docs" / "tutorial.yaml"))
    # what the tutorial says of it: 10 mm over 1 mm, and 0.1 N over M·(2π·2.5 Hz)²·1 mm
    assert 10.0 in study.coordinates["clearance_ratio"]
    near = abs(study.coordinates["friction_ratio"] - 0.203).min()
    assert near < 5e-4
    assert study.name in (ROOT / "docs" / "tutorial.md").read_text()


def test_every_page_of_the_menu_is_there() -> None:
    menu = yaml.safe_load((ROOT / "mkdocs.yml").read_text())["nav"]
    made = {
        "reference/http.md",
        *(f"notebooks/{path.stem}.md" for path in ROOT.glob("docs/notebooks/*.ipynb")),
    }
    for entry in menu:
        for target in entry.values():
            for page in (
                [target] if isinstance(target, str) else (next(iter(each.values())) for each in target)
            ):
                assert page in made or (ROOT / "docs" / page).is_file()
