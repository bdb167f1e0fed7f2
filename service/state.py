"""State that all requests of a running service share."""

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
from damperlab.studies.faults import Fault, describe, printable
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
        Settings.
    store : Store
        Studies and cubes.
    dispatcher : Dispatcher
        Runs the queued studies.
    work : Work
        Computes for requests in separate processes.
    exports : Work
        Writes exports, without delaying questions.
    compiling : CapacityLimiter
        Limits the requests that wait for kernels, so that threads remain for the queries.
    submissions : CapacityLimiter
        Limits the requests that wait for the write lock, for the same reason.
    kernels : Kernels
        Compiles kernels that requests need.
    designer : Designer
        Runs the searches of the designs.
    scrub : Scrub
        Checks stored data for damage.
    closing : Event
        Set at the shutdown of the service, which ends streams.
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
        """The threads of the service as a whole."""
        return *self.dispatcher.backgrounds, self.designer.background, self.scrub.background

    @cached_property
    def readiness(self) -> Readiness:
        """Whether the service can serve."""
        return Readiness(self.store, self.backgrounds)

    @cached_property
    def looks(self) -> Shared[Record]:
        """Reads records in threads that wait for nothing else."""
        return Shared(self.store.find)


async def _service(request: Request) -> Service:
    service = request.app.state.service
    assert isinstance(service, Service)
    return service


TheService = Annotated[Service, Depends(_service)]
"""The running service, as a parameter of a route."""


StudyId = Annotated[
    str, Path(description="Id of a study, its name, or at least the first four digits of its id.")
]
"""Name of a study in an address."""


async def _study(request: Request, service: TheService, study_id: StudyId) -> Record:
    known: Record | None = request.scope.get("study")  # already looked up by the dependency
    return known or await service.looks.ask(study_id)


def _exact_study(
    service: TheService,
    caller: TheCaller,
    study_id: Annotated[str, Path(description="A study's whole id.")],
) -> Record:
    record = service.store.find(study_id)
    if record.id != study_id:
        # For reading, the beginning of an id or a name suffices; but a typing error must not delete a study.
        advice = f"write {record.id} if you mean {record.name}"
        told = f"To change a study, its complete id is required, and {printable(study_id)} is not one."
        raise StudyNotFound(Fault("study", describe(study_id), "a whole id", advice, told))
    require_own(caller, record)
    return record


TheStudy = Annotated[Record, Depends(_study)]
"""The record of the study in the path, as a parameter of a route; 404 if there is none."""

TheExactStudy = Annotated[Record, Depends(_exact_study)]
"""The record of the study, for routes that change it. They require the complete id, and the owner or an admin."""


DesignId = Annotated[
    str,
    Path(
        max_length=200, description="Id of a design, its name, or at least the first four digits of its id."
    ),
]
"""Name of a design in an address."""


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
        raise DesignNotFound(Fault("design", describe(design_id), "a whole id", advice, told))
    require_owner(caller, kept.owner, "design")
    return kept


TheDesign = Annotated[Kept, Depends(_design)]
"""The design in the path, as a parameter of a route; 404 if there is none."""

TheExactDesign = Annotated[Kept, Depends(_exact_design)]
"""The design, for routes that change it. They require the complete id, and the owner or an admin."""
