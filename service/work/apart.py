"""Computes answers from a study's cube: for a large cube in a separate process that can be ended, else in a thread."""

from collections.abc import Callable, Iterator
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import BinaryIO, TypeVar

from anyio import CancelScope
from anyio.to_thread import run_sync
from starlette.requests import Request

from damperlab.service.settings import Settings
from damperlab.service.state import Service
from damperlab.studies.store.faults import using
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store

PIECE_BYTES = 1 << 20
"""Size of the pieces of a long answer, which is sent as its client reads it."""
EXPORT_POINTS = 1_000_000
"""An export may take the processor time of one request, plus that of another for every `EXPORT_POINTS` points."""

Result = TypeVar("Result")


def is_large(service: Service, study: Record) -> bool:
    """Whether answers about a study are computed in a separate process."""
    return study.points_total >= service.settings.question_points_apart


async def computed(
    request: Request, service: Service, study: Record, function: Callable[..., Result], *more: object
) -> Result:
    """Call a function with a store, the study, and further arguments. The function can be imported by name; the
    arguments and the result are pickled.
    """
    if is_large(service, study):
        return await service.work.run(request, _there, service.settings, study, function, more)
    return await run_sync(function, service.store, study, *more)


async def written(
    request: Request,
    service: Service,
    study: Record,
    function: Callable[..., Result],
    *more: object,
    export: bool = False,
) -> tuple[Result, BinaryIO]:
    """Let a function write a long answer into a file.

    Parameters
    ----------
    request, service, study : Request, Service, Record
        The caller, and the study.
    function : callable
        Called with a store, the study, the path of the file, and further arguments. Its other files go to the same
        folder.
    *more
        Further arguments.
    export : bool
        Whether the call writes an export. The processor time that it may take grows with its points, and its file may
        be too large for the temporary folder.

    Returns
    -------
    result, file
        The function's result, and the open file. The file has no name any more, and vanishes when it is closed.
    """
    folder = await run_sync(_folder, service.settings.data_dir if export else None)
    try:
        place = Path(folder.name) / "body"
        if is_large(service, study):
            work = service.exports if export else service.work
            shares = 1 + study.points_total // EXPORT_POINTS if export else 1
            arguments = (service.settings, study, function, (place, *more))
            found = await work.run(request, _there, *arguments, shares=shares)
        else:
            found = await run_sync(function, service.store, study, place, *more)
        return found, await run_sync(_open, place)
    finally:
        # the process may have been killed and have left its files
        with CancelScope(shield=True):
            await run_sync(folder.cleanup)


def pieces(file: BinaryIO, start: int, stop: int) -> Iterator[bytes]:
    """Read a part of a file, at its reader's pace."""
    with file:
        file.seek(start)
        while piece := file.read(min(PIECE_BYTES, stop - start)):
            start += len(piece)
            yield piece


@lru_cache(maxsize=1)
def store_of(settings: Settings) -> Store:
    """Open the store of the settings, once per computing process."""
    return settings.open_store(wait_seconds=settings.catalogue_wait_seconds)


def _there(
    settings: Settings, study: Record, function: Callable[..., Result], more: tuple[object, ...]
) -> Result:
    """Call a function in a process of `Work`."""
    return function(store_of(settings), study, *more)


def _folder(where: Path | None) -> "TemporaryDirectory[str]":
    with using(str(where or "the folder of temporary files")):
        return TemporaryDirectory(dir=where, prefix="export-", ignore_cleanup_errors=True)


def _open(place: Path) -> BinaryIO:
    with using(str(place.parent)):
        return place.open("rb")
