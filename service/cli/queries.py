"""Commands that ask a stored study: response, optimum, importance, fragility. A table, a JSON document, or a file."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from damperlab.service.cli.asked import asks
from damperlab.service.cli.options import AsJson, DataDir, Details, Output, StudyId, check_file
from damperlab.service.cli.output import (
    make_parent,
    note,
    number,
    print_brief,
    print_json,
    print_table,
    say,
    working,
)
from damperlab.service.cli.store import label, open_store
from damperlab.service.cli.words import (
    axes_of,
    completeness_sentence,
    response_brief,
    rows_table,
    slice_sentence,
    words_of,
)
from damperlab.studies.brief import MOST_ROWS
from damperlab.studies.questions import Followed, Fragile, Judging, Ranking, Second, Varied

RANKED = {
    "value": "amplitude_ratio",
    "error": "amplitude_error",
    "amplitude": "amplitude_ratio",
    "mass": "mass_ratio",
    "clearance": "clearance_ratio",
    "impact_speed": "impact_speed_max",
}
"""What columns of a ranking mean."""

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    import xarray as xr
    from matplotlib.figure import Figure

    from damperlab.studies.answers.phrases import Phrases
    from damperlab.studies.store.record import Record


@asks
def response(
    study: StudyId,
    selection: Followed,
    second: Second,
    output: Output = None,
    data_dir: DataDir = None,
    details: Details = False,
    as_json: AsJson = False,
) -> None:
    """Show a frequency response of one design, or compare that of two studies."""
    check_file(output)
    if selection.interpolate and second.with_ is not None:
        raise typer.BadParameter("--interpolate and --with cannot be combined. Leave one of them out.")
    record, cube = ask(study, data_dir, "response", amplitudes=True)
    from damperlab.service.answers import response_document
    from damperlab.studies.answers.compared_response import compared_response
    from damperlab.studies.answers.frequency_response import frequency_response
    from damperlab.studies.answers.phrases import Phrases
    from damperlab.studies.answers.selection import main_metric

    metric = selection.metric or main_metric(cube)
    if second.with_ is None:
        with working("Reading the cube"):
            answer = frequency_response(cube, selection)
    else:
        other, its = ask(second.with_, data_dir, "response", amplitudes=True)
        with working("Reading the cubes"):
            answer = compared_response(cube, its, selection)
        answer.attrs["studies"] = [record.id, other.id]
        names = (record.name or record.id, other.name or other.id)

    def draw() -> "Figure":
        from damperlab.service.figures.curves import draw_compared, draw_response

        return draw_response(answer, metric) if second.with_ is None else draw_compared(answer, metric, names)

    def tell() -> None:
        phrases = Phrases.of(cube).as_named(selection.metric)
        print_brief(response_brief(answer, metric, phrases).document(), (), details)
        if not details:
            return
        say(slice_sentence(answer, metric, label(record), phrases))
        print_table(
            *rows_table(answer, phrases, {"other": metric, "other_amplitude_error": "amplitude_error"})
        )
        say_if(completeness_sentence(answer))

    hand_out(record, answer, output, as_json, draw, lambda: response_document(answer, metric), tell)


@asks
def optimum(
    study: StudyId,
    judging: Judging,
    ranking: Ranking,
    output: Output = None,
    data_dir: DataDir = None,
    details: Details = False,
    as_json: AsJson = False,
) -> None:
    """Rank the designs of a study, the best first; dampers of a suite or over base amplitudes by their worst case."""
    check_file(output)
    record, cube = ask(study, data_dir)
    from damperlab.service.answers import ranking_document
    from damperlab.studies.answers.phrases import Phrases
    from damperlab.studies.answers.ranking import ranked_designs

    def opened(others: "Iterable[str]") -> "dict[str, xr.Dataset]":
        follow_ups = [ask(other, data_dir, "optimum --with") for other in others]
        return {record.id: cube} | {other.id: its for other, its in follow_ups}

    with working("Judging the designs"):
        answer = ranked_designs(cube, judging, ranking, opened)

    def draw() -> "Figure":
        from damperlab.service.figures.curves import draw_ranking

        return draw_ranking(answer)

    def tell() -> None:
        phrases, words = Phrases.of(cube), words_of(answer)
        told = [*(doubt["sentence"] for doubt in words.get("doubts", ())), words["note"]]
        print_brief(words["brief"], told, details)
        # a front is its designs
        if answer.sizes["rank"] > 1 and (details or "pareto" in answer.attrs):
            shown = answer.drop_vars(["lowest", "highest"], errors="ignore")
            shown = shown if details else shown.isel(rank=slice(MOST_ROWS))
            print_table(*rows_table(shown, phrases, RANKED | _worst_of(answer, phrases), axes_of(cube)))

    hand_out(record, answer, output, as_json, draw, lambda: ranking_document(answer), tell)


@asks
def importance(
    study: StudyId,
    varied: Varied,
    output: Output = None,
    data_dir: DataDir = None,
    as_json: AsJson = False,
) -> None:
    """Say which parameter matters: the share of a result's variance over the grid that each explains alone."""
    check_file(output)
    record, cube = ask(study, data_dir)
    from damperlab.service.comparisons import columns_document
    from damperlab.studies.answers.importance import importance as shared_out
    from damperlab.studies.answers.phrases import Phrases

    with working("Reading the cube"):
        answer = shared_out(cube, varied)

    def draw() -> "Figure":
        from damperlab.service.figures.importance import draw_importance

        return draw_importance(answer)

    def tell() -> None:
        phrases = Phrases.of(cube)
        of = answer.attrs["metric"]
        say(words_of(answer)["note"])
        columns = (answer[name].values.tolist() for name in ("dimension", "share", "effect", "number"))
        rows = (
            (phrases.label(name), number(share, 4), number(phrases.printed(of, effect)), str(size))
            for name, share, effect, size in zip(*columns, strict=True)
        )
        print_table(("parameter", "share", phrases.column("effect", of), "values"), rows)

    hand_out(record, answer, output, as_json, draw, lambda: columns_document(answer), tell)


