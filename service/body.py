"""Reads request bodies, and refuses bodies that are too large or in an unknown format or encoding."""

from pydantic import BaseModel, ConfigDict, Field
from starlette.requests import Request

from damperlab.service.problems import Problem
from damperlab.service.security.caller import SAFE_METHODS
from damperlab.studies.faults import NOTHING, Fault, StudyFaults, listing, printable
from damperlab.studies.store.record import TRASH_DAYS


class DeleteQuery(BaseModel):
    """Parameters of a deletion."""

    model_config = ConfigDict(extra="forbid")

    trash: bool = Field(
        False,
        description=f"Move the study or design to the trash for {TRASH_DAYS} days. During this time POST …/undelete "
        "restores it, and it counts for quotas.",
    )


class ComputeQuery(BaseModel):
    """Parameters of a request that is computed immediately."""

    model_config = ConfigDict(extra="forbid")

    dry_run: bool = Field(
        False,
        description="Compute nothing, but tell whether kernels must be compiled before the computation.",
    )


JSON_TYPES = ("application/json",)
NOTHING_BYTES = 1024
"""Largest number of bytes read from the body of a request whose route takes no body."""
YAML_TYPES = ("application/yaml", "application/x-yaml", "text/yaml", "text/x-yaml")


def media_type(request: Request, allowed: tuple[str, ...]) -> str:
    """Return the media type of the body, in lower case and without parameters.

    Parameters
    ----------
    request : Request
        The request, whose body has not been read yet.
    allowed : tuple of str
        Media types that the route accepts.

    Raises
    ------
    Problem
        If the media type is missing or not allowed, the charset is not UTF-8, or the body is compressed (status 415).
    """
    found, _, rest = request.headers.get("content-type", "").lower().partition(";")
    found = found.strip()
    # the parser of the standard library follows RFC 2231 for mail and fails on unusual parameters
    written = [value.strip() for name, _, value in map(_parted, rest.split(";")) if name.strip() == "charset"]
    charset = written[0].strip('"') if written else "utf-8"
    encoding = request.headers.get("content-encoding", "identity").strip().lower()
    faults = []
    if found not in allowed:
        advice = f"name the format of the body, as in `Content-Type: {allowed[0]}`"
        faults.append(
            Fault(
                "Content-Type", printable(found) if found else NOTHING, f"one of {listing(allowed)}", advice
            )
        )
    if charset.replace("_", "-") not in ("utf-8", "utf8", "us-ascii"):
        faults.append(
            Fault(
                "Content-Type",
                f"charset={printable(charset)}",
                "in the charset utf-8",
                "send the text in UTF-8",
            )
        )
    if encoding not in ("identity", ""):
        faults.append(
            Fault(
                "Content-Encoding", printable(encoding), "identity or left out", "send the body uncompressed"
            )
        )
    if faults:
        raise Problem(
            415,
            "unsupported-media-type",
            "The body is in a format that this request does not accept.",
            faults,
            {"Accept": ", ".join(allowed)},
        )
    return found


def _parted(parameter: str) -> tuple[str, str, str]:
    return parameter.partition("=")


async def read_body(request: Request, limit: int) -> bytes:
    """Read the body of a request, up to a limit.

    Parameters
    ----------
    request : Request
        The request.
    limit : int
        Largest number of bytes.

    Raises
    ------
    Problem
        If the body is larger than `limit` (status 413).
    """
    announced = request.headers.get("content-length", "")
    if announced.isascii() and announced.isdigit() and int(announced) > limit:
        raise _too_large(f"{announced} bytes", limit)
    body = bytearray()
    async for part in request.stream():
        if len(body) + len(part) > limit:
            raise _too_large("more than that", limit)
        body += part
    return bytes(body)


EMPTY = (b"", b"{}", b"null")
"""Bodies that count as empty."""


async def expected(request: Request) -> None:
    """Refuse the body of a request whose route takes no body, because the body would be ignored."""
    takes_one = "requestBody" in (getattr(request.scope.get("route"), "openapi_extra", None) or {})
    sends_one = "transfer-encoding" in request.headers or request.headers.get("content-length", "0") != "0"
    if request.method in SAFE_METHODS or takes_one or not sends_one:
        return
    body = await read_body(request, NOTHING_BYTES)
    if body.strip() not in EMPTY:
        advice = "put the parameters into the address, as in ?dry_run=true"
        told = "This request takes no body: its parameters are part of the address."
        raise StudyFaults([Fault("body", f"{len(body)} bytes", "no body", advice, told)])


def _too_large(found: str, limit: int) -> Problem:
    fault = Fault(
        "body",
        found,
        f"at most {limit:,} bytes",
        "send less; an axis may be {start, stop, num} instead of a list",
        f"The body may have at most {limit:,} bytes.",
    )
    return Problem(413, "body-too-large", "The body is larger than the service reads.", (fault,))
