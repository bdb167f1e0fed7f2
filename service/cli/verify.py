"""`damperlab store verify` checks stored studies for damage, and repairs damaged studies."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

from damperlab.service.cli.computing import Computer, Means, computes
from damperlab.service.cli.failures import FAILED, CommandFailed
from damperlab.service.cli.options import AsJson, DataDir
from damperlab.service.cli.output import note, print_json, working
from damperlab.service.cli.store import find_study, label, open_store
from damperlab.studies.faults import counted

if TYPE_CHECKING:
    from collections.abc import Iterator

    from damperlab.studies.store.care.verify import Damage
    from damperlab.studies.store.record import Record
    from damperlab.studies.store.store import Store


@computes
def verify(
    study: Annotated[
        str | None,
        typer.Argument(metavar="[ID]", help="Study to verify; every study by default.", show_default=False),
    ] = None,
    data_dir: DataDir = None,
    repair: Annotated[bool, typer.Option("--repair", help="Recompute damaged and lost blocks.")] = False,
    *,
    means: Means,
    as_json: AsJson = False,
) -> None:
    """Compare every stored file with its checksum. The exit status is 1 if anything is damaged."""
    store = open_store(data_dir)
    records = _every(store) if study is None else iter([find_study(store, study)])
    from damperlab.studies.store.care.verify import check_catalogue, unfinished_submissions
    from damperlab.studies.store.faults import StudyNotFound

    with working("Reading the catalogue"):
        catalogue = list(check_catalogue(store)) if study is None else []
        unfinished = unfinished_submissions(store) if study is None else []
    for line in [*catalogue, *unfinished]:
        note(f"damperlab: {line}")
    with Computer(store, means) as computer:
        answers = []
        for record in records:
            try:
                answers.append(_verify(computer, record, repair, study is not None))
            except StudyNotFound:
                if study is not None:
                    raise  # otherwise the study was deleted after the list of studies was read
    if as_json:
        print_json({"studies": answers, "catalogue": catalogue, "unfinished": unfinished})
    elif study is None:
        blocks, damaged = (
            sum(each["blocks"] for each in answers),
            sum(len(each["damaged"]) for each in answers),
        )
        note(f"Studies: {len(answers):,}. Blocks read: {blocks:,}; damaged: {damaged}.")
    if catalogue or any(answer["damaged"] and not answer["repaired"] for answer in answers):
        raise typer.Exit(FAILED)


def _verify(computer: Computer, record: "Record", repair: bool, alone: bool) -> dict[str, Any]:
    """Verify one study. If `alone` is false, the study is mentioned only if it is damaged."""
    from damperlab.studies.store.care.verify import repair as take_back
    from damperlab.studies.store.care.verify import verify as damages_of

    store = computer.store
    with working(f"Reading {label(record)}"):
        damages = list(damages_of(store, record))
    for damage in damages:
        where = damage.part if damage.block is None else f"block {damage.block}"
        note(f"damperlab: {label(record)}: {where}: {damage.found}")
    if damages or alone:
        note(f"{label(record)}: {counted(record.blocks_done, 'block')} read, {len(damages)} damaged.")
    repaired = False
    if damages and repair:
        _require_solver_of_blocks(record, damages)
        record = take_back(store, record, damages)
        if any(damage.block is None for damage in damages):
            # after the repair of the description, further damage may be detected
            hidden = list(damages_of(store, record))
            _require_solver_of_blocks(record, hidden)
            record = take_back(store, record, hidden)
            damages += hidden
        if record.blocks_done < record.blocks_total:
            record = computer.compute(record)
        repaired = record.blocks_done == record.blocks_total
        note(f"{label(record)} is {'repaired' if repaired else record.state}.")
    return {
        "id": record.id,
        "name": record.name,
        "blocks": record.blocks_done,
        "damaged": [{"block": damage.block, "found": damage.found} for damage in damages],
        "repaired": repaired,
    }


def _require_solver_of_blocks(record: "Record", damages: "list[Damage]") -> None:
    """Refuse to repair blocks computed by another version of the solver. Other damage is repaired without a solver.

    Raises
    ------
    CommandFailed
        If another solver computed a damaged block.
    """
    if any(damage.block is not None or damage.part == "catalogue" for damage in damages):
        require_own_solver(record)


def require_own_solver(record: "Record") -> None:
    """Raise `CommandFailed` if another solver computed the blocks of a study."""
    from damperlab.worker.provenance import WrongCode, require_solver

    try:
        require_solver(record.id, record.provenance)
    except WrongCode as error:
        raise CommandFailed("wrong-code", str(error)) from error


def _every(store: "Store") -> "Iterator[Record]":
    cursor = None
    while True:
        page = store.page(limit=200, cursor=cursor)
        yield from page.records
        cursor = page.cursor
        if cursor is None:
            return
