"""State that all requests of a running service share, and FastAPI dependencies that pass this state to routes."""

import threading
from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated

from anyio import CapacityLimiter
from fastapi import Depends, Path
from starlette.requests import Request

from damperlab.service.designer import Designer
from damperlab.service.dispatch import Dispatcher
from damperlab.service.kernels import Kernels
from damperlab.service.readiness import Readiness
from damperlab.service.scrub import Scrub
from damperlab.service.security.caller import TheCaller, require_own, require_owner
from damperlab.service.settings import Settings
from damperlab.service.work.processes import Work
from damperlab.service.work.shared import Shared
from damperlab.studies.design.kept import Kept
from damperlab.studies.design.shelf import DesignNotFound
from damperlab.studies.faults import describe, printable
from damperlab.studies.store.faults import StudyNotFound
from damperlab.studies.store.record import Record
from damperlab.studies.store.store import Store
from damperlab.worker.run.background import Background


@dataclass(frozen=True)
class Service:
    """The parts of a running service.

    Parameters
    ----------
    settings : Settings
        Settings of the service.
    store : Store
        Store of studies and cubes.
    dispatcher : Dispatcher
        Object that runs the queued studies.
    work : Work
        Processes that compute answers to requests.
    exports : Work
        Separate processes that write exports, so that exports do not delay other requests.
    compiling : CapacityLimiter
        Limit of the number of requests that wait for kernels, so that threads remain for other requests.
    submissions : CapacityLimiter
        Limit of the number of requests that wait for the write lock, so that threads remain for other requests.
    kernels : Kernels
        Object that compiles kernels for requests.
    designer : Designer
        Object that runs the searches for designs.
    scrub : Scrub
        Object that checks stored data for damage.
    closing : Event
        Event that is set at the shutdown of the service. Event streams then end.
    """

    settings: Settings
    store: Store
    dispatcher: Dispatcher
    work: Work
    exports: Work
    compiling: CapacityLimiter
    submissions: CapacityLimiter
    kernels: Kernels
    designer: Designer
    scrub: Scrub
    closing: threading.Event = field(default_factory=threading.Event)

    @property
    def backgrounds(self) -> tuple[Background, ...]:
        """Background threads of the service."""
        return *self.dispatcher.backgrounds, self.designer.background, self.scrub.background

    @cached_property
    def readiness(self) -> Readiness:
        """Object that checks whether the service can use its data."""
        return Readiness(self.store, self.backgrounds)

    @cached_property
    def looks(self) -> Shared[Record]:
        """Reader of study records. Simultaneous requests for the same record share one access to the catalogue."""
        return Shared(self.store.find)


async def _service(request: Request) -> Service:
    service = request.app.state.service
    assert isinstance(service, Service)
    return service


TheService = Annotated[Service, Depends(_service)]
"""Type of a route parameter: the running service."""


StudyId = Annotated[
    str, Path(description="Id of a study, its name, or at least the first four digits of its id.")
]
"""Type of a route parameter: the id or the name of a study in the path."""


async def _study(request: Request, service: TheService, study_id: StudyId) -> Record:
    known: Record | None = request.scope.get("study")  # set if the middleware `Kept` has read the record
    return known or await service.looks.ask(study_id)


def _exact_study(
    service: TheService,
    caller: TheCaller,
    study_id: Annotated[str, Path(description="A study's whole id.")],
) -> Record:
    record = service.store.find(study_id)
    if record.id != study_id:
        # Routes that change data accept only a full id, so that a typing error cannot delete another study.
        advice = f"write {record.id} if you mean {record.name}"
        told = f"To change a study, its complete id is required, and {printable(study_id)} is not one."
        raise StudyNotFound("study", describe(study_id), "a whole id", advice, told)
    require_own(caller, record)
    return record


TheStudy = Annotated[Record, Depends(_study)]
"""Type of a route parameter: the record of the study in the path. The status is 404 if there is no such study."""

TheExactStudy = Annotated[Record, Depends(_exact_study)]
"""Type of a route parameter: the record of a study that the caller may change. The path must contain the full id."""


DesignId = Annotated[
    str,
    Path(
        max_length=200, description="Id of a design, its name, or at least the first four digits of its id."
    ),
]
"""Type of a route parameter: the id or the name of a design in the path."""


def _design(service: TheService, design_id: DesignId) -> Kept:
    return service.designer.shelf.find(design_id)


def _exact_design(
    service: TheService,
    caller: TheCaller,
    design_id: Annotated[str, Path(max_length=200, description="A design's whole id.")],
) -> Kept:
    kept = service.designer.shelf.find(design_id)
    if kept.id != design_id:
        advice = f"write {kept.id} if you mean {kept.name}"
        told = f"To change a design, its complete id is required, and {printable(design_id)} is not one."
        raise DesignNotFound("design", describe(design_id), "a whole id", advice, told)
    require_owner(caller, kept.owner, "design")
    return kept


TheDesign = Annotated[Kept, Depends(_design)]
"""Type of a route parameter: the design in the path. The status is 404 if there is no such design."""

TheExactDesign = Annotated[Kept, Depends(_exact_design)]
"""Type of a route parameter: a design that the caller may change. The path must contain the full id."""
