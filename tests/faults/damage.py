"""Bits flipped over all files of a store, the tail of its log cut, each file lost: found, harmless or refused, never silent.

Each case is a fresh copy of one store, in which one thing is damaged. It is then opened, every study is listed, read
whole and verified, and its garbage is collected, of which there is none. The outcome is one of

    refused    something raised a fault in words, as the store's users get it
    found      all was read, and `verify` told of damage
    harmless   every answer is what it was, to the last bit
    silent     an answer differs, and nobody said so: a defect
    crashed    an exception that is no fault: a defect
    removed    the collection of garbage took a file: a defect
"""

import argparse
import shutil
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from contextlib import closing, suppress
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
from tests.filling import make_plan_of, make_study, values_of, write

from damperlab.studies.store.care.sweep import collect_garbage
from damperlab.studies.store.care.verify import check_catalogue, verify
from damperlab.studies.store.catalogue.catalogue import SQLITE_FILE
from damperlab.studies.store.cube.coding import checksum
from damperlab.studies.store.cube.opened import KEPT
from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.store import Store

GOOD = ("refused", "found", "harmless")


@dataclass
class Report:
    """What became of the cases."""

    outcomes: Counter[tuple[str, str]] = field(default_factory=Counter)
    defects: list[str] = field(default_factory=list)

    def add(self, file: Path, what: str, came: tuple[str, str]) -> None:
        """Count what came of one case, and tell a defect at once."""
        outcome, words = came
        self.outcomes[kind_of(file), outcome] += 1
        if outcome not in GOOD:
            self.defects.append(f"{file.parent.name}/{file.name} {what}: {outcome}: {words}")
            print(self.defects[-1], flush=True)

    def table(self) -> str:
        """Give the counts, one line each."""
        lines = (f"{kind:12} {outcome:9} {count}" for (kind, outcome), count in sorted(self.outcomes.items()))
        return "\n".join(lines)


def make_store(folder: Path) -> None:
    """Make a store of three studies: done, cancelled half-way, and queued."""
    fill_store(folder).close()


def fill_store(folder: Path) -> Store:
    """Make that store, and leave it open: what was committed last is in its write-ahead log alone."""
    store = Store.open(folder)
    random = np.random.default_rng(3)
    for name, zeta, blocks, state in (
        ("done", 0.01, 12, "done"),
        ("half", 0.02, 5, "cancelled"),
        ("new", 0.03, 0, None),
    ):
        study = make_study(name, damping_ratio=zeta, metrics=["amplitude_ratio", "period", "response_class"])
        plan = make_plan_of(study)
        record, _ = store.submit(study, plan, {"kernels": "k", "solver_version": "1"})
        for block in map(plan.block, range(blocks)):
            values = {
                name: column if name == "status" else (random.random(block.shape) * 4).astype(column.dtype)
                for name, column in values_of(study, block).items()
            }
            write(store, record.id, block, values, "g", {"seconds": 0.5, "kernel_seconds": 0.4})
        if state is not None:
            store.set_state(record.id, state)
    return store


def answers(folder: Path) -> tuple[dict[str, Any], list[str]]:
    """Ask a store for everything: its answers, and what `verify` says of them."""
    KEPT.clear()
    store = Store.open(folder)
    try:
        found: dict[str, Any] = {}
        told = list(check_catalogue(store))
        for record in store.page(limit=100).records:
            document = record.document()
            found[record.id] = repr(sorted(document.items())), repr(store.events(record.id))
            cube = store.cube(record.id).load()
            values = {str(name): array.values for name, array in cube.data_vars.items()}
            axes = {str(name): array.values for name, array in cube.coords.items()}
            attributes = repr((cube.attrs, [(name, cube[name].attrs) for name in cube.variables]))
            found[f"{record.id} cube"] = checksum(values), checksum(axes), attributes
            by_name = store.find(record.name)
            found[f"{record.name} by name"] = by_name.id
            told += [damage.found for damage in verify(store, record)]
        return found, told
    finally:
        store.close()


def judge(folder: Path, expected: dict[str, Any]) -> tuple[str, str]:
    """Say what comes of a damaged store: the outcome, and in words."""
    outcome = _asked(folder, expected)
    before = {path for path in (folder / "cubes").rglob("*") if path.is_file()}
    with suppress(StoreFault), closing(Store.open(folder)) as store:
        collect_garbage(store, -1.0)
    gone = sorted(path.relative_to(folder).as_posix() for path in before if not path.exists())
    return ("removed", f"{gone} after it was {outcome}") if gone else outcome


