"""The Python client of the service: ``from service.client import Client``."""

from service.client.client import Client
from service.client.faults import (
    ClientFault,
    Conflict,
    Denied,
    NotFound,
    Problem,
    Refused,
    StillRunning,
    Stopped,
    Unavailable,
    Unreachable,
)
from service.client.results import Accuracy, Estimate, Refinement, Simulation
from service.client.study import Study

__all__ = [
    "Accuracy",
    "Client",
    "ClientFault",
    "Conflict",
    "Denied",
    "Estimate",
    "NotFound",
    "Problem",
    "Refinement",
    "Refused",
    "Simulation",
    "StillRunning",
    "Stopped",
    "Study",
    "Unavailable",
    "Unreachable",
]
