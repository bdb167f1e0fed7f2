"""No vocabulary is written by hand in two places: what names all words of one is its home, or takes them from there."""

import ast
import json
import re
from collections.abc import Collection, Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import get_args

import pytest

from damperlab.service.page.words import words_module
from damperlab.studies import vocabulary
from damperlab.studies.ground.quantities import QUANTITIES as DAMPER_QUANTITIES
from damperlab.studies.ground.variables import DIMENSIONS as SUITE_DIMENSIONS
from damperlab.studies.ground.variables import VARIABLES as SUITE_VARIABLES
from damperlab.studies.kinds import KINDS
from damperlab.studies.metrics import read_metrics
from damperlab.studies.paper import paper_numbers
from damperlab.studies.physical import QUANTITIES
from damperlab.studies.variables import DIMENSIONS, VARIABLES, ResponseClass, Status

ROOT = Path(__file__).parents[2]
FOLDERS = ("studies", "service", "worker", "docs")
VOCABULARIES: dict[str, Collection[str]] = {
    "states": vocabulary.STATES,
    "scopes": vocabulary.SCOPES,
    "objectives": vocabulary.OBJECTIVES,
    "criteria": vocabulary.CRITERIA,
    "contact models": vocabulary.CONTACT_MODELS,
    "kinds of start": vocabulary.START_KINDS,
    "reductions": get_args(vocabulary.Reduction),
    "formats of export": vocabulary.EXPORT_FORMATS,
    "cases": vocabulary.CASES,
    "units of acceleration": vocabulary.ACCELERATION_UNITS,
    "dimensions of a particle": vocabulary.OF_PARTICLE,
    "dimensions": DIMENSIONS,
    "dimensions of a suite": SUITE_DIMENSIONS,
    "physical quantities": [quantity.name for quantity in QUANTITIES],
    "quantities of a comparison": DAMPER_QUANTITIES,
    "variables": VARIABLES,
    "variables of a suite": SUITE_VARIABLES,
    "response classes": [kind.name.lower() for kind in ResponseClass],
    "statuses": [status.name.lower() for status in Status],
}
HOMES = (
    "studies/vocabulary.py",
    "studies/variables.py",
    "studies/ground/variables.py",
    "studies/ground/quantities.py",
    "studies/physical.py",
)
CLOSED = ("states", "objectives", "criteria", "cases", "dimensions", "response classes", "statuses")
"""Vocabularies of which a table without one word has forgotten it; tables by quantities may leave some out."""
ORDERS = {
    ("studies/kinds.py", "dimensions"): "the order in which a map shows them",
    ("studies/kinds.py", "dimensions of a particle"): "part of the same",
    (
        "studies/answers/verdict.py",
        "dimensions of a particle",
    ): "the order in which a sentence names a damper",
}
"""Lists that say more than the words: each is all of them, in an order of its own."""


def constants(nodes: Iterable[ast.expr | None]) -> list[str]:
    return [one.value for one in nodes if isinstance(one, ast.Constant) and isinstance(one.value, str)]


def groups(place: str, source: str) -> Iterator[tuple[int, bool, list[str]]]:
    """Give the keys of each table, a dict or an object, and the texts of each list, tuple and set; a Literal is one."""
    if place.endswith(".py"):
        for node in ast.walk(ast.parse(source)):
            if isinstance(node, ast.Dict):
                yield node.lineno, True, constants(node.keys)
            elif isinstance(node, ast.List | ast.Tuple | ast.Set):
                yield node.lineno, False, constants(node.elts)
    else:
        for is_table, group, text in (
            (False, r"\[([^\[\]]*)\]", r"""["'`]([^"'`]*)["'`]"""),
            (True, r"\{((?:[^{}]|\{[^{}]*\})*)\}", r"""(?:^|,)\s*["']?([a-z][a-z0-9_]*)["']?:"""),
        ):
            for found in re.finditer(group, source):
                yield source.count("\n", 0, found.start()) + 1, is_table, re.findall(text, found[1])


@cache
def sources() -> tuple[tuple[str, str], ...]:
    """Give the files that hold all words of a vocabulary, or all but one of a closed one: no other can list or lack them."""
    files = [
        (file.relative_to(ROOT).as_posix(), file.read_text())
        for folder in FOLDERS
        for file in sorted((ROOT / folder).rglob("*"))
        if file.suffix in (".py", ".js") and "library" not in file.parts
    ]
    return tuple((place, source) for place, source in files if _may_matter(source.lower()))


