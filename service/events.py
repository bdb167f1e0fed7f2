"""Sends the progress of a study to clients as server-sent events."""

from collections.abc import AsyncIterator

import anyio
from fastapi.sse import ServerSentEvent

from damperlab.service.state import Service
from damperlab.studies.store.faults import StudyNotFound
from damperlab.studies.store.record import Record

LOOK_SECONDS = 0.5
"""Interval between checks of the study's record in the catalogue [s]. The study may run in another process."""
RETRY_MILLISECONDS = 2000
"""Time after which a browser connects again if the connection is lost."""

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
    """Return the id of the event that reports the present progress of a study."""
    return f"{record.blocks_done}-{record.points_failed}-{record.phase}-{record.phase_done or 0}"


async def progress(service: Service, record: Record, last_seen: str | None) -> AsyncIterator[ServerSentEvent]:
    """Yield an event at each change of a study, until the study ends.

    Parameters
    ----------
    service : Service
        The running service. Its shutdown ends the stream, and the client then connects again.
    record : Record
        Present record of the study.
    last_seen : str, optional
        Header ``Last-Event-ID`` of a client that connects again. An event with this id is not sent again.

    Yields
    ------
    ServerSentEvent
        Event ``progress`` after a change, ``end`` at the end of the study, or ``deleted`` if the study was deleted.
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
