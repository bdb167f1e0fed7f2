"""The cube as a read-only Zarr store over HTTP, which `xarray.open_zarr(url)` opens from another machine.

Zarr reads a missing chunk as fill values, which means status -1. So the answer 404 for a missing block is sent only if
the study has ended. While a study runs, the answer is 409 (conflict), because the block may be computed while a reader
fetches its chunks. An address with a revision, `zarr/@7/…`, shows only the blocks that were done at this revision, and
can be read while the study runs. A lost or damaged file is always an error.
"""

import re
from functools import lru_cache
from hashlib import blake2b
from typing import Annotated

from fastapi import Path as InPath
from starlette.requests import Request
from starlette.responses import Response

from damperlab.service.edge.conditional import has_seen, part_asked
from damperlab.service.problems import Problem, documented
from damperlab.service.routes.strict import strict_router
from damperlab.service.state import StudyId, TheService
from damperlab.studies.store.cube.block_file import Marks, read_part
from damperlab.studies.store.cube.coding import StoredCoordinate, checksum_holds
from damperlab.studies.store.cube.description import (
    DESCRIPTION,
    Description,
    block_grid,
    describe_cube,
    node_metadata,
    plain_metadata,
)
from damperlab.studies.store.cubes import TRIES
from damperlab.studies.store.export.grouped import Group, chunk_place, group_of, grouped_metadata
from damperlab.studies.store.faults import BlockDamaged, StudyNotFound, reporting_damage
from damperlab.studies.store.files.shelf import Shelf
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store

CHUNK = "application/octet-stream"
_ID = re.compile("[0-9a-f]{12}(-[0-9]{1,9})?")

router = strict_router("/api/v1/studies/{study_id}", "queries")

Key = Annotated[
    str,
    InPath(
        description="A key of the Zarr hierarchy, `zarr.json` first. Write `@<revision>/` before the key "
        "to read one revision of the cube.",
        examples=["zarr.json"],
    ),
]


@router.get(
    "/zarr/{key:path}",
    response_class=Response,
    responses={
        200: {"content": {CHUNK: {}, "application/json": {}}},
        206: {"description": "The part that Range asked for", "content": {CHUNK: {}}},
        304: {"description": "The client has this content already"},
        416: {"description": "The range lies outside the content"},
        **documented(404, 409, 410, 503),
    },
    summary="The cube as a Zarr store",
)
def read(service: TheService, study_id: StudyId, key: Key, request: Request) -> Response:
    """Send the content of one key of Zarr version 3. The key `zarr.json` holds the metadata of every array."""
    revision, key = _revision(key)
    try:
        return _read(service.store, service.store.find(study_id), revision, key, request)
    except StudyNotFound as error:
        if key.endswith("zarr.json") or (_ID.fullmatch(study_id) and not service.store.existed(study_id)):
            raise
        # The reader opened the cube before the study was deleted, and would read the answer 404 as fill values.
        raise Problem(
            410,
            "study-gone",
            "The study no longer exists.",
            (error.fault,),
            {"Cache-Control": "no-store"},
        ) from error


def _read(store: Store, study: Record, revision: int | None, key: str, request: Request) -> Response:
    for _ in range(TRIES):
        shelf, marks = store.snapshot(study.id, revision)
        try:
            answer = _answer(shelf, marks, study, key, request)
        except BlockDamaged:
            # files may have been replaced since the done-marks were read
            if store.snapshot(study.id, revision) == (shelf, marks):
                raise
            continue
        if answer is not None:
            return answer
        if revision is not None:
            raise _nothing(key)
        # The study may have ended or been resumed since its record was read. Then the block is looked up again.
        before, study = study, store.find(study.id)
        if (before.revision, before.created) != (study.revision, study.created):
            continue
        if study.ended:
            raise _nothing(key)
        break
    raise Problem(
        409,
        "block-unfinished",
        f"The block of {key} is not computed yet, and the study is {study.state}. Open the cube at a revision to "
        f"get fill values for such blocks; …/zarr/@{study.revision}/ is the newest.",
        headers={"Cache-Control": "no-store"},
    )


