"""What the pages say that can be written is accepted, and what two of them say of one thing agrees."""

import re
from pathlib import Path
from typing import Any

import pytest
import yaml
from docs.console import ROOT, TITLED
from docs.drawing.motion import EXAMPLES

from damperlab.studies.definition import parse_study
from damperlab.studies.ground.generated import GENERATED
from damperlab.studies.reading import read_study
from damperlab.studies.specification.reading import read_specification
from damperlab.studies.variables import ResponseClass
from damperlab.worker.simulate import simulate

DOCS = ROOT / "docs"
INLINE = re.compile(r"`([a-z_]+: [^`]+)`")
GLOSSARY = INLINE.findall((DOCS / "glossary.md").read_text())
GRID = {"axes": {"clearance_ratio": 5.0, "friction_ratio": 0.4, "frequency_ratio": [0.9, 1.0]}}
WRITTEN = [
    (page.relative_to(ROOT).as_posix(), *found.groups())
    for page in sorted(DOCS.rglob("*.md"))
    for found in TITLED.finditer(page.read_text())
    if found[1].endswith(".yaml")
]


@pytest.mark.parametrize("example", GLOSSARY)
def test_an_example_of_the_glossary_is_accepted(example: str) -> None:
    ((key, value),) = yaml.safe_load(example).items()
    if key == "response_class":
        assert value.upper() in ResponseClass.__members__
    elif key in GENERATED:
        assert GENERATED[key](value).duration_s > 0.0
    else:
        stored: dict[str, Any] = parse_study(GRID | {key: value}).document()
        assert stored[key] == value or value.items() <= stored[key].items()


@pytest.mark.parametrize(("page", "name", "text"), WRITTEN)
def test_a_study_or_a_specification_of_a_page_is_accepted(
    page: str, name: str, text: str, tmp_path: Path
) -> None:
    (tmp_path / name).write_text(text)
    document = yaml.safe_load(text)
    read = read_specification if "choose" in document else read_study
    assert read(str(tmp_path / name)).name == document["name"]


def test_files_of_one_name_are_one_file() -> None:
    texts: dict[str, set[str]] = {}
    names: dict[str, set[str]] = {}
    for _, file, text in WRITTEN:
        texts.setdefault(file, set()).add(text)
        names.setdefault(yaml.safe_load(text)["name"], set()).add(text)
    assert [each for each, of in (texts | names).items() if len(of) > 1] == []


def test_the_readme_shows_the_verdict_of_the_guide_to_designs() -> None:
    readme, guide = ((ROOT / name).read_text() for name in ("README.md", "docs/how-to/design.md"))
    command = "$ damperlab design floor.yaml"
    (shown,) = re.findall(rf"^{re.escape(command)}\n(.*?)^```", readme, re.MULTILINE | re.DOTALL)
    assert f"{command} --data-dir data\n{shown}```" in guide


def test_a_locked_mass_moves_by_z_about_where_friction_stopped_it() -> None:
    """The law that the pages state, of the example that they show."""
    metrics = simulate(EXAMPLES["locked"].design).metrics
    offset = metrics["relative_amplitude_ratio"]
    assert offset > 0.1
    assert metrics["amplitude_ratio"] == pytest.approx(1.0 + offset, abs=1e-12)
