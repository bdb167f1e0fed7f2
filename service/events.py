"""The progress of a study as server-sent events: one at every change, and a last one when the study has ended."""

from collections.abc import AsyncIterator

import anyio
from fastapi.sse import ServerSentEvent

from damperlab.service.state import Service
from damperlab.studies.store.faults import StudyNotFound
from damperlab.studies.store.record import Record

LOOK_SECONDS = 0.5
"""Interval between checks of the record in the catalogue: the study may run in another process."""
RETRY_MILLISECONDS = 2000
"""Time before a browser connects again."""

_SHOWN = (
    "id",
    "name",
    "state",
    "phase",
    "phase_done",
    "phase_total",
    "points_total",
    "points_done",
    "points_failed",
    "blocks_total",
    "blocks_done",
    "started",
    "finished",
    "seconds_left",
    "message",
)


def event_id(record: Record) -> str:
    """Give the id of the event for a state of the study. Each event repeats all counts, so the id of the last one
    shows what a client has received.
    """
    return f"{record.blocks_done}-{record.points_failed}-{record.phase}-{record.phase_done or 0}"


async def progress(service: Service, record: Record, last_seen: str | None) -> AsyncIterator[ServerSentEvent]:
    """Follow a study to its end.

    Parameters
    ----------
    service : Service
        The running service; its shutdown ends the stream, and the client connects again.
    record : Record
        The study as it is now.
    last_seen : str, optional
        The ``Last-Event-ID`` of a reconnecting client, to which earlier events are not repeated.

    Yields
    ------
    ServerSentEvent
        ``progress`` with the study's counts, ``end`` when it has ended, ``deleted`` when it is gone.
    """
    seen = last_seen
    while True:
        now = event_id(record)
        if now != seen or record.ended:
            document = record.document()
            yield ServerSentEvent(
                event="end" if record.ended else "progress",
                data={key: document[key] for key in _SHOWN},
                id=now,
                retry=RETRY_MILLISECONDS,
            )
            seen = now
        if record.ended or service.closing.is_set():
            return
        await anyio.sleep(LOOK_SECONDS)
        try:
            record = await service.looks.ask(record.id)
        except StudyNotFound:
            yield ServerSentEvent(event="deleted", data={"id": record.id})
            return
