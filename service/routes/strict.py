"""Routers that refuse unknown and repeated parameters, and a request body that the route does not read."""

from fastapi import Depends

from damperlab.service.body import expected
from damperlab.service.parameters import once
from damperlab.service.routes.late import LateRouter


def strict_router(prefix: str = "", tag: str = "") -> LateRouter:
    """Make a router for routes whose paths begin with `prefix`; the OpenAPI document lists them under `tag`."""
    return LateRouter(
        prefix=prefix, tags=[tag] if tag else [], dependencies=[Depends(once), Depends(expected)]
    )
