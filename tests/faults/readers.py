"""Readers of a study that is written, overwritten and deleted all the while; each checks every slice that it reads.

A slice is right if each block in it is wholly of one generation, or wholly not computed, and of the generation that
the catalogue names, unless that changed between a moment before and a moment after the reading. What cannot be read is
said to be so, in one of the ways that are documented, and never fills in.
"""

import argparse
import json
import os
import random
import sys
import time
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import google_crc32c
import httpx
import numpy as np
import xarray as xr
from aiohttp import ClientError
from numcodecs.blosc import decompress
from tests.faults.tokens import METRICS, PLAN, STUDY, token

from damperlab.studies.store.cube.description import block_grid
from damperlab.studies.store.cube.opened import open_cube
from damperlab.studies.store.faults import BlockDamaged, StudyNotFound
from damperlab.studies.store.store import Store
from damperlab.studies.variables import DIMENSIONS
from damperlab.studies.variables import VARIABLES as REGISTRY

VARIABLES = (*METRICS, "status")
HONEST = {404: "no study", 409: "unfinished", 410: "gone", 503: "damaged"}
"""Answers that say that something cannot be read just now."""


ANY = -1.0
"""The token of a block of which the status alone was read."""


class Wrong(Exception):
    """A slice that no reader may ever see."""


class Refused(Exception):
    """The data cannot be read just now, and that is what was said."""


def check_block(values: Mapping[str, np.ndarray]) -> float | None:
    """Give the one token that all values of a block hold; None for a block that is not computed."""
    seen: set[float | None] = set()
    done: bool | None = None
    for name, column in values.items():
        if name == "status":
            codes = set(np.unique(column).tolist())
            if codes not in ({0}, {-1}):
                raise Wrong(f"torn: status {sorted(codes)} in one block")
            done = codes == {0}
            continue
        empty = np.isnan(column) | (column == -1)
        seen |= set(map(float, np.unique(column[~empty]))) | ({None} if empty.any() else set())
    if not seen:
        return ANY if done else None
    if len(seen) > 1 or done not in (None, seen != {None}):
        raise Wrong(f"torn or mixed: {seen} and status {done} in one block")
    return seen.pop()


class Reader:
    """What the readers have in common: where they look, and what is right."""

    def __init__(self, data_dir: Path, url: str, study_id: str, seed: int) -> None:
        self.store = Store.open(data_dir)
        self.url = f"{url}/api/v1/studies/{study_id}"
        self.study_id = study_id
        self.random = random.Random(seed)
        self.http = httpx.Client(timeout=60.0)
        self.shape, self.chunk = STUDY.shape, PLAN.chunk
        self.grid = block_grid(self.shape, self.chunk)
        self.opened: tuple[xr.Dataset, Mapping[int, str]] | None = None
        self.tags: dict[str, tuple[str, bytes]] = {}

    def now(self) -> Mapping[int, str]:
        """Give the generation of every block that is done just now."""
        return self.store.snapshot(self.study_id)[1]

    def moment(self) -> tuple[object, ...]:
        """Give what stays the same for as long as nothing becomes of the study."""
        record = self.store.find(self.study_id)
        return record.created, record.revision

    def a_box(self) -> tuple[slice, ...]:
        """Draw a part of the cube that touches several blocks."""
        cuts = (sorted(self.random.sample(range(extent + 1), 2)) for extent in self.shape)
        return tuple(slice(low, high) for low, high in cuts)

    def blocks_in(self, box: tuple[slice, ...]) -> dict[int, tuple[slice, ...]]:
        """Say which blocks a box touches, and where within the box each lies."""
        found = {}
        for index in range(int(np.prod(self.grid))):
            place = np.unravel_index(index, self.grid)
            inside = []
            for part, at, step in zip(box, place, self.chunk, strict=True):
                low, high = max(part.start, at * step), min(part.stop, (at + 1) * step)
                inside.append(slice(low - part.start, high - part.start))
            if all(part.start < part.stop for part in inside):
                found[index] = tuple(inside)
        return found

    def check(
        self,
        read: Callable[[tuple[slice, ...]], dict[str, np.ndarray]],
        fills: bool = True,
        before: Mapping[int, str] | None = None,
    ) -> None:
        """Read a box and look at every block in it.

        What was opened earlier must show what it was promised `before`, and nothing newer. Blocks that are not done may read as
        not computed where it `fills`.
        """
        box = self.a_box()
        began = self.moment() if before is None else ()
        earlier = self.now() if before is None else before
        values = read(box)
        later = self.now() if before is None else before
        still = before is not None or self.moment() == began
        for index, inside in self.blocks_in(box).items():
            seen = check_block({name: column[inside] for name, column in values.items()})
            if seen is None and not fills:
                raise Wrong(f"block {index} reads as not computed")
            one, other = earlier.get(index), later.get(index)
            # a block that is missing before and after may have been done in between, but not in the same generation
            if one == other and (one is not None or still):
                expected = None if one is None else token(one)
                if seen != expected and (expected is None or seen != ANY):
                    raise Wrong(f"stale: block {index} shows {seen}, its mark says {expected}")


