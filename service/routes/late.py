"""Routes that FastAPI analyses at their first request, so that the service starts faster.

Add the routes of a `LateRouter` to an application directly. `FastAPI.include_router` would call the functions
of the routes without the parameters of the request. If FastAPI refuses the declaration of a route, the
exception is raised at the first request of the route, or when `Application.openapi` is called.
"""

from collections.abc import Callable, Collection
from functools import cached_property
from typing import Any

from fastapi import APIRouter
from starlette.routing import BaseRoute, Match, Route
from starlette.types import Receive, Scope, Send


class LateRoute(Route):
    """A route that FastAPI analyses at its first request.

    Parameters
    ----------
    path : str
        Path of the route.
    endpoint : callable
        Function that answers requests.
    methods : collection of str
        HTTP methods of the route.
    analyse : callable
        Returns FastAPI's route.
    """

    def __init__(
        self,
        path: str,
        endpoint: Callable[..., Any],
        methods: Collection[str],
        analyse: Callable[[], BaseRoute],
    ) -> None:
        super().__init__(path, endpoint, methods=methods)
        self._analyse = analyse

    @cached_property
    def analysed(self) -> BaseRoute:
        """FastAPI's route."""
        return self._analyse()

    def matches(self, scope: Scope) -> tuple[Match, Scope]:
        """Return whether a request matches the route, and the entries that the route adds to the scope of the request."""
        unlike = super().matches(scope)[0] is Match.NONE
        return (Match.NONE, {}) if unlike else self.analysed.matches(scope)

    async def handle(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request."""
        await self.analysed.handle(scope, receive, send)


class LateRouter(APIRouter):
    """A router whose routes FastAPI analyses at their first request. The options are the same as for `APIRouter`."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self._options = options

    def add_api_route(self, path: str, endpoint: Callable[..., Any], **options: Any) -> None:
        """Add a route, with the options of `APIRouter.add_api_route`."""

        def analyse() -> BaseRoute:
            router = APIRouter(**self._options)
            router.add_api_route(path, endpoint, **options)
            return router.routes[0]

        methods = options.get("methods") or ["GET"]
        self.routes.append(LateRoute(self.prefix + path, endpoint, methods, analyse))
