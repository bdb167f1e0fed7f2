"""The command design: from a specification to a damper, with every evaluation a study in the store."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from damperlab.service.cli.computing import Computer, Means, computes
from damperlab.service.cli.documents import check_document, write_document
from damperlab.service.cli.failures import FAILED
from damperlab.service.cli.options import AsJson, DataDir
from damperlab.service.cli.output import note, print_json, say, working
from damperlab.service.cli.run import find_or_submit
from damperlab.service.cli.store import data_folder, open_store
from damperlab.studies.store.provenance import DESIGNS

if TYPE_CHECKING:
    import xarray as xr

    from damperlab.studies.design.found import Found
    from damperlab.studies.kind import AnyStudy
    from damperlab.studies.specification.specification import Specification

HERE_SECONDS = 2.0
"""Expected work of one study up to which it is computed in this process: a cluster takes longer to hand it out."""


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
        typer.Option("--output", "-o", metavar="FILE", help="Write the report too, as .html or .pdf."),
    ] = None,
    data_dir: DataDir = None,
    *,
    means: Means,
    dry_run: Annotated[
        bool,
        typer.Option("--dry-run", help="Check the specification, and print its budget; compute nothing."),
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Find a damper for a specification: what to build, how far it may be off, and what the alternatives are."""
    check_document(output)
    from damperlab.service.designs import budget_of
    from damperlab.studies.ground.shelf import Shelf
    from damperlab.studies.specification.reading import read_specification

    asked = read_specification(specification, Shelf(data_folder(data_dir)))
    with working("Planning"):
        budget = budget_of(asked)
    if dry_run:
        _print_size(asked, budget, as_json)
        return
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
        for sentence in document["words"]:
            say(sentence)


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

    def cube(self, study: "AnyStudy") -> "xr.Dataset":
        """Compute a study, unless it is stored, and read its results.

        Raises
        ------
        Exit
            If the study did not get done.
        """
        store = self._computer.store
        record = find_or_submit(store, study, True, self._more)
        if record.state != "done":
            record = self._computer.compute(record)
        if record.state != "done":
            note(
                f"damperlab: the study {record.id} is {record.state}. Run the same command again to continue."
            )
            raise typer.Exit(FAILED)
        return store.cube(record.id).load()


def _search(asked: "Specification", budget: int, evaluation: _Evaluation) -> "Found":
    """Follow the search to its end, and say on the way what is known."""
    from damperlab.studies.design.design import designing

    rounds = designing(asked, budget)
    last = ""
    try:
        ask = next(rounds)
        while True:
            if ask.stage != last:
                last = ask.stage
                note(f"{ask.spent:,} of at most {ask.budget:,} points. Next: {ask.stage}.")
            ask = rounds.send([evaluation.cube(study) for study in ask.studies])
    except StopIteration as end:
        found: Found = end.value
        return found


def _print_size(asked: "Specification", budget: int, as_json: bool) -> None:
    free = list(asked.free)
    if as_json:
        print_json({"name": asked.name, "digest": asked.digest, "chosen": free, "budget_points": budget})
    else:
        say(
            f"{asked.name or 'The specification'} is complete. Chosen: {', '.join(free)}. Budget: {budget:,} points."
        )