class FromStore(Reader):
    """Opens the cube anew for each slice."""

    def read(self) -> None:
        """Read one slice of some variables."""
        names = self.random.sample(VARIABLES, self.random.randint(1, len(VARIABLES)))

        def load(box: tuple[slice, ...]) -> dict[str, np.ndarray]:
            cube = self.store.cube(self.study_id).isel(dict(zip(DIMENSIONS, box, strict=True)))
            return {name: cube[name].values for name in names}

        self.check(load)


class KeptOpen(Reader):
    """Opens the cube now and then, and reads it for as long as its files are there."""

    def read(self) -> None:
        """Read one slice of a cube that may have been replaced since it was opened."""
        if self.opened is None or self.random.random() < 0.05:
            shelf, marks = self.store.snapshot(self.study_id)
            self.opened = open_cube(shelf, marks), dict(marks)
        cube, marks = self.opened

        def load(box: tuple[slice, ...]) -> dict[str, np.ndarray]:
            part = cube.isel(dict(zip(DIMENSIONS, box, strict=True)))
            return {name: part[name].values for name in VARIABLES}

        try:
            self.check(load, before=marks)
        except BlockDamaged:
            self.opened = None
            raise


class ByXarray(Reader):
    """Opens the cube over HTTP as a Zarr store and reads slices of it, also after the study was deleted."""

    def read(self) -> None:
        """Read one slice, at a revision or as it comes."""
        if self.opened is None or self.random.random() < 0.1:
            self.opened = None
            pinned = self.random.random() < 0.5
            record = self.store.find(self.study_id)
            address = f"{self.url}/zarr" + (f"/@{record.revision}" if pinned else "")
            self.opened = xr.open_zarr(address, chunks=None), {-1: "pinned" if pinned else ""}
        cube, how = self.opened
        pinned = bool(how[-1])
        # blocks that come one by one, as they are, agree within a variable; at a revision across all
        names = VARIABLES if pinned else [self.random.choice(VARIABLES)]

        def load(box: tuple[slice, ...]) -> dict[str, np.ndarray]:
            part = cube.isel(dict(zip(DIMENSIONS, box, strict=True)))
            return {name: part[name].values for name in names}

        try:
            if pinned:
                box = self.a_box()
                values = load(box)
                for inside in self.blocks_in(box).values():
                    check_block({name: column[inside] for name, column in values.items()})
            else:
                self.check(load, fills=False)
        except Wrong:
            raise
        except Exception:
            self.opened = None
            raise