@asks
def fragility(
    study: StudyId,
    fragile: Fragile,
    output: Output = None,
    data_dir: DataDir = None,
    details: Details = False,
    as_json: AsJson = False,
) -> None:
    """Say how likely a damper of a ground-motion suite exceeds a limit, as its records are scaled up."""
    check_file(output)
    record, cube = ask(study, data_dir)
    from damperlab.service.comparisons import columns_document
    from damperlab.studies.answers.fragility import fragility as fitted
    from damperlab.studies.answers.phrases import Phrases

    with working("Reading the cube"):
        answer = fitted(cube, fragile)

    def draw() -> "Figure":
        from damperlab.service.figures.fragility import draw_fragility

        return draw_fragility(answer)

    def tell() -> None:
        print_brief(answer.attrs["brief"], [answer.attrs["note"]], details)
        shares = ("exceeded", "probability")
        metric = str(answer.attrs["metric"])
        of_metric = {str(name): metric for name in answer.data_vars if name not in shares}
        if details:
            print_table(*rows_table(answer, Phrases.of(cube), of_metric))

    hand_out(record, answer, output, as_json, draw, lambda: columns_document(answer), tell)


def _worst_of(answer: "xr.Dataset", phrases: "Phrases") -> dict[str, str]:
    """Say what value and error mean where dampers are ranked by their worst case."""
    metric = str(answer.attrs.get("metric", RANKED["value"]))
    error = metric.replace("amplitude", "amplitude_error", 1)
    return {"value": metric} | ({"error": error} if phrases.unit(error) else {})


def ask(
    study: str, data_dir: Path | None, harmonic: str = "", amplitudes: bool = False
) -> "tuple[Record, xr.Dataset]":
    """Find a study and open its cube; `harmonic` names a question that no suite answers, see `require_harmonic`."""
    from damperlab.studies.answers.suite import require_harmonic

    store = open_store(data_dir)
    record = store.find(study)
    if harmonic:
        require_harmonic(record.dimensions, harmonic, amplitudes)
    return record, store.cube(record.id)


def hand_out(
    record: "Record",
    answer: "xr.Dataset",
    output: Path | None,
    as_json: bool,
    draw: "Callable[[], Figure] | None",
    document: "Callable[[], dict[str, Any]]",
    tell: "Callable[[], None]",
) -> None:
    """Give an answer in the form that was asked for: a file, a JSON document, or words.

    Parameters
    ----------
    record, answer : Record, Dataset
        The study and what it answered.
    output : Path or None
        The file to write: the numbers as CSV, else a figure.
    as_json : bool
        Whether to print the document.
    draw, document, tell : callable
        Make the figure (None where there is none), make the document, print the words.
    """
    if output is not None:
        with working(f"Writing {output}"):
            make_parent(output)
            if output.suffix == ".csv" or draw is None:
                from damperlab.studies.answers.classes import with_words
                from damperlab.studies.answers.quantities import with_quantities

                with_quantities(with_words(answer), record.definition).to_dataframe().to_csv(output)
            else:
                from damperlab.service.figures.style import save

                save(draw(), output)
        note(f"Wrote {output}.")
    if as_json:
        print_json(answered(record, document()))
    elif output is None:
        tell()


def answered(record: "Record", answer: dict[str, Any]) -> dict[str, Any]:
    """Put the study in front of its answer."""
    return {"study": record.id, "name": record.name, "state": record.state, **answer}


def say_if(text: str) -> None:
    """Say a sentence that there may not be."""
    if text:
        say(text)
