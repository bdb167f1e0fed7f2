"""Commands that evaluate a stored study. The output is text with a table, a JSON document, or a file."""

from dataclasses import replace
from inspect import Parameter, Signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from damperlab.service.cli.asked import Command, asks, parameter
from damperlab.service.cli.options import AsJson, DataDir, Details, Output, StudyId, check_file
from damperlab.service.cli.output import make_parent, note, print_brief, print_json, print_table, say, working
from damperlab.service.cli.store import find_study, folder_option, label, open_store
from damperlab.service.questions.question import Question, Subject, Words, in_front

if TYPE_CHECKING:
    import xarray as xr


def command_of(question: Question[Any]) -> Command:
    """Return the command that answers a question, with options for the inputs of the question."""
    kinds = {kind.__name__.lower(): kind for kind in question.asks}

    def command(
        study: str,
        data_dir: Path | None = None,
        output: Path | None = None,
        details: bool = False,
        as_json: bool = False,
        **asked: Any,
    ) -> None:
        check_file(output)
        values = [asked[name] for name in kinds]
        store = open_store(data_dir)
        subject = Subject(find_study(store, study), store, question.command)
        with working("Reading the cube"):
            answer = question.of(subject, *values)
        if question.further and asked[question.further.option]:
            values = _with_further(question, subject, answer, values)
            with working("Reading the cubes"):
                answer = question.of(subject, *values)
        if output is not None:
            _write(question, subject, answer, output, in_units=not _in_ratios(values))
        if as_json:
            print_json(in_front(subject.record, question.form.write(answer)))
        elif output is None:
            words = question.tell(subject, answer, details or not question.details, *values)
            _say(words, details, folder_option(store.data_dir))

    options: dict[str, tuple[Any, Any]] = {"output": (Output, None), "data_dir": (DataDir, None)}
    options |= {"details": (Details, False)} if question.details else {}
    if further := question.further:
        offered = Annotated[bool, typer.Option(f"--{further.option}", help=further.help)]
        options |= {further.option: (offered, False)}
    options |= {"as_json": (AsJson, False)}
    command.__signature__ = Signature(  # type: ignore[attr-defined]
        [
            parameter("study", StudyId, Parameter.empty),
            *(parameter(name, kind, Parameter.empty) for name, kind in kinds.items()),
            *(parameter(name, *each) for name, each in options.items()),
        ]
    )
    command.__name__, command.__doc__ = question.command, question.help
    return asks(command)


def _with_further(
    question: Question[Any], subject: Subject, answer: "xr.Dataset", values: list[Any]
) -> list[Any]:
    """Compute the further studies that an answer needs, and return the inputs with the ids of these studies."""
    from damperlab.service.cli.computing import Computer, Means
    from damperlab.service.cli.searches import compute_follow_up

    assert question.further is not None
    with Computer(subject.store, Means()) as computer:
        found = [
            compute_follow_up(computer, each, subject.record).id
            for each in question.further.studies(subject, answer, *values)
        ]
    return [replace(each, with_=(*each.with_, *found)) if hasattr(each, "with_") else each for each in values]


def _in_ratios(asked: list[Any]) -> bool:
    """Return whether the user named a variable of the cube, such as `amplitude_ratio`.

    If so, all results are written as ratios.
    """
    from damperlab.studies.variables import VARIABLES

    return any(getattr(each, "metric", None) in VARIABLES for each in asked)


def _write(
    question: Question[Any], subject: Subject, answer: "xr.Dataset", output: Path, in_units: bool
) -> None:
    """Write an answer to a file: the values as a table if the suffix is .csv, otherwise a figure."""
    with working(f"Writing {output}"):
        make_parent(output)
        from damperlab.studies.answers.quantities import with_quantities, with_words

        if output.suffix == ".csv":
            with_quantities(with_words(answer), subject.record.definition).to_dataframe().to_csv(output)
        else:
            from damperlab.service.figures.style import save

            names = tuple(label(subject.beside(each).record) for each in answer.attrs.get("studies", ()))
            if question.draws_units and in_units and not names:
                answer = with_quantities(answer, subject.record.definition)
            save(question.draw(answer, names), output)
    note(f"Wrote {output}.")


def _say(words: Words, details: bool, folder: str) -> None:
    """Print an answer in words."""
    if words.brief is None:
        for sentence in words.sentences:
            say(sentence)
    else:
        print_brief(words.brief, words.sentences, details, folder)
    if words.table is not None:
        print_table(*words.table)
    if details:
        for sentence in filter(None, words.after):
            say(sentence)