def _answer(shelf: Shelf, marks: Marks, study: Record, key: str, request: Request) -> Response | None:
    """Return the content of a key at one moment of the study. Return None if the key names a block that is not done."""
    place = chunk_place(key, block_grid(study.shape, study.chunk))
    if place is None:
        group = group_of(key, _description(shelf))
        if group is not None:
            return _grouped(shelf, group, marks, request)
        return _metadata(shelf, key, request, complete=len(marks) == study.blocks_total)
    variable, index = place
    if variable not in _description(shelf).arrays:
        raise _nothing(key)
    generation = marks.get(index)
    if generation is None:
        return None
    tag = f'"{shelf.name}-{index}-{generation}"'
    if has_seen(request.headers, tag):
        return Response(status_code=304, headers=_headers(tag))
    return _part(request, _content(shelf, variable, index, generation), tag)


def _content(shelf: Shelf, variable: str, index: int, generation: str) -> bytes:
    with reporting_damage(shelf, index, variable):
        content = read_part(shelf, _description(shelf).digest, index, generation, variable)
        if not checksum_holds(content):
            raise ValueError("its file is not as it was written")
    return content


@lru_cache(maxsize=64)
def _description(shelf: Shelf) -> Description:
    # may be cached: the arrays of a study never change, and the location of its files is never reused
    with reporting_damage(shelf, None, "the cube's description"):
        return describe_cube(shelf.get(DESCRIPTION))


def _revision(key: str) -> tuple[int | None, str]:
    found = re.fullmatch(r"@([0-9]{1,9})/(.*)", key)
    return (int(found[1]), found[2]) if found else (None, key)


def _grouped(shelf: Shelf, group: Group, marks: Marks, request: Request) -> Response:
    if not marks.keys() >= set(group.blocks()):
        # Only a complete cube has chunks of several blocks. So some blocks were invalidated after the cube was opened.
        raise Problem(
            409,
            "block-unfinished",
            "Blocks of this chunk were damaged and are computed again. Open the cube again to read the others.",
            headers={"Cache-Control": "no-store"},
        )
    place = ".".join(map(str, group.place))
    tag = f'"{shelf.name}-{place}-{group.tag(marks)}"'
    if has_seen(request.headers, tag):
        return Response(status_code=304, headers=_headers(tag))
    return _part(request, group.content(shelf, marks), tag)


def _metadata(shelf: Shelf, key: str, request: Request, complete: bool) -> Response:
    described = _description(shelf)
    node, _, name = key.rpartition("/")
    chunk = next((one for one in described.coordinates.values() if one.key == key), None)
    if chunk is not None:
        content = _coordinate(shelf, chunk, key)
    elif name == DESCRIPTION and (node == "" or node in described.arrays or node in described.coordinates):
        with reporting_damage(shelf, None, "the cube's description"):
            content = shelf.get(DESCRIPTION)
        content = plain_metadata(content, complete)
        if node:
            content = node_metadata(content, node)
        if complete:
            content = grouped_metadata(content)
    else:
        raise _nothing(key)
    tag = f'"{shelf.name}-{blake2b(content, digest_size=8).hexdigest()}"'
    if has_seen(request.headers, tag):
        return Response(status_code=304, headers=_headers(tag))
    if chunk is not None:
        return _part(request, content, tag)
    return Response(content, headers=_headers(tag), media_type="application/json")


def _coordinate(shelf: Shelf, one: StoredCoordinate, key: str) -> bytes:
    if one.value is not None:
        raise _nothing(key)  # The metadata holds the value, so a reader needs no chunk.
    # An error is raised if the chunk is missing: Zarr would read the answer 404 as fill values.
    with reporting_damage(shelf, None, f"the coordinates along {one.name}"):
        content = shelf.get(key)
        one.decode(content)
    return content


def _part(request: Request, content: bytes, tag: str) -> Response:
    headers = {**_headers(tag), "Accept-Ranges": "bytes"}
    part = part_asked(request, len(content), tag)
    if part is None:
        return Response(content, headers=headers, media_type=CHUNK)
    start, stop = part
    if start == stop:
        return Response(status_code=416, headers={**headers, "Content-Range": f"bytes */{len(content)}"})
    headers["Content-Range"] = f"bytes {start}-{stop - 1}/{len(content)}"
    return Response(content[start:stop], 206, headers, CHUNK)


def _headers(tag: str) -> dict[str, str]:
    # caches must revalidate, because a block may be computed again
    return {"ETag": tag, "Cache-Control": "no-cache"}


def _nothing(key: str) -> Problem:
    return Problem(
        404, "not-found", f"The cube has nothing at {key!r}.", headers={"Cache-Control": "no-store"}
    )
