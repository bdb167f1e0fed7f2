"""The command design: from a specification to a damper, with every evaluation a study in the store."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from damperlab.service.cli.computing import Computer, Means, computes
from damperlab.service.cli.documents import check_document, write_document
from damperlab.service.cli.failures import FAILED
from damperlab.service.cli.options import AsJson, DataDir, Details
from damperlab.service.cli.output import note, print_brief, print_json, say, working
from damperlab.service.cli.places import file_option
from damperlab.service.cli.run import find_or_submit
from damperlab.service.cli.store import data_folder, open_store
from damperlab.studies.store.provenance import DESIGNS

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    import xarray as xr

    from damperlab.service.cli.progress import Shown
    from damperlab.studies.design.found import Found
    from damperlab.studies.kind import AnyStudy
    from damperlab.studies.specification.specification import Specification


@computes
def design(
    specification: Annotated[
        str,
        typer.Argument(
            metavar="SPEC",
            help="A .json or .yaml file that says what must be quiet, or a named specification such as prototype.",
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
    """Find a damper for a specification: what to build, how far it may be off, and what the alternatives are."""
    check_document(output)
    from damperlab.service.designs import HERE_SECONDS, budget_of
    from damperlab.studies.design.design import designing
    from damperlab.studies.ground.shelf import Shelf
    from damperlab.studies.specification.reading import read_specification
    from damperlab.studies.understood import unusual_specification

    asked = read_specification(specification, Shelf(data_folder(data_dir)))
    with working("Planning"):
        budget = budget_of(asked)
        if dry_run:
            next(
                designing(asked, budget)
            )  # a budget that ends before the first look does is refused here too
    unusual = unusual_specification(asked)
    if dry_run:
        _print_size(asked, budget, unusual, as_json)
        return
    for line in unusual:
        note(line)
    with Computer(open_store(data_dir), means, HERE_SECONDS) as computer:
        found = _search(asked, budget, _Evaluation(computer, asked))
    from damperlab.studies.design.answer import answer_document

    document = answer_document(found)
    if output is not None:
        with working(f"Writing {output}"):
            from damperlab.service.design_report import design_report

            write_document(design_report(found), output)
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
        Of all of them.
    asked : Specification
        What they are for.
    """

    def __init__(self, computer: Computer, asked: "Specification") -> None:
        self._computer = computer
        self._more = {DESIGNS: asked.digest}

    def cube(self, study: "AnyStudy", shown: "AbstractContextManager[Shown]") -> "xr.Dataset":
        """Compute a study, unless it is stored, and read its results.

        Parameters
        ----------
        study : Study or Suite
            Which.
        shown : context of Shown
            Shows its progress.

        Raises
        ------
        Exit
            If the study did not get done.
        """
        store = self._computer.store
        record = find_or_submit(store, study, True, self._more)
        if record.state != "done":
            record = self._computer.compute(record, shown=shown)
        if record.state != "done":
            note(
                "damperlab: stopped before the design was done. Run the same command again to go on with it; its study "
                f"{record.id} is {record.state}."
            )
            raise typer.Exit(FAILED)
        return store.cube(record.id).load()


def _search(asked: "Specification", budget: int, evaluation: _Evaluation) -> "Found":
    """Follow the search to its end, and say on the way what is known."""
    from damperlab.service.cli.design_progress import DesignProgress
    from damperlab.service.documents import plain
    from damperlab.studies.design.answer import known_document
    from damperlab.studies.design.design import designing
    from damperlab.studies.design.so_far import best_so_far

    rounds = designing(asked, budget)
    with DesignProgress(budget) as progress:
        try:
            ask = next(rounds)
            while True:
                best = "" if ask.ahead is None else best_so_far(plain(known_document(asked, ask.ahead)))
                progress.begin(ask.spent, ask.stage, best)
                points, cubes = ask.spent, []
                for study in ask.studies:
                    cubes.append(evaluation.cube(study, progress.of_study(points)))
                    points += study.points
                ask = rounds.send(cubes)
        except StopIteration as end:
            found: Found = end.value
            return found


def _print_size(asked: "Specification", budget: int, unusual: list[str], as_json: bool) -> None:
    free = list(asked.free)
    if as_json:
        size = {"name": asked.name, "digest": asked.digest, "chosen": free, "budget_points": budget}
        print_json(size | {"understood": unusual})
    else:
        chosen = (
            f"Chosen: {', '.join(free)}" if free else "Nothing is to be chosen: the damper given is assessed"
        )
        say(f"{asked.name or 'The specification'} is complete. {chosen}. Budget: {budget:,} points.")
        for line in unusual:
            say(line)