def _asked(folder: Path, expected: dict[str, Any]) -> tuple[str, str]:
    try:
        found, told = answers(folder)
    except StoreFault as error:
        return "refused", str(error)
    except Exception as error:
        return "crashed", f"{type(error).__name__}: {error}"
    if told:
        return "found", told[0]
    if found == expected:
        return "harmless", ""
    differ = [key for key in expected if found.get(key) != expected[key]]
    return "silent", f"{differ or 'more studies'} differ"


def kind_of(file: Path) -> str:
    """Name the kind of a file of a store."""
    if file.name.startswith("catalogue.sqlite"):
        return "catalogue"
    if file.parent.name == "blocks":
        return "block"
    return {"zarr.json": "description", "marks.json": "marks", "damperlab.json": "owner"}.get(
        file.name, "axis"
    )


def flips(store: Path, number: int, seed: int) -> Iterator[tuple[Path, int, int]]:
    """Draw files, each kind as often as every other, and a bit of each: file, byte, bit."""
    random = np.random.default_rng(seed)
    by_kind: dict[str, list[Path]] = {}
    for file in files_of(store):
        by_kind.setdefault(kind_of(file), []).append(file)
    kinds = sorted(by_kind)
    for place in range(number):
        files = by_kind[kinds[place % len(kinds)]]
        file = files[int(random.integers(len(files)))]
        # a database is mostly zeros that nothing reads: half of its bits are drawn where something is written
        content = np.frombuffer(file.read_bytes(), np.uint8)
        where = np.flatnonzero(content) if place // len(kinds) % 2 else np.arange(content.size)
        yield file, int(random.choice(where)), int(random.integers(8))


def files_of(store: Path) -> list[Path]:
    """List the files of a store."""
    return sorted(path for path in store.rglob("*") if path.is_file())


def cases(whole: Path, case: Path, number: int, seed: int) -> Iterator[tuple[Path, str]]:
    """Damage a copy of a store, one thing at a time: bits flipped, then every file lost; which file, and what became of it."""
    for file, at, bit in flips(whole, number, seed):
        damaged = bytearray(file.read_bytes())
        damaged[at] ^= 1 << bit
        _copy(whole, case)
        (case / file.relative_to(whole)).write_bytes(bytes(damaged))
        yield file, f"byte {at} bit {bit}"
    for file in files_of(whole):
        _copy(whole, case)
        (case / file.relative_to(whole)).unlink()
        yield file, "lost"


def cut_cases(whole: Path, case: Path, number: int, seed: int) -> Iterator[tuple[Path, str]]:
    """Cut the tail of the catalogue's log off, or let it read as zeros, at drawn places."""
    log = whole / f"{SQLITE_FILE}-wal"
    content = log.read_bytes()
    for at in np.random.default_rng(seed).integers(len(content), size=number):
        for rest, what in ((b"", "cut at"), (bytes(len(content) - at), "zeros from")):
            _copy(whole, case)
            (case / log.name).write_bytes(content[:at] + rest)
            yield log, f"{what} byte {at}"


def _copy(whole: Path, case: Path) -> None:
    shutil.rmtree(case, ignore_errors=True)
    shutil.copytree(whole, case)


def run_damage(number: int, seed: int) -> Report:
    """Flip bits one at a time, lose every file one at a time, and cut the log."""
    report = Report()
    with tempfile.TemporaryDirectory() as made:
        whole, case = Path(made, "whole"), Path(made, "case")
        with closing(fill_store(Path(made, "open"))):
            # as a machine leaves it that loses its power
            shutil.copytree(Path(made, "open"), whole)
        shutil.copytree(whole, case)
        expected, told = answers(case)
        assert not told, told
        drawn = cases(whole, case, number, seed), cut_cases(whole, case, number // 10, seed)
        for file, what in chain(*drawn):
            report.add(file, what, judge(case, expected))
    return report


def main() -> None:
    """Run the campaign and print what came of it; status 1 where anything was silent."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--flips", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    report = run_damage(options.flips, options.seed)
    print(report.table())
    sys.exit(bool(report.defects))


if __name__ == "__main__":
    main()
