"""Computes answers from a study's cube: from a large cube in a separate process, from a small cube in a thread."""

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
"""Size of the pieces in which a long answer is sent."""
EXPORT_POINTS = 1_000_000
"""For n times this number of points, the time limit of an export is n + 1 times the time limit of a request."""

Result = TypeVar("Result")


def is_large(service: Service, study: Record) -> bool:
    """Return whether answers about a study are computed in a separate process."""
    return study.points_total >= service.settings.question_points_apart


async def computed(
    request: Request, service: Service, study: Record, function: Callable[..., Result], *more: object
) -> Result:
    """Call an importable function with the store, the study and further arguments, and return its picklable result."""
    if is_large(service, study):
        return await service.work.run(request, _there, service.settings, study, function, more)
    return await run_sync(steady, service.store, study, function, more)


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
        The request, the service, and the study.
    function : callable
        Function that is called with the store, the study, the path of the file, and further arguments. The function
        may write other files into the same folder.
    *more
        Further arguments of the function.
    export : bool
        Whether the call writes an export. The time limit of an export grows with the number of points. The file of an
        export is written to the data directory, because the temporary folder may be too small.

    Returns
    -------
    result, file
        The function's result, and the open file, which is deleted when it is closed.
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
            found = await run_sync(steady, service.store, study, function, (place, *more))
        return found, await run_sync(_open, place)
    finally:
        # remove all files in the folder, because a killed process may have left files
        with CancelScope(shield=True):
            await run_sync(folder.cleanup)


def pieces(file: BinaryIO, start: int, stop: int) -> Iterator[bytes]:
    """Yield a part of a file in pieces, and close the file at the end."""
    with file:
        file.seek(start)
        while piece := file.read(min(PIECE_BYTES, stop - start)):
            start += len(piece)
            yield piece


@lru_cache(maxsize=1)
def store_of(settings: Settings) -> Store:
    """Open the store that the settings name, once per process."""
    return settings.open_store(wait_seconds=settings.catalogue_wait_seconds)


def _there(
    settings: Settings, study: Record, function: Callable[..., Result], more: tuple[object, ...]
) -> Result:
    """Call a function with the store that this process has opened. The call runs in a process of `Work`."""
    return steady(store_of(settings), study, function, more)


def steady(
    store: Store, study: Record, function: Callable[..., Result], more: tuple[object, ...] = ()
) -> Result:
    """Call a function that reads a study, again if the study changes meanwhile; see `Store.steadily`."""
    return store.steadily([study.id], lambda: function(store, study, *more))


def _folder(where: Path | None) -> "TemporaryDirectory[str]":
    with using(str(where or "the folder of temporary files")):
        return TemporaryDirectory(dir=where, prefix="export-", ignore_cleanup_errors=True)


def _open(place: Path) -> BinaryIO:
    with using(str(place.parent)):
        return place.open("rb")
