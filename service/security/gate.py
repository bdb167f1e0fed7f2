"""The first check of every request: host, origin, key, scope and rate."""

from http import HTTPStatus

from starlette.datastructures import Headers
from starlette.requests import Request
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from damperlab.service.problems import Problem, respond
from damperlab.service.security.caller import SAFE_METHODS, Caller, scope_of
from damperlab.service.security.guard import Guard
from damperlab.service.security.origins import refusal
from damperlab.studies.faults import NOTHING, Fault, printable
from damperlab.studies.store.provenance import submitter

WITHOUT_A_KEY = "nobody"
"""Name that the audit log uses for a caller without a key."""


class Gate:
    """ASGI middleware that refuses foreign sites, requests without permission, and requests beyond the rate limit.

    Parameters
    ----------
    app : ASGI application
        The application that serves the allowed requests.
    guard : Guard
        Object that identifies callers and holds the limits.
    """

    def __init__(self, app: ASGIApp, guard: Guard) -> None:
        self.app = app
        self.guard = guard

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request, or refuse it."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        peer = scope["client"][0] if scope.get("client") else None
        believed = self.guard.proxies.believes(peer)
        if believed and headers.get("x-forwarded-proto", "").lower() == "https":
            scope["scheme"] = "https"
        problem = self._from_elsewhere(scope, headers)
        caller = None
        if problem is None:
            caller = await self.guard.identify(headers, peer)
            problem = _not_allowed(caller, scope) or self._too_often(caller, scope)
        if problem is not None:
            if caller is not None and problem.status == HTTPStatus.FORBIDDEN:
                self._note(scope, caller, peer, problem.status)
            await respond(Request(scope), problem)(scope, receive, send)
            return
        client = (self.guard.proxies.client(headers) if believed else None) or peer
        scope["caller"], scope["client_address"] = caller, client
        # set for every request; otherwise a request would inherit the submitter of the previous request
        # on the same connection
        submitter.set(caller.owner or None if caller else None)
        noted = False

        def note(status: int) -> None:
            nonlocal noted
            if not noted and (scope["method"] not in SAFE_METHODS or status == HTTPStatus.FORBIDDEN):
                self._note(scope, caller, client, status)
            noted = True

        async def send_noted(message: Message) -> None:
            if message["type"] == "http.response.start":
                # logged before the answer is sent, so that the log has a line for every answer that a client received
                note(message["status"])
            await send(message)

        try:
            await self.app(scope, receive, send_noted)
        finally:
            note(0)

    def _from_elsewhere(self, scope: Scope, headers: Headers) -> Problem | None:
        host = headers.get("host", "")
        if not (self.guard.hosts.allows(host) or (not host and scope["http_version"] == "1.0")):
            advice = "use one of these names, or let the operator add yours with --hosts"
            fault = Fault(
                "Host", printable(host) if host else NOTHING, f"one of {self.guard.hosts.told}", advice
            )
            return Problem(421, "foreign-host", "The service does not answer to this name.", (fault,))
        if scope["method"] in SAFE_METHODS:
            return None
        return refusal(headers, self.guard.origins)

    def _too_often(self, caller: Caller | None, scope: Scope) -> Problem | None:
        if caller is None or scope_of(scope["method"], scope["path"]) is None:
            return None  # requests that need no key have no limit
        rates = self.guard.rates
        seconds = rates.wait_seconds(caller.name) if caller.how != "open" else 0
        whose = "with one key"
        if not seconds:
            rates, whose = self.guard.rate_of_all, "of all callers together"
            seconds = rates.wait_seconds("")
        if not seconds:
            return None
        found, allowed = "more than that", f"{rates.per_minute} requests a minute {whose}"
        told = f"At most {allowed} are answered, but more were sent."
        fault = Fault("requests", found, allowed, f"try again in {seconds} s", told)
        headers = {"Retry-After": str(seconds)}
        return Problem(429, "too-many-requests", "Too many requests were sent.", (fault,), headers)

    def _note(self, scope: Scope, caller: Caller | None, peer: str | None, status: int) -> None:
        self.guard.audit.note(
            request=scope.get("request_id"),
            who=caller.owner if caller else "",
            how=caller.how if caller else WITHOUT_A_KEY,
            key=caller.key_id if caller else "",
            address=peer,
            method=scope["method"],
            path=scope.get("raw_path", b"").decode("ascii", "backslashreplace"),
            query=scope["query_string"].decode("ascii", "backslashreplace")[:500],
            status=status,
        )


def _not_allowed(caller: Caller | None, scope: Scope) -> Problem | None:
    wanted = scope_of(scope["method"], scope["path"])
    if wanted is None or (caller is not None and wanted in caller.scopes):
        return None
    if caller is None:
        advice = "send a key as `Authorization: Bearer …`; `damperlab admin keys create` creates one on the service's machine"
        told = f"The request has no valid key; it needs one of scope {wanted}."
        fault = Fault("Authorization", "no key that is valid", f"a key of scope {wanted}", advice, told)
        detail = "The service requires a key."
        return Problem(401, "no-key", detail, (fault,), {"WWW-Authenticate": 'Bearer realm="damperlab"'})
    fault = Fault(
        "Authorization",
        f"a key of scope {caller.scopes[-1]}",
        wanted,
        "use a key of that scope",
        f"The key has scope {caller.scopes[-1]}; the request needs one of scope {wanted}.",
    )
    return Problem(403, "scope-lacking", "The key does not allow this.", (fault,))
