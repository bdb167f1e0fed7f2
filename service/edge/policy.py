"""Security headers of every answer: they forbid framing, guessing of the content type, and use by other sites."""

from starlette.datastructures import MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

POLICY_HEADERS = {
    "X-Content-Type-Options": "nosniff",
    "Content-Security-Policy": "default-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "Referrer-Policy": "no-referrer",
    "X-Frame-Options": "DENY",
}
"""Headers of every answer. The web page has a wider content security policy, which allows the page's own files."""
HSTS = "max-age=31536000"
"""Value of the header Strict-Transport-Security, which makes browsers use only TLS for a year."""


class Policy:
    """ASGI middleware: adds the security headers to every answer that lacks them.

    Parameters
    ----------
    app : ASGI application
        The application that answers.
    shared : bool
        Whether pages of other origins may read answers, as set by `cors_origins`.
    """

    def __init__(self, app: ASGIApp, shared: bool) -> None:
        self.app = app
        own = {} if shared else {"Cross-Origin-Resource-Policy": "same-origin"}
        self.headers = POLICY_HEADERS | own

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return

        async def send_with_policy(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in self.headers.items():
                    headers.setdefault(name, value)
                if scope["scheme"] == "https":
                    headers.setdefault("Strict-Transport-Security", HSTS)
            await send(message)

        await self.app(scope, receive, send_with_policy)
