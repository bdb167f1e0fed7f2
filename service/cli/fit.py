"""`damperlab fit` estimates parameters of a prototype from a measured frequency response or time history."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

import typer

from damperlab.service.cli.asked import Values, names_a_design
from damperlab.service.cli.fit_files import check_output, write_fit, write_history_fit, write_study
from damperlab.service.cli.options import (
    AsJson,
    Contact,
    ContactTime,
    check_file,
    contact_document,
    read_number,
    read_range,
)
from damperlab.service.cli.output import print_json, print_table, say, working
from damperlab.service.cli.places import file_option
from damperlab.service.cli.spelled import in_options
from damperlab.service.cli.warm import have_ready
from damperlab.studies.field import option_of
from damperlab.studies.quantity import QUANTITY_OF
from damperlab.studies.variables import DIMENSION_LONG_NAMES, MADE_BY

if TYPE_CHECKING:
    from damperlab.service.fit_report import FitDocument
    from damperlab.studies.fit.fitted import Fitted
    from damperlab.studies.fit.history.fitted import FittedHistory
    from damperlab.worker.scenes import Scene

STUDIES = (".yaml", ".yml", ".json")


Direction = Literal["rest", "up", "down"]
"""Start of each response: at rest, or in a frequency sweep upwards or downwards."""

NAMES = (
    *(name for name in DIMENSION_LONG_NAMES if name != "frequency_ratio"),
    *("mass_kg", "natural_frequency_hz", "base_amplitude_m", "damping_n_s_per_m", "friction_force_n"),
    *("clearance_m", "particle_mass_kg", *MADE_BY.values()),
)
"""Names of the parameters of a prototype that may be given or estimated."""
OPTIONS = {name: option_of(name) for name in (*NAMES, "deviation", "confidence", "seed")} | {
    f"fit.{name}": f"--fit {name}" for name in NAMES
}
"""Command-line option for each field of a fit."""


@names_a_design(
    dict.fromkeys(NAMES, ""),
    QUANTITY_OF,
    "Known values, as --at restitution=0.5 or --restitution 0.5: "
    f"damping_ratio, {', '.join(name for name in NAMES if not name.endswith('_ratio'))}, and the ratios of a study.",
)
def fit(
    design: Values,
    measured: Annotated[
        Path,
        typer.Argument(
            metavar="MEASURED.csv",
            help="Columns: frequency (Hz); amplitude (mm) or X/Z; conditions that differ by row. Or a time history: time (s); "
            "displacement (mm); base acceleration (m/s2).",
            show_default=False,
        ),
    ],
    free: Annotated[
        list[str] | None,
        typer.Option(
            "--fit",
            metavar="NAME",
            help="Parameter to estimate, or NAME=LOW,HIGH for a range. May be repeated.",
        ),
    ] = None,
    structure: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="File with the known values, in the form of a study; a parameter given as an axis is estimated within "
            "the range of the axis.",
        ),
    ] = None,
    no_particle: Annotated[
        bool, typer.Option("--no-particle", help="The structure has no particle.")
    ] = False,
    contact: Contact = "instant",
    contact_time: ContactTime = None,
    start: Annotated[
        Direction | None,
        typer.Option(
            metavar="WAY",
            help="Start of each response: rest; or up or down, for a frequency sweep in that direction.",
            show_default=False,
        ),
    ] = None,
    deviation: Annotated[
        str | None,
        typer.Option(
            metavar="SHARE",
            help="Standard deviation of the measurement, for example 5%; by default from the table, or from "
            "the scatter.",
        ),
    ] = None,
    confidence: Annotated[float, typer.Option(metavar="SHARE", help="Confidence of the intervals.")] = 0.95,
    seed: Annotated[int, typer.Option(min=0, metavar="N", help="Seed of the random draws.")] = 0,
    study: Annotated[
        Path | None,
        file_option(
            help="Write the fitted prototype as a study, for `run`.",
        ),
    ] = None,
    output: Annotated[
        Path | None,
        file_option(
            "--output",
            "-o",
            help="Write a .png or .svg figure, or a .html or .pdf report.",
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Estimate parameters of a prototype from a measurement.

    Every value must be given, be a column of the table, or be estimated. No value is assumed.
    """
    check_output(output)
    check_file(study, STUDIES)
    ranges = _ranges(free)
    with working("Reading the measurement"):
        from damperlab.studies.fit.document import read_structure, read_table
        from damperlab.studies.fit.history.question import History

        known: dict[str, Any] = {} if structure is None else read_structure(structure)
        known |= contact_document(contact, contact_time)
        if no_particle:
            known["particle"] = False
        if start is not None:
            swept = {"kind": "continuation", "direction": start}
            known["start"] = "rest" if start == "rest" else swept
        table = read_table(measured)
    way = _of_history() if isinstance(table, History) else _of_response()
    with in_options(OPTIONS):
        share = _share(deviation)
        question = way.ask(table, known, ranges, known=design, share=share, confidence=confidence, seed=seed)
        if study is not None:
            way.check_study(question)
        have_ready(way.scenes(question))
        computed = [0]
        with working(lambda: f"Fitting, {computed[0]} {way.computed} computed"):
            fitted = way.fit(question, lambda number: computed.__setitem__(0, number))
        if study is not None:
            write_study(fitted, study)
        if output is not None:
            way.write(fitted, output)
        if as_json:
            print_json(way.document(fitted))
        else:
            _print(fitted, way)


