"""The caller of a request, identified by a key, a session or a proxy."""

from dataclasses import dataclass
from typing import Annotated, Literal

from fastapi import Depends
from starlette.requests import Request
from starlette.types import Scope as Connection

from damperlab.service.problems import Problem
from damperlab.service.security.address import counted_address
from damperlab.studies.faults import Fault
from damperlab.studies.store.record import Record
from damperlab.studies.vocabulary import SCOPES, Scope

SAFE_METHODS = frozenset(("GET", "HEAD", "OPTIONS"))
"""HTTP methods that change nothing."""
PUBLIC = ("/health/", "/page/", "/docs/", "/api/v1/session")
"""Paths that need no key: probes, the files of the page, the documentation, and the sign-in."""
PUBLIC_FILES = ("/", "/openapi.json")


@dataclass(frozen=True)
class Caller:
    """The caller of a request.

    Parameters
    ----------
    owner : str
        Owner of the studies that the caller submits; empty if no keys are required.
    scopes : tuple of str
        Scopes of the caller, in the order of `SCOPES`.
    how : {"open", "key", "session", "proxy"}
        How the caller was identified.
    key_id : str
        Id of the caller's key; empty if the caller has no key.
    """

    owner: str
    scopes: tuple[Scope, ...]
    how: Literal["open", "key", "session", "proxy"]
    key_id: str = ""

    @property
    def name(self) -> str:
        """Identity to which limits apply: the first of `key_id`, `owner` and `how` that is not empty."""
        return self.key_id or self.owner or self.how


ANYBODY = Caller("", SCOPES, "open")
"""The caller of every request, if no keys are required."""


def counted_under(scope: Connection) -> str:
    """Return the identity to which limits apply: the caller's name or, if no keys are required, the address."""
    caller: Caller = scope["caller"]
    address = scope.get("client_address") if caller.how == "open" else None
    return counted_address(address) if address else caller.name


def scope_of(method: str, path: str) -> str | None:
    """Return the scope that a request needs; None if the request needs no key."""
    if path in PUBLIC_FILES or path.startswith(PUBLIC):
        return None
    return "read" if method in SAFE_METHODS else "submit"


def require_own(caller: Caller, study: Record) -> None:
    """Refuse to change a study of another owner.

    Raises
    ------
    Problem
        403 if the study has another owner and the caller is not an admin.
    """
    require_owner(caller, study.submitted_by, "study")


def require_owner(caller: Caller, owner: str | None, what: str) -> None:
    """Refuse to change an object of another owner; `what` is the kind of object, for example "study"."""
    if "admin" not in caller.scopes and owner != caller.owner:
        whose = f"a {what} of {owner}" if owner else f"a {what} that was submitted without a key"
        fault = Fault(
            what,
            whose,
            f"what {caller.owner} submitted",
            "ask its owner, or use a key of scope admin",
            f"This is {whose}; your key belongs to {caller.owner}.",
        )
        raise Problem(403, "not-yours", f"This {what} is not yours to change.", (fault,))


async def _caller(request: Request) -> Caller | None:
    caller: Caller | None = request.scope["caller"]
    return caller


async def _known(request: Request) -> Caller:
    caller = await _caller(request)
    assert caller is not None, "the gate lets only identified callers pass to a route that needs a key"
    return caller


TheCaller = Annotated[Caller, Depends(_known)]
"""The caller, as a parameter of a route that needs a key."""

TheCallerOrNobody = Annotated[Caller | None, Depends(_caller)]
"""The caller, as a parameter of a route that needs no key."""
