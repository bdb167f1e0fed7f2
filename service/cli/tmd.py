"""Commands that compare and search further: tmd, robust, refine."""

from typing import TYPE_CHECKING, Annotated

import typer

from damperlab.service.cli.dialect import fixes_dimensions
from damperlab.service.cli.failures import FAILED
from damperlab.service.cli.options import (
    AsJson,
    At,
    Band,
    DataDir,
    ExcludeLocked,
    MaxImpactSpeed,
    Objective,
    Output,
    Scheduler,
    StudyId,
    Top,
    Within,
    Workers,
    check_cluster,
    check_file,
    check_name,
    read_at,
    read_judging,
    read_range,
)
from damperlab.service.cli.output import note, number, print_json, print_table, say, working
from damperlab.service.cli.queries import answered, ask, hand_out, say_if
from damperlab.service.cli.store import open_store
from damperlab.service.cli.words import completeness_sentence, rows_table, span
from damperlab.studies.variables import DIMENSIONS
from damperlab.studies.vocabulary import Criterion, Excitation

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    import xarray as xr
    from matplotlib.figure import Figure

    from damperlab.studies.answers.follow_up import Refinement
    from damperlab.studies.definition import Study
    from damperlab.studies.store.record import Record
    from damperlab.studies.store.store import Store


@fixes_dimensions
def tmd(
    study: StudyId,
    criterion: Annotated[
        Criterion,
        typer.Option(help="How the tuned mass damper is tuned."),
    ] = "minimax",
    mass_ratio: Annotated[
        float | None,
        typer.Option(
            "--tmd-mass-ratio",
            "--mass-ratio",
            help="Mass ratio μ of the tuned mass damper; that of the design by default.",
        ),
    ] = None,
    detuning: Annotated[
        float, typer.Option(help="Relative error of the tuned mass damper's frequency, 0.05 for 5 %.")
    ] = 0.0,
    damping_detuning: Annotated[
        float, typer.Option(help="Relative error of the tuned mass damper's damping.")
    ] = 0.0,
    excitation: Annotated[
        Excitation,
        typer.Option(
            help="Excitation: base motion, or a force on the structure (X over its static deflection)."
        ),
    ] = "base",
    at: At = None,
    output: Output = None,
    data_dir: DataDir = None,
    as_json: AsJson = False,
) -> None:
    """Compare one design of a study with a tuned mass damper of the same mass, over frequency."""
    check_file(output)
    fixed = read_at(at)
    record, cube = ask(study, data_dir, "tmd")
    from damperlab.service.comparisons import columns_document
    from damperlab.studies.answers.tmd_comparison import tmd_comparison

    with working("Tuning"):
        answer = tmd_comparison(cube, criterion, mass_ratio, detuning, damping_detuning, fixed, excitation)

    def draw() -> "Figure":
        from damperlab.service.figures.comparison import draw_comparison

        return draw_comparison(answer)

    def tell() -> None:
        say(answer.attrs["note"])
        better = ", ".join(span(low, high) for low, high in answer.attrs["hybrid_better"])
        say(
            f"The study's damper is better at r = {better}."
            if better
            else "The study's damper is better at no frequency."
        )
        print_table(*rows_table(answer))
        say_if(completeness_sentence(answer))

    hand_out(record, answer, output, as_json, draw, lambda: columns_document(answer), tell)


def robust(
    study: StudyId,
    amplitudes: Annotated[
        str, typer.Option(metavar="LO,HI", help="Range of the base amplitude, relative to the nominal one.")
    ] = "0.5,2",
    objective: Objective = None,
    band: Band = None,
    top: Top = 10,
    exclude_locked: ExcludeLocked = False,
    max_impact_speed: MaxImpactSpeed = None,
    within: Within = None,
    output: Output = None,
    data_dir: DataDir = None,
    as_json: AsJson = False,
) -> None:
    """Rank dampers of fixed force and clearance by their worst case while the base amplitude varies."""
    check_file(output, (".csv",))
    span = read_range("--amplitudes", amplitudes)
    judging = read_judging(objective, band, exclude_locked, max_impact_speed, within)
    record, cube = ask(study, data_dir, "robust")
    from damperlab.service.answers import designs_document
    from damperlab.studies.answers.robust import robust_designs

    with working("Following the rays"):
        answer = robust_designs(cube, span, top=top, **judging)

    def tell() -> None:
        say(answer.attrs["note"])
        print_table(*rows_table(answer))

    hand_out(record, answer, output, as_json, None, lambda: designs_document(answer), tell)


