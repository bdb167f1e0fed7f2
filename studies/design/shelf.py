"""The store of designs. Specification, progress and result of a design are small files in a folder.

Each file is written completely or not at all, and is changed by one process only. `REQUEST` is written once, `ROUND`
by the search, and `END` by the first process that ends the design. So a process that is killed at any moment leaves a
design that can be continued. A new name and a deletion date are stored in additional files.
"""

import json
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

from damperlab.studies.design.kept import Kept, Round, now
from damperlab.studies.faults import StudyFaults, describe, printable
from damperlab.studies.specification.reading import parse_specification
from damperlab.studies.specification.specification import Specification
from damperlab.studies.store.catalogue.rows import FIRST_DIGITS
from damperlab.studies.store.faults import StoreFault, lost_files
from damperlab.studies.store.files.folder import Folder
from damperlab.studies.store.files.sealed import PLACEHOLDER, require_seal, seal
from damperlab.studies.store.kept_quota import USUAL, KeptQuota
from damperlab.studies.store.provenance import SUBMITTED_BY, signed
from damperlab.studies.store.record import TRASH_DAYS, utc
from damperlab.studies.vocabulary import State

DESIGNS = "designs"
"""The folder of the designs, in the data directory."""
ID_DIGITS = 12
REQUEST, ROUND, ANSWER, REPORT, END = "request.json", "round.json", "answer.json", "report.html", "end.json"
NAME, TRASH = "name.json", "trash.json"
WHERE = "`damperlab designs list` or GET /api/v1/designs lists them"

_putting = threading.Lock()
"""Lock held while designs are counted and a design is added, so that simultaneous requests cannot exceed the limit."""