def _may_matter(source: str) -> bool:
    return any(
        sum(word.lower() in source for word in words) >= len(words) - (name in CLOSED and len(words) > 3)
        for name, words in VOCABULARIES.items()
    )


def test_no_vocabulary_is_listed_outside_its_home_and_none_twice_there() -> None:
    found = [
        (place, line, name)
        for place, source in sources()
        for line, is_table, texts in groups(place, source)
        for name, words in VOCABULARIES.items()
        if not is_table and set(words) <= set(texts) and len(set(texts)) == len(texts)
        if (place, name) not in ORDERS
    ]
    assert [each for each in found if each[0] not in HOMES] == []
    at_home = [(place, name) for place, _, name in found]
    assert sorted(set(at_home)) == sorted(at_home)


def test_a_table_by_the_words_of_a_vocabulary_holds_all_of_them() -> None:
    """One word added to a vocabulary, and forgotten in a table by it, is found."""
    lacking = [
        (place, line, name, sorted(set(words) - set(keys)))
        for place, source in sources()
        for line, is_table, keys in groups(place, source)
        for name, words in VOCABULARIES.items()
        if is_table and name in CLOSED and len(words) > 3
        if len(set(keys)) == len(words) - 1 and set(keys) < set(words)
    ]
    assert lacking == []


def test_words_and_their_types_are_the_same() -> None:
    """A Literal cannot be made of a table; beside it in one file, the two are compared here."""
    pairs = {
        vocabulary.Objective: vocabulary.OBJECTIVES,
        vocabulary.Criterion: vocabulary.CRITERIA,
        vocabulary.ContactModel: vocabulary.CONTACT_MODELS,
        vocabulary.ExportFormat: vocabulary.EXPORT_FORMATS,
        vocabulary.AccelerationUnits: vocabulary.ACCELERATION_UNITS,
    }
    for kind, words in pairs.items():
        assert set(get_args(kind)) == set(words)
    assert set(vocabulary.CRITERION_NAMES) == set(vocabulary.CRITERIA)
    assert set(vocabulary.EXPORT_SUFFIXES.values()) == set(vocabulary.EXPORT_FORMATS)
    assert set(vocabulary.OF_PARTICLE) < set(DIMENSIONS) == set(vocabulary.DESIGN_POINT)
    for kind in KINDS:
        assert set(kind.axes) <= set(kind.dimensions)
        assert set(read_metrics(list(kind.variables), kind.variables)) == set(kind.variables)


def test_defaults_are_what_the_paper_prints() -> None:
    paper = paper_numbers()
    assert vocabulary.DEFAULTS["damping_ratio"] == paper["damping_ratio"].value
    assert vocabulary.DEFAULTS["restitution"] == paper["restitution_soft"].value
    assert vocabulary.DEFAULTS["mass_ratio"] == paper["mass_ratio"].value
    defaults = {name: default for name, (_, default) in DAMPER_QUANTITIES.items()}
    assert defaults["natural_frequency_hz"] == paper["natural_frequency_hz"].value
    assert defaults["clearance_m"] == pytest.approx(paper["clearance_1_mm"].value / 1e3, rel=1e-15)
    assert defaults["particle_mass_kg"] == pytest.approx(
        defaults["mass_kg"] * paper["mass_ratio"].value, rel=1e-15
    )


def test_the_page_declares_the_words_that_it_is_given() -> None:
    declared = (ROOT / "service/page/words.d.ts").read_text()
    given = re.findall(r'^ "(\w+)":', words_module().decode(), re.MULTILINE)
    words = json.loads(words_module().decode().partition("WORDS = ")[2].rstrip().rstrip(";"))
    assert set(words["in_units"]) <= set(words["names_in_si"])
    assert sorted(re.findall(r"^  (\w+):", declared, re.MULTILINE)) == sorted(given)
    modules = "".join(file.read_text() for file in (ROOT / "service/page").glob("*.js"))
    assert [name for name in given if f"WORDS.{name}" not in modules] == []


@pytest.mark.parametrize(
    ("page", "name"),
    [
        ("docs/response-classes.md", "response classes"),
        ("docs/contact.md", "contact models"),
        ("docs/glossary.md", "dimensions"),
    ],
)
def test_a_page_about_a_vocabulary_names_all_of_it(page: str, name: str) -> None:
    text = (ROOT / page).read_text()
    assert [word for word in VOCABULARIES[name] if f"`{word}`" not in text and word != "unknown"] == []
