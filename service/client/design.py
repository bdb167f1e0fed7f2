"""One design of a service: progress, control, and answer."""

import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from damperlab.service.client.faults import ClientFault, StillRunning, Stopped, refused
from damperlab.service.client.transport import Transport, body
from damperlab.studies.faults import Fault, StudyFaults, describe
from damperlab.studies.html import card
from damperlab.studies.vocabulary import ENDED

if TYPE_CHECKING:
    import xarray as xr

    Specification = Mapping[str, Any] | str | Path

LOOK_SECONDS = 1.0
"""Interval between checks while waiting for a design."""


class Design:
    """A design stored by the service.

    Made by `Client.design` and `Client.designs`.

    Parameters
    ----------
    transport : Transport
        The connection to the service.
    document : mapping
        The service's record of the design, or the available part of it.

    Attributes
    ----------
    id, name : str
        The first twelve digits of the specification's digest; the name of the design.
    """

    def __init__(self, transport: Transport, document: Mapping[str, Any]) -> None:
        self._transport = transport
        self.id = str(document["id"])
        self.name = str(document["name"])

    def __repr__(self) -> str:
        """Name the design."""
        return f"<Design {self.id} {self.name!r}>"

    def _repr_html_(self) -> str:
        """Show the design in a notebook: its sentences, or its progress."""
        try:
            now = self.record
        except ClientFault:
            return card(f"Design {self.name}", [("id", self.id)])
        answer = now["answer"] or {}
        rows: list[tuple[str, object]] = [("id", self.id), ("state", now["state"])]
        # an answer of an older version has no verdict, only sentences
        told = answer["verdict"]["sentences"] if "verdict" in answer else answer.get("words", ())
        rows += [("", sentence) for sentence in told]
        if not answer:
            rows += [("points", _points(now)), ("stage", now["stage"]), ("message", now["message"])]
            rows += [("best so far", best)] if (best := _best(now)) else []
        return card(f"Design {self.name}".strip(), rows)

    def __eq__(self, other: object) -> bool:
        """Designs are equal if they have the same id at the same service."""
        return isinstance(other, Design) and (self.id, self._transport.url) == (
            other.id,
            other._transport.url,
        )

    def __hash__(self) -> int:
        """Hash consistent with equality."""
        return hash((self.id, self._transport.url))

    @property
    def record(self) -> dict[str, Any]:
        """The service's present record: ``state``, ``stage``, ``points``, ``budget_points``, ``known`` (the best so
        far), …
        """
        found: dict[str, Any] = self._ask("GET")
        return found

    @property
    def state(self) -> str:
        """The present state: ``queued``, ``running``, ``done``, ``cancelled`` or ``failed``."""
        return str(self.record["state"])

    @property
    def answer(self) -> dict[str, Any]:
        """The output of `damperlab design --json`: ``design`` in drawing values, ``worst``, ``probability``,
        ``words``, …

        Raises
        ------
        StillRunning
            If the design has not ended.
        Stopped
            If it has failed or was cancelled.
        """
        now = self.record
        if now["state"] not in ENDED:
            raise StillRunning(f"{self} is {now['state']}: {_points(now)}.")
        return self._answer(now)

    @property
    def amplitudes(self) -> "xr.Dataset":
        """The response of the recommended damper over ``amplitude`` and ``frequency_ratio``, from half the smallest
        amplitude to twice the largest: ``value``, ``ratio`` over the base amplitude, ``worst`` and
        ``worst_frequency_ratio``.

        Raises
        ------
        StillRunning
            If the design has not ended.
        Stopped
            If it has failed or was cancelled.
        """
        from damperlab.studies.design.backbone import backbone_dataset

        return backbone_dataset(self.answer.get("amplitudes", []))

    def wait(self, progress: bool = True, timeout: float | None = None) -> "Design":
        """Wait until the design is done.

        Lost connections and restarts of the service do not end the wait.

        Parameters
        ----------
        progress : bool
            Show points, activity and the best damper so far: by a bar in a terminal or a notebook, by occasional
            lines elsewhere.
        timeout : float, optional
            Stop waiting after this many seconds; the design itself continues.

        Returns
        -------
        Design
            This one.

        Raises
        ------
        Stopped
            If it has failed or was cancelled.
        StillRunning
            If it has not ended in time.
        """
        from damperlab.service.client.waiting import shown_design

        until = None if timeout is None else time.monotonic() + timeout
        with ExitStack() as stack:
            bar = None
            for now in self._follow(until):
                if progress and bar is None:
                    bar = stack.enter_context(shown_design(self.name or self.id, now["budget_points"]))
                if bar is not None:
                    points = now["points"] + now["points_of_round"]
                    bar.begin(points, now["stage"] or now["state"], _best(now))
        if now["state"] not in ENDED:
            raise StillRunning(f"{self} is {now['state']} after {timeout:g} s: {_points(now)}.")
        self._answer(now)
        return self

    def _follow(self, until: float | None) -> Iterator[dict[str, Any]]:
        while True:
            now = self.record
            yield now
            if now["state"] in ENDED or (until is not None and time.monotonic() > until):
                return
            time.sleep(LOOK_SECONDS)

    def _answer(self, now: Mapping[str, Any]) -> dict[str, Any]:
        if now["state"] != "done":
            why = f" {now['message']}" if now.get("message") else ""
            raise Stopped(f"{self} is {now['state']}.{why} design.resume() continues it.")
        answer: dict[str, Any] = now["answer"]
        return answer

    def report(self, path: str | Path) -> Path:
        """Write the report of a completed design, to sign or to print.

        Parameters
        ----------
        path : path
            The file to write: a page of HTML, or sheets of A4 if its name ends in ``.pdf``; it appears when it is
            complete.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        Refused
            If it is a PDF, and the service cannot print.
        Conflict
            If the design is not done.
        """
        path = Path(path)
        part = path.with_name(f"{path.name}.part")
        where, how = f"/designs/{self.id}/report", {"format": "pdf" if path.suffix == ".pdf" else "html"}
        try:
            for attempt in self._transport.attempts():
                with attempt, self._transport.stream(where, params=how) as response:
                    part.write_bytes(response.read())
            return part.replace(path)
        finally:
            part.unlink(missing_ok=True)

    def cancel(self) -> "Design":
        """Stop the design; computed points are kept, and `resume` continues from there."""
        self._ask("POST", "/cancel")
        return self

    def resume(self) -> "Design":
        """Continue a design that was cancelled or has failed."""
        self._ask("POST", "/resume")
        return self

    def rename(self, name: str) -> "Design":
        """Rename the design; its specification keeps its own name."""
        self.name = str(self._ask("PATCH", json={"name": name})["name"])
        return self

    def delete(self, trash: bool = False) -> None:
        """Delete the design and its answer; cancel it first if it has not ended. Its studies stay.

        Parameters
        ----------
        trash : bool
            Whether `undelete` may restore it for a week.
        """
        self._ask("DELETE", params={"trash": True} if trash else None)

    def undelete(self) -> "Design":
        """Restore the design from the trash."""
        self._ask("POST", "/undelete")
        return self

    def _ask(self, method: str, what: str = "", **more: Any) -> Any:
        return self._transport.ask(method, f"/designs/{self.id}{what}", **more)


