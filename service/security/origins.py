"""Refuses requests that a browser sends for a page of another site."""

from collections.abc import Collection

from starlette.datastructures import Headers

from damperlab.service.problems import Problem
from damperlab.studies.faults import Fault, printable

# a browser sends bodies of these types from any page without a preflight
_SIMPLE_TYPES = ("text/plain", "application/x-www-form-urlencoded", "multipart/form-data")


def refusal(headers: Headers, shared_with: Collection[str]) -> Problem | None:
    """Return the reason to refuse a request that changes data; None if the request is allowed.

    Parameters
    ----------
    headers : Headers
        Headers of the request.
    shared_with : collection of str
        Allowed origins in addition to the service's own origin.
    """
    origin, site = headers.get("origin"), headers.get("sec-fetch-site")
    if origin is None and site is None:
        return None  # a present-day browser sends at least one of these headers
    if origin is not None:
        if origin in shared_with:
            return None
        # the scheme is ignored, because it differs behind a proxy that terminates TLS
        if origin.partition("://")[2].lower() != headers.get("host", "").lower() or "://" not in origin:
            return _cross(Fault("Origin", printable(origin), _own(headers), _ADVICE))
    if site not in (None, "same-origin", "none"):
        return _cross(Fault("Sec-Fetch-Site", printable(site or ""), "same-origin", _ADVICE))
    kind = headers.get("content-type", "").partition(";")[0].strip().lower()
    if kind in _SIMPLE_TYPES:
        fault = Fault(
            "Content-Type", kind, "one of application/json, text/csv, application/octet-stream", _TYPE_ADVICE
        )
        return Problem(
            415,
            "unsupported-media-type",
            "Any web page can make a browser send a body of this type.",
            (fault,),
        )
    return None


_ADVICE = (
    "send the request from the service's own page or from a program, or let the operator add the origin to "
    "cors_origins"
)
_TYPE_ADVICE = "name the format of the body"


def _own(headers: Headers) -> str:
    return f"the origin of {printable(headers.get('host', ''))}"


def _cross(fault: Fault) -> Problem:
    told = "A page of another origin sent this request. The service refused it."
    return Problem(403, "cross-site", told, (fault,))