@fixes_dimensions
def refine(
    study: StudyId,
    tolerance: Annotated[
        float, typer.Option(help="Grid step down to which each parameter is refined.")
    ] = 1e-3,
    value_tolerance: Annotated[
        float,
        typer.Option(help="Relative improvement below which a design is not searched for."),
    ] = 0.01,
    budget: Annotated[
        int, typer.Option(help="Largest total number of points of all follow-up studies.")
    ] = 20_000,
    boundary: Annotated[
        str | None,
        typer.Option(
            metavar="DIMENSION",
            help="Locate where the response class changes along this dimension, in place of the optimum.",
        ),
    ] = None,
    at: At = None,
    objective: Objective = None,
    band: Band = None,
    exclude_locked: ExcludeLocked = False,
    max_impact_speed: MaxImpactSpeed = None,
    within: Within = None,
    data_dir: DataDir = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
    as_json: AsJson = False,
) -> None:
    """Compute finer follow-up studies where better designs may lie, or at a class boundary, down to the tolerance."""
    check_cluster(workers, scheduler)
    check_name("--boundary", boundary, DIMENSIONS)
    fixed = read_at(at)
    judging = read_judging(objective, band, exclude_locked, max_impact_speed, within)
    if boundary is None and fixed:
        raise typer.BadParameter(
            "--at applies to --boundary only. Restrict the designs with --within, or add --boundary.",
            param_hint="--at",
        )
    store = open_store(data_dir)
    record = store.find(study)
    from damperlab.studies.answers.refine import refine_boundary, refine_optimum
    from damperlab.studies.answers.survey import require_harmonic
    from damperlab.studies.definition import parse_harmonic

    require_harmonic(record.dimensions, "refine")
    asked = parse_harmonic(record.definition)

    def judge(cubes: "Mapping[str, xr.Dataset]") -> "Refinement":
        if boundary is not None:
            return refine_boundary(asked, cubes, boundary, fixed, tolerance)
        return refine_optimum(
            asked, cubes, tolerance, value_tolerance=value_tolerance, budget=budget, **judging
        )

    _follow(store, record, judge, workers, scheduler, as_json)


def race(
    study: StudyId,
    confidence: Annotated[
        float, typer.Option(help="Confidence with which the best design is to be known.")
    ] = 0.95,
    indifference: Annotated[
        float, typer.Option(help="Relative difference below which two designs count as equally good.")
    ] = 0.02,
    budget: Annotated[
        float, typer.Option(help="Largest total number of excitation cycles of all rounds.")
    ] = 5e7,
    objective: Objective = None,
    band: Band = None,
    exclude_locked: ExcludeLocked = False,
    max_impact_speed: MaxImpactSpeed = None,
    within: Within = None,
    data_dir: DataDir = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
    as_json: AsJson = False,
) -> None:
    """Compute the designs that may be the best for more and more cycles, until the best is known with the given confidence."""
    check_cluster(workers, scheduler)
    judging = read_judging(objective, band, exclude_locked, max_impact_speed, within)
    store = open_store(data_dir)
    record = store.find(study)
    from damperlab.studies.answers.race import race_designs
    from damperlab.studies.answers.survey import require_harmonic
    from damperlab.studies.definition import parse_harmonic

    require_harmonic(record.dimensions, "race")
    asked = parse_harmonic(record.definition)
    _follow(
        store,
        record,
        lambda cubes: race_designs(asked, cubes, confidence, indifference, budget, **judging),
        workers,
        scheduler,
        as_json,
    )


def _follow(
    store: "Store",
    record: "Record",
    judge: "Callable[[Mapping[str, xr.Dataset]], Refinement]",
    workers: int | None,
    scheduler: str | None,
    as_json: bool,
) -> None:
    """Judge, compute the follow-ups, and judge again, until nothing is left to compute."""
    ids = [record.id]
    while True:
        cubes = {name: store.cube(name) for name in ids}
        with working("Judging"):
            found = judge(cubes)
        note(found.note)
        if not found.studies:
            break
        for each in found.studies:
            follow_up = _compute(store, each, record, workers, scheduler)
            if follow_up.id in ids:
                raise typer.Exit(FAILED)
            ids.append(follow_up.id)
    if as_json:
        from damperlab.service.comparisons import refinement_document

        print_json(answered(record, {**refinement_document(found), "with": ids[1:]}))
    else:
        say(found.note)
        say(", ".join(f"{name} = {_cell(value)}" for name, value in found.found.items()))
        if ids[1:]:
            say(f"Follow-up studies: {', '.join(ids[1:])}.")


def _cell(value: object) -> str:
    return number(value) if isinstance(value, float) else str(value)


def _compute(
    store: "Store", asked: "Study", parent: "Record", workers: int | None, scheduler: str | None
) -> "Record":
    """Run a follow-up to its end; what is done of it is kept if it stops."""
    from damperlab.service.cli.run import compute, find_or_submit

    record = find_or_submit(store, asked, True, {"refines": parent.id})
    if record.state != "done":
        record = compute(store, record, workers, scheduler)
    if record.state != "done":
        note(
            f"damperlab: the follow-up {record.id} is {record.state}. Run the same command again to continue."
        )
        raise typer.Exit(FAILED)
    return record
