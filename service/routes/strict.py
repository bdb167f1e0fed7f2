"""Routers that refuse unknown and repeated parameters, and a request body that the route does not read."""

from fastapi import APIRouter, Depends

from damperlab.service.body import expected
from damperlab.service.parameters import once


def strict_router(prefix: str = "", tag: str = "") -> APIRouter:
    """Make a router for routes whose paths begin with `prefix`; the OpenAPI document lists them under `tag`."""
    return APIRouter(
        prefix=prefix, tags=[tag] if tag else [], dependencies=[Depends(once), Depends(expected)]
    )
