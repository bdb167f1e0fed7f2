"""`damperlab design` finds a damper for a specification. Every evaluation is a study in the store."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from damperlab.service.cli.computing import Computer, Means, computes
from damperlab.service.cli.documents import check_document, write_document
from damperlab.service.cli.failures import FAILED
from damperlab.service.cli.options import AsJson, DataDir, Details
from damperlab.service.cli.output import note, print_brief, print_json, say, working
from damperlab.service.cli.places import file_option
from damperlab.service.cli.store import data_folder, open_store, settings_of
from damperlab.studies.store.provenance import DESIGNS

if TYPE_CHECKING:
    from collections.abc import Sequence

    import xarray as xr

    from damperlab.service.cli.design_progress import DesignProgress
    from damperlab.studies.design.design import Ask
    from damperlab.studies.design.found import Found
    from damperlab.studies.kind import AnyStudy
    from damperlab.studies.specification.specification import Specification
    from damperlab.studies.store.record import Record


@computes
def design(
    specification: Annotated[
        str,
        typer.Argument(
            metavar="SPEC",
            help="A .json or .yaml file with the specification, or the name of a built-in one, for example "
            "prototype.",
        ),
    ],
    output: Annotated[
        Path | None,
        file_option("--output", "-o", help="Write the report too, as .html or .pdf."),
    ] = None,
    data_dir: DataDir = None,
    *,
    means: Means,
    dry_run: Annotated[
        bool,
        typer.Option("--dry-run", help="Check the specification, and print its budget; compute nothing."),
    ] = False,
    details: Details = False,
    as_json: AsJson = False,
) -> None:
    """Find a damper for a specification.

    The answer gives the damper to build, the allowed deviations, and the alternatives.
    """
    check_document(output)
    from damperlab.service.design_budget import HERE_SECONDS, budget_of
    from damperlab.studies.design.design import designing
    from damperlab.studies.design.kept import now
    from damperlab.studies.ground.shelf import Shelf
    from damperlab.studies.specification.reading import read_specification
    from damperlab.studies.understood import unusual_specification

    asked = read_specification(specification, Shelf(data_folder(data_dir)))
    with working("Planning"):
        budget = budget_of(asked)
        if dry_run:
            next(designing(asked, budget))  # raises a fault if the budget does not cover the first round
    unusual = unusual_specification(asked)
    if dry_run:
        _print_size(asked, budget, unusual, as_json)
        return
    for line in unusual:
        note(line)
    started = now()
    with Computer(open_store(data_dir), means, HERE_SECONDS) as computer:
        found, rounds = _search(asked, budget, _Evaluation(computer, asked))
    from damperlab.studies.design.answer import answer_document

    document = answer_document(found)
    with working("Keeping the design"):
        report = _kept(data_dir, found, rounds, started)
    if output is not None:
        with working(f"Writing {output}"):
            write_document(report, output)
        note(f"Wrote the report to {output}.")
    if as_json:
        print_json(document)
    else:
        print_brief(document["verdict"], document["words"], details)


class _Evaluation:
    """Computes the studies of a design.

    Parameters
    ----------
    computer : Computer
        Computes the studies.
    asked : Specification
        The specification, recorded in the provenance of each study.
    """

    def __init__(self, computer: Computer, asked: "Specification") -> None:
        self._computer = computer
        self._more = {DESIGNS: asked.digest}

    def cubes(self, ask: "Ask", progress: "DesignProgress") -> "list[xr.Dataset]":
        """Return the results of the studies of a round. Studies that are not stored are computed first.

        Raises
        ------
        Exit
            If a study did not complete.
        """
        from damperlab.worker.run.small_batch import AT_ONCE

        store = self._computer.store
        records = self._entered(ask.studies)
        done = {record.id for record in records if record.state == "done"}
        left = [record for record in records if record.id not in done]
        for start in range(0, len(left), AT_ONCE):
            done |= self._computer.compute_together(left[start : start + AT_ONCE])
            progress.update(ask.spent + sum(each.points_total for each in records if each.id in done))
        points = ask.spent
        for record in records:
            if record.id not in done:
                now = self._computer.compute(record, shown=progress.of_study(points))
                if now.state != "done":
                    note(
                        "damperlab: stopped before the design was done. Run the same command again to continue "
                        f"it; its study {now.id} is {now.state}."
                    )
                    raise typer.Exit(FAILED)
            points += record.points_total
        return [store.cube(record.id).load() for record in records]

    def _entered(self, several: "Sequence[AnyStudy]") -> "list[Record]":
        """Return the records of studies. Studies that are not in the store are submitted together."""
        from damperlab.studies.plan import make_plan
        from damperlab.studies.store.life_cycle.entering import Submission
        from damperlab.worker.dispatch.cost_model import seconds_per_point
        from damperlab.worker.provenance import provenance

        store = self._computer.store
        known = {study.digest: store.newest(study.digest) for study in several}
        by = provenance() | self._more
        new = [
            Submission(study, make_plan(study, seconds_per_point).chunk, by)
            for study in several
            if known[study.digest] is None
        ]
        known |= {record.digest: record for record, _ in store.submit_all(new)} if new else {}
        return [record for study in several if (record := known[study.digest]) is not None]


def _kept(data_dir: Path | None, found: "Found", rounds: int, started: str) -> str:
    """Store the answer of a design for the page and the client, and return the report."""
    from damperlab.service.design_report import design_report, keep_answer
    from damperlab.studies.design.shelf import DesignsFull

    shelf = settings_of(data_dir).designs
    try:
        kept, _ = shelf.put(found.asked, found.book.budget)
    except DesignsFull as error:
        note(f"damperlab: the answer was not stored. {error}")
        return design_report(found)
    if kept.state in ("cancelled", "failed"):
        shelf.resume(kept.id)
    return keep_answer(shelf, kept.id, found, rounds, started)


def _search(asked: "Specification", budget: int, evaluation: _Evaluation) -> "tuple[Found, int]":
    """Search for a damper, and show the progress. Return the answer and the number of rounds."""
    from damperlab.service.cli.design_progress import DesignProgress
    from damperlab.service.documents import plain
    from damperlab.studies.design.answer import known_document
    from damperlab.studies.design.design import designing
    from damperlab.studies.design.spelling import best_so_far

    rounds, number = designing(asked, budget), 1
    with DesignProgress(budget) as progress:
        try:
            ask = next(rounds)
            while True:
                best = "" if ask.ahead is None else best_so_far(plain(known_document(asked, ask.ahead)))
                progress.begin(ask.spent, ask.stage, best)
                ask = rounds.send(evaluation.cubes(ask, progress))
                number += 1
        except StopIteration as end:
            found: Found = end.value
            return found, number


def _print_size(asked: "Specification", budget: int, unusual: list[str], as_json: bool) -> None:
    from damperlab.service.design_budget import size_document

    free = list(asked.free)
    if as_json:
        print_json(size_document(asked, budget, unusual))
    else:
        chosen = (
            f"Chosen: {', '.join(free)}"
            if free
            else "There is nothing to choose: the given damper is assessed"
        )
        told = f"{asked.name or 'The specification'} is complete. {chosen}. Budget: {budget:,} points"
        if asked.budget_points is None:
            told += (
                f", expected to take one core {asked.budget_minutes:g} min; the search itself comes on top"
            )
        say(f"{told}.")
        for line in unusual:
            say(line)
