"""The Python client of the service: ``from damperlab.service.client import Client``."""

from damperlab.service.client.client import Client
from damperlab.service.client.design import Design
from damperlab.service.client.faults import (
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
from damperlab.service.client.results import Accuracy, Estimate, Refinement, Simulation
from damperlab.service.client.study import Study

__all__ = [
    "Accuracy",
    "Client",
    "ClientFault",
    "Conflict",
    "Denied",
    "Design",
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
