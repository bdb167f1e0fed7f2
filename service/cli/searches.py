"""`damperlab refine` computes follow-up studies in search of better designs or of a class boundary."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import typer

from damperlab.service.cli.asked import asks
from damperlab.service.cli.computing import Computer, Means, computes
from damperlab.service.cli.failures import FAILED
from damperlab.service.cli.options import (
    AsJson,
    DataDir,
    Details,
    StudyId,
    check_alone,
    check_name,
)
from damperlab.service.cli.output import note, print_brief, print_json, working
from damperlab.service.cli.store import find_study, folder_option, open_store
from damperlab.service.cli.words import found_sentence
from damperlab.service.questions.question import in_front
from damperlab.studies.brief import Brief
from damperlab.studies.field import fields_of, given
from damperlab.studies.questions import Boundary, FollowUps, Judging, Search
from damperlab.studies.variables import DIMENSIONS

if TYPE_CHECKING:
    import xarray as xr

    from damperlab.studies.answers.follow_up import Refinement
    from damperlab.studies.definition import Study
    from damperlab.studies.store.record import Record

    Cubes = Mapping[str, xr.Dataset]


@asks
@computes
def refine(
    study: StudyId,
    search: Search,
    boundary: Boundary,
    judging: Judging,
    follow_ups: FollowUps,
    data_dir: DataDir = None,
    *,
    means: Means,
    details: Details = False,
    as_json: AsJson = False,
) -> None:
    """Compute finer studies where better designs may lie.

    The command can also locate a boundary between two classes of response, to a given tolerance.
    """
    along = boundary.along
    check_name("--boundary", along, DIMENSIONS)
    if along is None and boundary.at:
        raise typer.BadParameter(
            "--at applies to --boundary only. Restrict the designs with --within, or add --boundary.",
            param_hint="--at",
        )
    if along is not None:
        more = given(judging) | {
            name: value for name, value in given(search).items() if name in ("value_tolerance", "budget")
        }
        unused = {
            each.options[0]: True
            for question in (Judging, Search)
            for each in fields_of(question)
            if each.name in more
        }
        check_alone(unused, "a search for an optimum, which --boundary replaces")
    from damperlab.studies.answers.phrases import Phrases
    from damperlab.studies.answers.refine import refine_boundary, refine_optimum
    from damperlab.studies.answers.suite import require_harmonic
    from damperlab.studies.definition import parse_harmonic

    store = open_store(data_dir)
    record = find_study(store, study)
    require_harmonic(record.dimensions, "refine")
    asked = parse_harmonic(record.definition)

    def judge(cubes: "Cubes") -> "Refinement":
        if along is not None:
            return refine_boundary(asked, cubes, along, boundary.at, search.tolerance)
        return refine_optimum(asked, cubes, search, judging)

    with Computer(store, means) as computer:
        found, cubes = _pursue(computer, record, judge, follow_ups.dry_run)
    names = list(cubes)[1:]
    if as_json:
        from damperlab.service.questions.refinement import refinement_document

        print_json(in_front(record, {**refinement_document(found), "with": names}))
        return
    phrases = Phrases.of(cubes[record.id])
    told = [found.say(phrases), found_sentence(found.found, phrases)]
    brief = found.brief or Brief(None, (told[1][:1].upper() + told[1][1:] + ".",))
    told += [f"Follow-up studies: {', '.join(names)}."] if names else []
    print_brief(brief.document(), told, details, folder_option(store.data_dir))


def _pursue(
    computer: Computer, record: "Record", judge: "Callable[[Cubes], Refinement]", dry_run: bool
) -> "tuple[Refinement, Cubes]":
    """Judge the results and compute follow-up studies, until no follow-up study is needed.

    Returns
    -------
    Refinement, mapping of Dataset
        The last judgement, and the cubes of the study and of its follow-ups.
    """
    from damperlab.studies.answers.phrases import Phrases

    store = computer.store
    cubes = {record.id: store.cube(record.id)}
    phrases = Phrases.of(cubes[record.id])
    while True:
        with working("Judging"):
            found = judge(cubes)
        note(found.say(phrases))
        if not found.studies or dry_run:
            return found, cubes
        for each in found.studies:
            follow_up = compute_follow_up(computer, each, record)
            if follow_up.id in cubes:
                raise typer.Exit(FAILED)
            # a follow-up is small, and is judged again in every round
            cubes[follow_up.id] = store.cube(follow_up.id).load()


def compute_follow_up(computer: Computer, asked: "Study", parent: "Record") -> "Record":
    """Compute a follow-up study. If the computation stops early, finished blocks are kept and the command ends."""
    from damperlab.service.cli.run import find_or_submit
    from damperlab.studies.store.provenance import REFINES

    record = find_or_submit(computer.store, asked, True, {REFINES: parent.id})
    if record.state != "done":
        record = computer.compute(record)
    if record.state != "done":
        note(
            f"damperlab: the follow-up {record.id} is {record.state}. Run the same command again to continue."
        )
        raise typer.Exit(FAILED)
    return record
