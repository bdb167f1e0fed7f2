"""Routers whose routes refuse what they would ignore: unknown and repeated parameters, and a body that they do not read."""

from fastapi import APIRouter, Depends

from damperlab.service.body import expected
from damperlab.service.parameters import once


def strict_router(prefix: str = "", tag: str = "") -> APIRouter:
    """Make a router for routes under an address, listed under a tag of the OpenAPI document."""
    return APIRouter(
        prefix=prefix, tags=[tag] if tag else [], dependencies=[Depends(once), Depends(expected)]
    )
