"""The cube as Zarr over HTTP, read-only: `xarray.open_zarr(url)` works from another machine.

Zarr takes a missing chunk for fill values, so 404 is said for a block only where that is the truth: the study has
ended without it, and its points have status -1. Of a study that still goes on, such a block is a conflict, lest a
reader take half of it before and half after it is done; who wants what is there reads at a revision, `zarr/@7/…`,
which shows the blocks that were done by then and never any other. A lost or damaged file is an error in any case.
"""

import re
from functools import lru_cache
from hashlib import blake2b
from pathlib import Path
from typing import Annotated

import google_crc32c
from fastapi import APIRouter
from fastapi import Path as InPath
from starlette.requests import Request
from starlette.responses import Response

from service.problems import Problem, documented
from service.state import TheService, TheStudy
from studies.store.chunks import chunk_file, chunk_place, damaged
from studies.store.cube import block_grid
from studies.store.faults import StudyNotFound
from studies.store.record import Record
from studies.store.store import Store
from studies.variables import DIMENSIONS, VARIABLES

CHUNK = "application/octet-stream"

router = APIRouter(prefix="/api/v1/studies/{study_id}", tags=["queries"])

Key = Annotated[
    str,
    InPath(
        description="A key of the Zarr hierarchy, `zarr.json` first; `@<revision>/` before it keeps to one revision.",
        examples=["zarr.json"],
    ),
]


@router.get(
    "/zarr/{key:path}",
    response_class=Response,
    responses={
        200: {"content": {CHUNK: {}, "application/json": {}}},
        206: {"description": "The part that Range asked for", "content": {CHUNK: {}}},
        304: {"description": "The client has it already"},
        416: {"description": "The range lies outside"},
        **documented(404, 409, 410, 503),
    },
    summary="The cube as a Zarr store",
)
@router.head("/zarr/{key:path}", include_in_schema=False)
def read(service: TheService, study: TheStudy, key: Key, request: Request) -> Response:
    """Answer one key of Zarr version 3; every array's metadata is in the first one, so nothing need be listed."""
    revision, key = _revision(key)
    path, marks = service.store.snapshot(study.id, revision)
    place = chunk_place(key, block_grid(study.shape, study.chunk))
    if place is None:
        return _metadata(path, key, request)
    variable, index = place
    if variable not in VARIABLES or not (path / variable).is_dir():
        raise _nothing(key)
    generation = marks.get(index)
    if generation is None:
        if revision is None and not study.ended:
            raise Problem(
                409,
                "block-unfinished",
                f"Block {index} is not computed yet, and the study is {study.state}. Read at a revision to see "
                f"such points as not computed: …/zarr/@{study.revision}/ is the newest.",
                headers={"Cache-Control": "no-store"},
            )
        raise _nothing(key)
    tag = f'"{path.name}-{index}-{generation}"'
    if _has(request, tag):
        return Response(status_code=304, headers=_headers(tag))
    try:
        content = (path / chunk_file(key, generation)).read_bytes()
    except FileNotFoundError:
        raise _lost(service.store, study, path, index, variable) from None
    if _ends_in_checksum(path) and google_crc32c.value(content[:-4]) != int.from_bytes(
        content[-4:], "little"
    ):
        raise damaged(path, index, variable, "its file is not as it was written")
    return _part(request, content, tag)


def _revision(key: str) -> tuple[int | None, str]:
    found = re.fullmatch(r"@([0-9]{1,9})/(.*)", key)
    return (int(found[1]), found[2]) if found else (None, key)


def _metadata(path: Path, key: str, request: Request) -> Response:
    node, _, name = key.rpartition("/")
    known = node == "" or node in DIMENSIONS or node in VARIABLES
    coordinate = key.removesuffix("/c/0") in DIMENSIONS
    if not (coordinate or (known and name == "zarr.json")):
        raise _nothing(key)
    try:
        content = (path / key).read_bytes()
    except FileNotFoundError:
        raise _nothing(key) from None
    tag = f'"{path.name}-{blake2b(content, digest_size=8).hexdigest()}"'
    if _has(request, tag):
        return Response(status_code=304, headers=_headers(tag))
    if coordinate:
        return _part(request, content, tag)
    return Response(content, headers=_headers(tag), media_type="application/json")


def _part(request: Request, content: bytes, tag: str) -> Response:
    headers = {**_headers(tag), "Accept-Ranges": "bytes"}
    wanted = request.headers.get("range")
    if wanted is None or request.headers.get("if-range", tag) != tag:
        return Response(content, headers=headers, media_type=CHUNK)
    found = re.fullmatch(r"bytes=([0-9]{0,15})-([0-9]{0,15})", wanted.strip())
    if found is None or not (found[1] or found[2]):
        # several ranges, or another unit: the whole is a right answer too
        return Response(content, headers=headers, media_type=CHUNK)
    size = len(content)
    if found[1]:
        start, stop = int(found[1]), min(int(found[2] or size), size - 1) + 1
    else:
        start, stop = max(0, size - int(found[2])), size
    if start >= stop:
        return Response(status_code=416, headers={**headers, "Content-Range": f"bytes */{size}"})
    headers["Content-Range"] = f"bytes {start}-{stop - 1}/{size}"
    return Response(content[start:stop], 206, headers, CHUNK)


def _headers(tag: str) -> dict[str, str]:
    # a block may be computed again: caches keep it, and ask
    return {"ETag": tag, "Cache-Control": "no-cache"}


def _has(request: Request, tag: str) -> bool:
    seen = request.headers.get("if-none-match", "")
    return seen.strip() == "*" or tag in [each.strip().removeprefix("W/") for each in seen.split(",")]


def _nothing(key: str) -> Problem:
    return Problem(
        404, "not-found", f"The cube has nothing at {key!r}.", headers={"Cache-Control": "no-store"}
    )


def _lost(store: Store, study: Record, path: Path, index: int, variable: str) -> Exception:
    try:
        if store.snapshot(study.id)[0] == path:
            return damaged(path, index, variable, "its file is lost, or was replaced a moment ago")
    except StudyNotFound as error:
        return error  # deleted while it was read
    return _nothing(variable)


@lru_cache(maxsize=64)
def _ends_in_checksum(path: Path) -> bool:
    # the first cubes were written without
    return b'"crc32c"' in (path / "zarr.json").read_bytes()
