"""What may be wrong about a design that is asked of a shelf."""

from damperlab.studies.store.faults import StoreFault, lost_files


class DesignNotFound(StoreFault):
    """No design, or more than one, goes by the name or id that was given."""


class DesignDamaged(DesignNotFound):
    """The files of a design are not what was written."""


class DesignBusy(StoreFault):
    """The design is being worked on, so what was asked has to wait."""


class DesignsFull(StoreFault):
    """No more designs can be kept."""


def damaged(design_id: str, why: str) -> DesignDamaged:
    """Say that the files of a design are not what was written, and why."""
    advice = "delete it and submit its specification again: its studies are in the store, so nothing is computed twice"
    return DesignDamaged(lost_files("design", design_id, why, advice))