class _Way(NamedTuple):
    """Functions for one kind of measured table: they make the request, compute the fit, and write the answer."""

    ask: Callable[..., Any]
    scenes: Callable[[Any], "list[Scene]"]
    fit: Callable[[Any, Callable[[int], None]], Any]
    verdict: Callable[[Any], list[str]]
    document: "Callable[..., FitDocument]"
    write: Callable[..., None]
    check_study: Callable[[Any], object]
    computed: str


def _of_response() -> _Way:
    from damperlab.service.fit_report import fit_document
    from damperlab.studies.fit.asking import make_question
    from damperlab.studies.fit.verdict import verdict
    from damperlab.worker.fit.estimate import fit_response
    from damperlab.worker.fit.model import scenes_of

    return _Way(
        make_question,
        scenes_of,
        fit_response,
        verdict,
        fit_document,
        write_fit,
        # a fit of a frequency response can always be written as a study
        lambda question: None,
        "sets of parameters",
    )


def _of_history() -> _Way:
    from damperlab.service.history_report import history_document
    from damperlab.studies.fit.history.asking import make_history_question
    from damperlab.studies.fit.history.fitted import check_study
    from damperlab.studies.fit.verdict import verdict_of_history
    from damperlab.worker.fit.history.estimate import fit_history
    from damperlab.worker.fit.history.march import scenes_of

    says, document = verdict_of_history, history_document
    return _Way(
        make_history_question,
        scenes_of,
        fit_history,
        says,
        document,
        write_history_fit,
        check_study,
        "histories",
    )


def _ranges(free: list[str] | None) -> dict[str, tuple[float, float] | None]:
    """Read the values of --fit, each of the form ``name`` or ``name=low,high``."""
    found: dict[str, tuple[float, float] | None] = {}
    for text in free or ():
        name, equals, span = text.partition("=")
        if name in found:
            raise typer.BadParameter(f"{name} is given twice. Leave one of them out.", param_hint="--fit")
        found[name] = read_range("--fit", span) if equals else None
    return found


def _share(text: str | None) -> float | None:
    """Read the value of --deviation, for example ``5%`` or ``0.05``, as a fraction."""
    if text is None:
        return None
    if text.endswith("%"):
        return read_number("--deviation", text.removesuffix("%")) / 100.0
    return read_number("--deviation", text)


def _print(fitted: "Fitted | FittedHistory", way: _Way) -> None:
    """Print the estimated parameters, and the sentences of the verdict."""
    from damperlab.service.fit_report import COLUMNS, parameter_rows

    print_table(COLUMNS, parameter_rows(fitted.estimates))
    say(f"Intervals of {100 * fitted.question.confidence:g} %; {fitted.evaluations} {way.computed} computed.")
    for sentence in way.verdict(fitted):
        say(sentence)
