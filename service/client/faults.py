"""Exceptions of the client: refusals by the service, and failures without an answer."""

from collections.abc import Mapping
from typing import Any

from damperlab.studies.faults import PARTS, Fault
from damperlab.studies.user_error import UserError


class ClientFault(UserError):
    """Base class of all errors of the client."""


class Unreachable(ClientFault):
    """No service answers at the address, or the answer is not from a damperlab service."""


class Stopped(ClientFault):
    """A study has failed or was cancelled during the wait; the message gives the reason."""


class StillRunning(ClientFault, TimeoutError):
    """A study has not ended within the given time, and continues to run."""


class Problem(ClientFault):
    """The service has refused a request.

    Parameters
    ----------
    document : mapping
        The problem document (RFC 9457).

    Attributes
    ----------
    status : int
        HTTP status.
    type, title, detail : str
        `type` is the kind of problem, ``urn:damperlab:problem:<kind>``. `title` is the status in words, empty if
        no request was sent. `detail` says what happened.
    faults : tuple of Fault
        The faults of the request, each with `field`, `found`, `allowed`, `advice` and `message`.
    request_id : str, optional
        Id of the request in the service's log.
    """

    def __init__(self, document: Mapping[str, Any]) -> None:
        self.document = dict(document)
        self.status = int(document["status"])
        self.type = str(document.get("type", "about:blank"))
        self.title = str(document.get("title", ""))
        self.detail = str(document.get("detail", ""))
        self.request_id: str | None = document.get("request_id")
        self.faults = tuple(
            Fault(*(str(entry.get(name, "")) for name in PARTS)) for entry in document.get("errors", ())
        )
        super().__init__(self.detail)

    def __str__(self) -> str:
        """Return the description of the problem, followed by one line for each fault."""
        answered = f" ({self.status} {self.title})" if self.title else ""
        lines = [f"{self.detail}{answered}".lstrip()]
        return "\n".join((*lines, *(f"  {fault}" for fault in self.faults)))

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the exception, so that another process can receive it."""
        return type(self), (self.document,)


class Refused(Problem):
    """The request has faults (400, 405, 413, 415, 422), or the study exceeds the quota (507)."""


class NotFound(Problem):
    """There is no such study, record or report (404, 410)."""


class Conflict(Problem):
    """The state of the study does not allow the request (409)."""


class Unavailable(Problem):
    """The service or a proxy cannot answer now (429, 502, 503, 504), even after repeated requests."""


class Denied(Problem):
    """The service or a proxy requires another key (401, 403)."""


_KINDS: dict[int, type[Problem]] = {
    **dict.fromkeys((400, 405, 413, 415, 422, 507), Refused),
    **dict.fromkeys((401, 403), Denied),
    **dict.fromkeys((404, 410), NotFound),
    409: Conflict,
    **dict.fromkeys((429, 502, 503, 504), Unavailable),
}


def problem(document: Mapping[str, Any]) -> Problem:
    """Make the exception for a problem document."""
    return _KINDS.get(int(document["status"]), Problem)(document)


def refused(faults: tuple[Fault, ...]) -> Refused:
    """Make the exception for an invalid request, which the client has not sent."""
    entries = [fault.document() for fault in faults]
    what = "Nothing was sent."
    return Refused(
        {
            "type": "urn:damperlab:problem:invalid",
            "title": "",
            "status": 422,
            "detail": what,
            "errors": entries,
        }
    )
