"""The caller, as identified by a key, a session or a proxy."""

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
"""Methods that change nothing."""
PUBLIC = ("/health/", "/page/", "/docs/", "/api/v1/session")
"""Addresses that need no key: probes, the files of the page, the documentation, and the sign-in."""
PUBLIC_FILES = ("/", "/openapi.json")


@dataclass(frozen=True)
class Caller:
    """A caller.

    Parameters
    ----------
    owner : str
        Owner of submitted studies; empty without keys.
    scopes : tuple of str
        Scope.
    how : {"open", "key", "session", "proxy"}
        How the caller was identified.
    key_id : str
        Id of the key, if there is one.
    """

    owner: str
    scopes: tuple[Scope, ...]
    how: Literal["open", "key", "session", "proxy"]
    key_id: str = ""

    @property
    def name(self) -> str:
        """Identity to which limits apply: a person or a program."""
        return self.key_id or self.owner or self.how


ANYBODY = Caller("", SCOPES, "open")
"""Any caller, if no keys are required."""


def counted_under(scope: Connection) -> str:
    """Name the identity under which a request is counted: its key or user and, without keys, its address."""
    caller: Caller = scope["caller"]
    address = scope.get("client_address") if caller.how == "open" else None
    return counted_address(address) if address else caller.name


def scope_of(method: str, path: str) -> str | None:
    """Name the scope that a request needs; None if it needs no key."""
    if path in PUBLIC_FILES or path.startswith(PUBLIC):
        return None
    return "read" if method in SAFE_METHODS else "submit"


def require_own(caller: Caller, study: Record) -> None:
    """Refuse a change to a study of another owner.

    Raises
    ------
    Problem
        403 if the study has another owner and the caller is not an admin.
    """
    require_owner(caller, study.submitted_by, "study")


def require_owner(caller: Caller, owner: str | None, what: str) -> None:
    """Refuse a change to an object of another owner; `what` names it."""
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
