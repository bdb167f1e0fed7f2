"""One table of fields behind three doors: HTTP, the command line and the client offer the same, in the same words."""

import inspect
from pathlib import Path
from typing import Any

import pytest
from typer.main import get_command

from damperlab.service.app import create_app
from damperlab.service.cli.main import app
from damperlab.service.client import Client, Study
from damperlab.service.questions import every
from damperlab.service.questions.every import EVERY
from damperlab.service.settings import Settings
from damperlab.studies.field import Field, fields_of
from damperlab.studies.ground.quantities import QUANTITIES
from damperlab.studies.questions import (
    EVERY_AXIS,
    Boundary,
    Compared,
    FollowUps,
    Judging,
    Search,
    Simulated,
    Step,
)
from damperlab.studies.unit_names import RESULTS
from damperlab.studies.variables import BEFORE, DIMENSIONS, VARIABLES

STUDY = "/api/v1/studies/{study_id}"
QUESTIONS: list[tuple[str, str, Any, tuple[type, ...]]] = [
    *(
        (f"{STUDY}/{each.route}", each.command, getattr(Study, each.method), each.asks)
        for each in EVERY
        if each.asks
    ),
    (f"{STUDY}/refine", "refine", Study.refine, (Search, Judging, FollowUps)),
    (f"{STUDY}/refine-boundary", "refine", Study.refine_boundary, (Boundary, Step, FollowUps)),
    ("/api/v1/simulate", "simulate", Client.simulate, (Simulated,)),
    ("/api/v1/earthquake-comparisons", "earthquake", Client.earthquake_comparison, (Compared,)),
]
"""Route, command and method of every question, and the values that it is made of."""

EVERYWHERE = {"self", "study", "contact", "particle", "values", *DIMENSIONS, *BEFORE}
"""What no question's field is: a design point's ratios, and the scene."""

OWN_DEFAULTS = {
    # of a front all designs are listed, of a ranking ten
    ("optimal_designs", "top"): None,
    # a method needs what the command and the route tell apart by leaving it out
    ("refine_boundary", "along"): inspect.Parameter.empty,
    # a map of a notebook fits its cell, a document as much as the service says
    ("simulate", "history"): None,
    ("simulate", "samples"): None,
}
OWN_HTTP_DEFAULTS = {("/api/v1/simulate", "history"), ("/api/v1/simulate", "samples")}


def test_the_list_names_every_file_of_a_question() -> None:
    folder = Path(every.__file__).parent
    files = {path.stem for path in folder.glob("*.py") if " = Question(" in path.read_text()}
    assert {question.answer.__module__.rpartition(".")[2] for question in EVERY} == files


@pytest.fixture(scope="module")
def document(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return create_app(Settings(data_dir=Path(tmp_path_factory.mktemp("doors")))).openapi()


def offered(questions: tuple[type, ...], door: str) -> dict[str, Field]:
    fields = [each for question in questions for each in fields_of(question) if door in each.doors]
    return {each.name: each for each in fields}


def parameters(document: Any, path: str) -> dict[str, tuple[str, Any]]:
    """Description and default of every parameter of a route, or of every key of its body."""
    ((_, operation),) = document["paths"][path].items()
    schemas = document["components"]["schemas"]
    if "requestBody" in operation:
        reference = operation["requestBody"]["content"]["application/json"]["schema"]["$ref"]
        found = schemas[reference.rsplit("/", 1)[-1]]["properties"]
        return {name: (each.get("description", ""), each.get("default")) for name, each in found.items()}
    return {
        each["name"]: (each["description"], each["schema"].get("default"))
        for each in operation.get("parameters", ())
        if each["in"] == "query"
    }


def written(field: Field) -> Any:
    """A field's default as text of a query or an option."""
    if field.is_range and field.default is not None:
        return "{:g},{:g}".format(*field.default)
    return None if field.is_list or field.is_named or field.needed else field.default


@pytest.mark.parametrize(("path", "questions"), [(each[0], each[3]) for each in QUESTIONS])
def test_a_route_takes_the_fields_of_its_question_and_no_others(
    document: Any, path: str, questions: tuple[type, ...]
) -> None:
    found = parameters(document, path)
    fields = offered(questions, "http")
    named = {*EVERY_AXIS, *VARIABLES, *RESULTS} if any(each.is_named for each in fields.values()) else set()
    for field in fields.values():
        if field.is_named:
            continue
        description, default = found.pop(field.key)
        if field.key != "record" or path.startswith(STUDY):  # a body may hold what generates one
            assert description.startswith(field.help)
        if field.needed:
            assert default is None
        elif (path, field.key) not in OWN_HTTP_DEFAULTS:
            assert default == written(field), field
    assert set(found) <= named | EVERYWHERE | set(QUANTITIES)


@pytest.mark.parametrize("command", sorted({each[1] for each in QUESTIONS}))
def test_a_command_takes_the_fields_of_its_question_and_no_others(command: str) -> None:
    questions = tuple(question for each in QUESTIONS if each[1] == command for question in each[3])
    options = {
        spelling: parameter
        for parameter in get_command(app).commands[command].params  # type: ignore[attr-defined]
        for spelling in parameter.opts
        if spelling.startswith("--")
    }
    for field in offered(questions, "command").values():
        for spelling in field.options:
            option = options.pop(spelling)
            assert option.help.startswith(field.help)
            assert (option.default or None) == (written(field) or None), field
    of_this_machine = {
        "--json", "--details", "--data-dir", "--output", "-o", "--workers", "--scheduler", "--contact", "--contact-time",
        "--no-particle", "--at", "--units", "--kanai-tajimi", "--duration-s", "--peak-g", "--generate", "--cluster", "--wait",
            "--friction",
    }  # fmt: skip
    design = {f"--{name.replace('_', '-')}" for name in (*DIMENSIONS, *BEFORE, *QUANTITIES)}
    rest = {spelling for spelling, option in options.items() if not option.hidden}
    assert rest <= of_this_machine | design


@pytest.mark.parametrize(("method", "questions"), [(each[2], each[3]) for each in QUESTIONS])
def test_a_method_takes_the_fields_of_its_question_and_no_others(
    method: Any, questions: tuple[type, ...]
) -> None:
    found = dict(inspect.signature(method).parameters)
    for field in offered(questions, "client").values():
        parameter = found.pop(field.name)
        assert field.help in inspect.getdoc(method), field
        if field.is_named:
            assert parameter.kind is inspect.Parameter.VAR_KEYWORD
        elif field.needed:
            assert parameter.default is inspect.Parameter.empty
        elif (method.__name__, field.name) in OWN_DEFAULTS:
            assert parameter.default == OWN_DEFAULTS[method.__name__, field.name]
        else:
            assert parameter.default == field.default
    assert set(found) <= EVERYWHERE