def ask_for(transport: Transport, specification: "Specification") -> Design:
    """Request a design from a service; see `Client.design`."""
    return Design(transport, transport.ask("POST", "/designs", **_sent(specification)))


def _sent(specification: "Specification") -> dict[str, Any]:
    """Give the arguments of `Transport.ask` that send a specification. A file is only read here; the service checks its
    content.
    """
    if isinstance(specification, Mapping):
        return body(specification)
    if isinstance(specification, str) and ("\n" in specification or specification.startswith("{")):
        return _written(specification.encode(), "yaml")
    if not isinstance(specification, str | Path):
        advice = "give a mapping, a path, a text of YAML, or a name like prototype"
        told = f"A specification cannot be read from {describe(specification)}."
        raise refused((Fault("specification", describe(specification), "a specification", advice, told),))
    path = Path(specification)
    kind = {".json": "json", ".yaml": "yaml", ".yml": "yaml"}.get(path.suffix.lower())
    if kind is not None and path.is_file():
        return _written(path.read_bytes(), kind)
    from damperlab.studies.specification.reading import read_specification

    try:
        return body(read_specification(str(specification)).document)
    except StudyFaults as error:
        raise refused(error.faults) from None


def _written(text: bytes, kind: str) -> dict[str, Any]:
    return {"content": text, "headers": {"Content-Type": f"application/{kind}"}}


def _best(now: Mapping[str, Any]) -> str:
    """Write the best damper so far; empty if there is none yet."""
    from damperlab.studies.design.spelling import best_so_far

    return best_so_far(now["known"]) if now.get("known") else ""


def _points(now: Mapping[str, Any]) -> str:
    return f"{now['points'] + now.get('points_of_round', 0):,} of at most {now['budget_points']:,} points"
