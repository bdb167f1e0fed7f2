"""One design of a service: its progress, its answer, and methods to control it."""

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
"""Interval between requests while waiting for a design [s]."""


class Design:
    """A design stored by the service, as returned by `Client.design` and `Client.designs`.

    Parameters
    ----------
    transport : Transport
        The connection to the service.
    document : mapping
        The service's record of the design; some keys may be missing.

    Attributes
    ----------
    id, name : str
        First twelve digits of the specification's digest, and name of the design.
    """

    def __init__(self, transport: Transport, document: Mapping[str, Any]) -> None:
        self._transport = transport
        self.id = str(document["id"])
        self.name = str(document["name"])

    def __repr__(self) -> str:
        """Name the design."""
        return f"<Design {self.id} {self.name!r}>"

    def _repr_html_(self) -> str:
        """Show the design in a notebook: the sentences of its answer, or its progress if there is no answer yet."""
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
        """Return a hash that is consistent with equality."""
        return hash((self.id, self._transport.url))

    @property
    def record(self) -> dict[str, Any]:
        """The present record with ``state``, ``stage``, ``points``, ``budget_points``, ``known`` (the best damper) …"""
        found: dict[str, Any] = self._ask("GET")
        return found

    @property
    def state(self) -> str:
        """The present state: ``queued``, ``running``, ``done``, ``cancelled`` or ``failed``."""
        return str(self.record["state"])

    @property
    def answer(self) -> dict[str, Any]:
        """The answer, which is the output of `damperlab design --json`.

        Keys: ``design`` (the values for the drawing), ``worst``, ``probability``, ``words``, …

        Raises
        ------
        StillRunning
            If the design has not ended.
        Stopped
            If the design has failed or was cancelled.
        """
        now = self.record
        if now["state"] not in ENDED:
            raise StillRunning(f"{self} is {now['state']}: {_points(now)}.")
        return self._answer(now)

    @property
    def amplitudes(self) -> "xr.Dataset":
        """The response of the recommended damper over ``amplitude`` and ``frequency_ratio``.

        The amplitudes range from half the smallest amplitude of the specification to twice the largest. The Dataset
        holds ``value``, the ``ratio`` of ``value`` to the base amplitude, ``worst`` and ``worst_frequency_ratio``.

        Raises
        ------
        StillRunning
            If the design has not ended.
        Stopped
            If the design has failed or was cancelled.
        """
        from damperlab.studies.design.backbone import backbone_dataset

        return backbone_dataset(self.answer.get("amplitudes", []))

    def wait(self, progress: bool = True, timeout: float | None = None) -> "Design":
        """Wait until the design is done.

        Lost connections and restarts of the service do not end the wait.

        Parameters
        ----------
        progress : bool
            Show the number of points, the present activity and the best damper so far. A terminal or a notebook shows a
            bar; elsewhere lines are printed from time to time.
        timeout : float, optional
            Stop waiting after this many seconds; the design itself continues.

        Returns
        -------
        Design
            The design itself.

        Raises
        ------
        Stopped
            If the design has failed or was cancelled.
        StillRunning
            If the design has not ended in time.
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
        """Write the report of a completed design, which can be printed and signed.

        Parameters
        ----------
        path : path
            File to write: a PDF of A4 pages if the name ends in ``.pdf``, otherwise a page of HTML. The file appears
            only when the report is complete.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        Refused
            If `path` is a PDF and the service cannot print.
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
        """Stop the design. Computed points are kept, and `resume` continues the design."""
        self._ask("POST", "/cancel")
        return self

    def resume(self) -> "Design":
        """Continue a design that was cancelled or has failed."""
        self._ask("POST", "/resume")
        return self

    def rename(self, name: str) -> "Design":
        """Rename the design. The name in the specification is unchanged."""
        self.name = str(self._ask("PATCH", json={"name": name})["name"])
        return self

    def delete(self, trash: bool = False) -> None:
        """Delete the design and its answer; the studies of the design stay.

        A design that has not ended must be cancelled first.

        Parameters
        ----------
        trash : bool
            Whether `undelete` can restore the design for a week.
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
    """Return the arguments of `Transport.ask` that send a specification."""
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
    """Describe the best damper so far; the text is empty if no damper is known yet."""
    from damperlab.studies.design.spelling import best_so_far

    return best_so_far(now["known"]) if now.get("known") else ""


def _points(now: Mapping[str, Any]) -> str:
    return f"{now['points'] + now.get('points_of_round', 0):,} of at most {now['budget_points']:,} points"