class ByTags(Reader):
    """Keeps what it was sent, and asks with its tag whether that still holds; takes pieces by range too."""

    def read(self) -> None:
        """Read one chunk."""
        name = self.random.choice(METRICS)
        index = self.random.randrange(int(np.prod(self.grid)))
        place = np.unravel_index(index, self.grid)
        url = f"{self.url}/zarr/{name}/c.{'.'.join(map(str, place))}"
        earlier = self.now().get(index)
        tag, content = self._by_ranges(url) if self.random.random() < 0.3 else self._by_tag(url)
        later = self.now().get(index)
        if google_crc32c.value(content[:-4]) != int.from_bytes(content[-4:], "little"):
            raise Wrong("torn: the bytes do not agree with their checksum")
        values = np.frombuffer(decompress(content[:-4]), REGISTRY[name].dtype).reshape(self.chunk)
        # blocks at an edge are smaller than the chunks in which they lie
        seen = check_block({name: values[tuple(slice(0, n) for n in PLAN.block(index).shape)]})
        generation = tag.strip('"').partition(f".zarr-{index}-")[2]
        if seen != token(generation):
            raise Wrong(f"mixed: the tag says {generation}, the values say {seen}")
        if earlier is not None and earlier == later != generation:
            raise Wrong(f"stale: {generation} was sent, the mark says {earlier}")

    def _by_tag(self, url: str) -> tuple[str, bytes]:
        kept = self.tags.get(url)
        answer = self.http.get(url, headers={"If-None-Match": kept[0]} if kept else {})
        if answer.status_code == 304 and kept:
            return kept
        _require(answer, 200)
        self.tags[url] = answer.headers["etag"], answer.content
        return self.tags[url]

    def _by_ranges(self, url: str) -> tuple[str, bytes]:
        first = self.http.get(url, headers={"Range": "bytes=0-15"})
        _require(first, 206)
        tag = first.headers["etag"]
        rest = self.http.get(url, headers={"Range": "bytes=16-", "If-Range": tag})
        if rest.status_code == 200:
            return rest.headers["etag"], rest.content
        _require(rest, 206)
        return tag, first.content + rest.content


class ByQuestions(Reader):
    """Asks for maps, which the service makes."""

    def read(self) -> None:
        """Read one map."""
        name = self.random.choice(METRICS)

        def load(box: tuple[slice, ...]) -> dict[str, np.ndarray]:
            params = {"x": "frequency_ratio", "y": "friction_ratio", "metric": name}
            answer = self.http.get(f"{self.url}/resonance-map", params=params)
            _require(answer, 200)
            values = np.array(answer.json()["values"], float)
            return {name: values.reshape(self.shape)[box]}

        self.check(load)


READERS: dict[str, type[Reader]] = {
    "store": FromStore,
    "kept-open": KeptOpen,
    "xarray": ByXarray,
    "tags": ByTags,
    "questions": ByQuestions,
}


def _require(answer: httpx.Response, status: int) -> None:
    if answer.status_code in HONEST:
        raise Refused(HONEST[answer.status_code])
    if answer.status_code != status:
        raise Wrong(f"status {answer.status_code}: {answer.text[:200]}")


def _honest(error: BaseException) -> str | None:
    """Say what kind of refusal an error is; None for an error that nobody should meet."""
    match error:
        case Refused():
            return str(error)
        case StudyNotFound():
            return "no study"
        case BlockDamaged():
            return "damaged"
    # zarr and xarray pass on what the client under them raised, some of it as a cause
    seen: BaseException | None = error
    while seen is not None:
        status = getattr(seen, "status", None)
        if isinstance(seen, ClientError) and status in HONEST:
            return HONEST[status]
        if isinstance(seen, FileNotFoundError):
            return "no study"  # of the cube's description, before anything was read
        seen = seen.__cause__ or seen.__context__
    return None


def read_on(reader: Reader, reads: int, stop: Path) -> dict[str, Any]:
    """Read until so many slices were seen, or somebody says that it is enough."""
    done, refused, wrong = 0, Counter[str](), []
    while done < reads and not stop.exists():
        try:
            reader.read()
            done += 1
        except Wrong as error:
            wrong.append(str(error))
        except Exception as error:
            reason = _honest(error)
            if reason is None:
                wrong.append(f"{type(error).__name__}: {error}")
            else:
                refused[reason] += 1
                time.sleep(0.02)
    return {"reads": done, "refused": dict(refused), "wrong": wrong}


def main() -> None:
    """Run one reader; print what it saw as JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("kind", choices=READERS)
    parser.add_argument("data_dir", type=Path)
    parser.add_argument("url")
    parser.add_argument("study_id")
    parser.add_argument("--reads", type=int, required=True)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--stop", type=Path, required=True)
    arguments = parser.parse_args()
    reader = READERS[arguments.kind](arguments.data_dir, arguments.url, arguments.study_id, arguments.seed)
    print(json.dumps(read_on(reader, arguments.reads, arguments.stop)), flush=True)
    # xarray keeps sessions of aiohttp open for as long as the process lives
    os._exit(0)


if __name__ == "__main__":
    sys.exit(main())