class Shelf:
    """The designs of one data directory.

    Parameters
    ----------
    data_dir : Path
        The data directory; its folder `designs` is created with the first design.
    quota : KeptQuota
        Largest number of designs kept.
    """

    def __init__(self, data_dir: Path, quota: KeptQuota = USUAL) -> None:
        self._folder = Folder(Path(data_dir) / DESIGNS)
        self._quota = quota

    def put(self, asked: Specification, budget: int) -> tuple[Kept, bool]:
        """Store the design of a specification. An existing design is returned, and restored if it is in the trash.

        Returns
        -------
        kept : Kept
            The new or existing design.
        new : bool
            False if the design existed already.

        Raises
        ------
        DesignsFull
            If the number of designs, in total or of this owner, is at its limit.
        """
        design_id = asked.digest[:ID_DIGITS]
        with _putting:
            ids = self.ids()
            if design_id in ids:
                return self.get(design_id), False
            if design_id in self._in_trash():
                return self.undelete(design_id), False
            others = ids | self._in_trash()
            self._quota.require("design", [self._owner(each) for each in others], DesignsFull)
            # remove files of an interrupted deletion, or of a design whose time in the trash has ended
            self.remove(design_id)
            request = {"specification": asked.document, "budget_points": budget, "created": now()}
            self._folder.at(design_id).fill({REQUEST: _sealed(signed(request))})
            return self.get(design_id), True

    def ids(self) -> set[str]:
        """Return the ids of all designs that are not in the trash."""
        return {name for name in self._requested() if not self._has(name, TRASH)}

    def _requested(self) -> set[str]:
        return {name for name in self._folder.shelves() if self._has(name, REQUEST)}

    def _in_trash(self) -> set[str]:
        """Return the ids of the designs that can be restored."""
        return {name for name in self._requested() if (self._trashed_until(name) or 0.0) > time.time()}

    def _trashed_until(self, design_id: str) -> float | None:
        """Return the time until which a deleted design can be restored, in seconds since 1970.

        None if the design is not deleted.
        """
        try:
            put_away_ns, _ = self._folder.at(design_id).stamp(TRASH)
        except FileNotFoundError:
            return None
        return 1e-9 * put_away_ns + 86_400.0 * TRASH_DAYS

    def find(self, reference: str) -> Kept:
        """Find a design by its id, its name, or the first digits of its id, in this order.

        Raises
        ------
        DesignNotFound
            If no design matches, or several designs match.
        """
        found = self._matching(reference, trash=False)
        if len(found) == 1:
            return self.get(found.pop())
        if reference in self._in_trash():
            return self.get(reference)  # raises an error that mentions the trash
        raise DesignNotFound("design", _matched(reference, found), "the id of one design", WHERE)

    def _matching(self, reference: str, trash: bool) -> set[str]:
        """Return the ids of the designs that match `reference`: as an id, else as a name, else as the first digits of
        an id.
        """
        ids = self._in_trash() if trash else self.ids()
        if reference in ids:
            return {reference}
        found = {each.id for each in self.every(trash) if reference and each.name == reference}
        if not found and len(reference) >= FIRST_DIGITS:
            found = {each for each in ids if each.startswith(reference)}
        return found

    def get(self, design_id: str) -> Kept:
        """Return the design with the complete id `design_id`.

        Raises
        ------
        DesignNotFound
            If there is no such design, or if it is in the trash; `DesignDamaged` if its files are damaged.
        """
        until = self._trashed_until(design_id)
        if until is None:
            return self._kept(design_id)
        if until <= time.time():
            raise _unknown(design_id)
        when = f"in the trash until {utc(until):%Y-%m-%d %H:%M:%S} UTC"
        advice = f"restore it with `damperlab designs undelete {design_id}`"
        told = f"Design {design_id} is {when}."
        raise DesignNotFound("design", f"{design_id}, {when}", "a design that is not deleted", advice, told)

    def _kept(self, design_id: str) -> Kept:
        try:
            request = self._read(design_id, REQUEST)
        except FileNotFoundError:
            raise _unknown(design_id) from None
        try:
            end: Mapping[str, Any] = self._read(design_id, END)
        except FileNotFoundError:
            end = {}
        at = self._round(design_id)
        state: State = end.get("state") or ("queued" if at is None else "running")
        try:
            asked = parse_specification(request["specification"])
            digest, name = asked.digest, asked.name
        except StudyFaults:
            # a version with other keys stored the specification: keep the design, because its search then
            # reports the fault
            digest, name = design_id, str(request["specification"].get("name", ""))
        return Kept(
            id=design_id,
            name=self._renamed(design_id, name),
            digest=digest,
            state=state,
            specification=request["specification"],
            budget_points=int(request["budget_points"]),
            created=request["created"],
            finished=end.get("finished"),
            message=end.get("message") if end or at is None else at.message,
            owner=request.get(SUBMITTED_BY),
            round=at,
        )

    def every(self, trash: bool = False) -> list[Kept]:
        """Return all designs with intact files, the newest first.

        With `trash`, return the deleted designs that can be restored.
        """
        found = []
        for design_id in self._in_trash() if trash else self.ids():
            try:
                found.append(self._kept(design_id))
            except DesignNotFound:
                continue  # the design was deleted meanwhile, or is damaged, which `damaged` reports
        return sorted(found, key=lambda each: each.place, reverse=True)

    def waiting(self) -> list[Kept]:
        """Return the designs that have not ended, the oldest first."""
        found = []
        for design_id in self.ids():
            if not self.ended(design_id):
                try:
                    found.append(self.get(design_id))
                except DesignNotFound:
                    continue
        return sorted(found, key=lambda each: each.place)

    def ended(self, design_id: str) -> bool:
        """Whether a design has ended, or no longer exists."""
        return self._has(design_id, END) or not self._has(design_id, REQUEST)

    def damaged(self, pause: Callable[[], None] = lambda: None) -> Iterator[tuple[str, str]]:
        """Read every design, and yield the id of each damaged design with the reason as a sentence.

        Parameters
        ----------
        pause : callable
            Function that is called before each design is read.
        """
        for design_id in sorted(self.ids()):
            pause()
            try:
                if self.get(design_id).state == "done":
                    self.answer(design_id)
            except DesignDamaged as error:
                yield design_id, str(error)
            except DesignNotFound:
                continue  # deleted meanwhile

    def follow(self, design_id: str, at: Round) -> None:
        """Store the current round of a search."""
        self._folder.at(design_id).put(ROUND, _sealed(asdict(at)))

    def finish(self, design_id: str, answer: Mapping[str, Any], report: str) -> bool:
        """Store an answer and its report, and end the design. Return False if the design had already ended."""
        folder = self._folder.at(design_id)
        folder.put(REPORT, report.encode())
        folder.put(ANSWER, _sealed({"answer": answer}))
        return self.end(design_id, "done")

    def end(self, design_id: str, state: State, message: str | None = None) -> bool:
        """End a design. Return False if the design had already ended."""
        if self._has(design_id, END):
            return False
        end = {"state": state, "message": message, "finished": now()}
        return self._folder.at(design_id).put_new(END, _sealed(end))

    def resume(self, design_id: str) -> None:
        """Continue a design that was cancelled or has failed."""
        self._folder.at(design_id).remove(END)

    def answer(self, design_id: str) -> Any:
        """Return the answer of a completed design.

        Raises
        ------
        DesignDamaged
            If the answer is damaged or lost.
        """
        try:
            return self._read(design_id, ANSWER)["answer"]
        except FileNotFoundError:
            raise damaged(design_id, f"{ANSWER} is lost") from None

    def report(self, design_id: str) -> bytes:
        """Return the report of a completed design as a page of HTML.

        Raises
        ------
        DesignDamaged
            If the report is lost.
        """
        try:
            return self._folder.at(design_id).get(REPORT)
        except FileNotFoundError:
            raise damaged(design_id, f"{REPORT} is lost") from None

    def rename(self, design_id: str, name: str) -> None:
        """Rename a design; its specification stays unchanged."""
        self._folder.at(design_id).put(NAME, _sealed({"name": name}))

    def delete(self, kept: Kept, trash: bool = False) -> None:
        """Remove a design that has ended, with its answer; its studies stay.

        Parameters
        ----------
        kept : Kept
            The design.
        trash : bool
            Whether the design stays in the trash for `TRASH_DAYS`, from which `undelete` can restore it.

        Raises
        ------
        DesignBusy
            If the design has not ended.
        """
        if not kept.ended:
            found = f"{kept.id}, which is {kept.state}"
            told = f"Design {kept.id} is {kept.state}, so it is not possible to delete it now."
            raise DesignBusy("design", found, "a design that has ended", "cancel it first", told)
        if trash:
            self._folder.at(kept.id).put(TRASH, b"")  # the age of this file is the time in the trash
        else:
            self.remove(kept.id)

    def trashed(self, reference: str) -> Kept:
        """Find a deleted design that can be restored, in the same way as `find`."""
        found = self._matching(reference, trash=True)
        if len(found) == 1:
            return self._kept(found.pop())
        advice = "`damperlab designs list --trash` lists them"
        told = "" if found else f"Design {printable(reference)} is not in the trash."
        allowed = "the id of one design in the trash"
        raise DesignNotFound("design", _matched(reference, found), allowed, advice, told)

    def undelete(self, reference: str) -> Kept:
        """Restore a design from the trash. The design is found in the same way as by `find`.

        Raises
        ------
        DesignNotFound
            If no design in the trash matches, or several match.
        """
        kept = self.trashed(reference)
        self._folder.at(kept.id).remove(TRASH)
        return kept

    def bury(self) -> None:
        """Remove the designs whose time in the trash has ended."""
        with _putting:  # a design that is submitted again meanwhile is kept
            for design_id in self._requested():
                until = self._trashed_until(design_id)
                if until is not None and until <= time.time():
                    self.remove(design_id)

    def remove(self, design_id: str) -> None:
        """Remove a design; its studies stay."""
        folder = self._folder.at(design_id)
        # `REQUEST` is removed first, because a design exists as long as its request does
        folder.remove(REQUEST)
        folder.clear()

    def pieces(self, design_id: str) -> dict[str, bytes]:
        """Return the content of each file of a design.

        If the design ends while its files are read, either `END` is missing, or every file is from after the end.
        """
        folder, found = self._folder.at(design_id), {}
        # `END` is read first, because it is written last
        for name in (END, ANSWER, REPORT, ROUND, NAME, TRASH, REQUEST):
            with suppress(FileNotFoundError):
                found[name] = folder.get(name)
        return found

    def take_over(self, design_id: str, pieces: Mapping[str, bytes]) -> int:
        """Store a design from its files, in place of any stored version, and return the number of bytes written."""
        if self.pieces(design_id) == pieces:
            return 0
        self.remove(design_id)
        folder = self._folder.at(design_id)
        # `REQUEST` is written last, because a design exists as soon as its request does
        for some in ({name: pieces[name] for name in pieces if name != REQUEST}, {REQUEST: pieces[REQUEST]}):
            if some:
                folder.fill(some)
        return sum(map(len, pieces.values()))

    def _owner(self, design_id: str) -> str | None:
        with suppress(FileNotFoundError, DesignDamaged):
            owner: str | None = self._read(design_id, REQUEST).get(SUBMITTED_BY)
            return owner
        return None

    def _renamed(self, design_id: str, name: str) -> str:
        """Return the new name of a design if it was renamed, else the name in its request."""
        try:
            return str(self._read(design_id, NAME)["name"])
        except FileNotFoundError:
            return name

    def _round(self, design_id: str) -> Round | None:
        try:
            found = self._read(design_id, ROUND)
        except FileNotFoundError:
            return None
        return Round(**{**found, "studies": tuple(found["studies"])})

    def _has(self, design_id: str, name: str) -> bool:
        return Path(self._folder.address, design_id, name).is_file()

    def _read(self, design_id: str, name: str) -> dict[str, Any]:
        content = self._folder.at(design_id).get(name)
        try:
            require_seal(content)
            found: dict[str, Any] = json.loads(content)
        except ValueError as error:
            raise damaged(design_id, f"{name}: {error}") from error
        del found["crc32c"]
        return found


def _sealed(document: Mapping[str, Any]) -> bytes:
    return seal(json.dumps({"crc32c": PLACEHOLDER, **document}, allow_nan=False).encode())


class DesignNotFound(StoreFault):
    """No design, or several designs, have the given name or id."""


class DesignDamaged(DesignNotFound):
    """The files of a design are damaged."""


class DesignBusy(StoreFault):
    """The request is possible only after the design has ended."""


class DesignsFull(StoreFault):
    """No more designs can be stored."""


def _matched(reference: str, found: set[str]) -> str:
    return f"{describe(reference)}, which matches {len(found)} designs" if found else describe(reference)


def _unknown(design_id: str) -> DesignNotFound:
    return DesignNotFound("design", describe(design_id), "the whole id of a design", WHERE)


def damaged(design_id: str, why: str) -> DesignDamaged:
    """Return an error which says that the files of a design are damaged, and why."""
    advice = "delete it and submit its specification again: its studies are in the store, so nothing is computed twice"
    return lost_files(DesignDamaged, "design", design_id, why, advice)
