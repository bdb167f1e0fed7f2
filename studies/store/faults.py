"""Messages of the store for requests that it cannot fulfil."""

from collections.abc import Iterator
from contextlib import contextmanager

from damperlab.studies.faults import Fault
from damperlab.studies.store.files.shelf import ShelfAway
from damperlab.studies.user_error import UserError


class StoreFault(UserError):
    """An error that the user can correct; the text says how.

    Parameters
    ----------
    fault : Fault
        The field, the value found, the allowed values, the advice.
    """

    def __init__(self, fault: Fault) -> None:
        super().__init__(str(fault))
        self.fault = fault

    def __reduce__(self) -> tuple[type["StoreFault"], tuple[Fault]]:
        """Pickle by the fault, so that it survives transport from a worker process."""
        return type(self), (self.fault,)


class StudyNotFound(StoreFault):
    """No study, or more than one, has the given name or id."""


class StudyBusy(StoreFault):
    """A process works on the study; the request must wait until it ends."""


class KeyTaken(StoreFault):
    """The key of a submission belongs to another definition."""


class NothingToDo(StoreFault):
    """The request would change nothing in the study, or cannot help."""


class RevisionGone(StoreFault):
    """The study's cube is no longer available at that revision."""


class StoreAway(StoreFault):
    """The store cannot be reached, or denies access: the state of the data is unknown."""


class CatalogueDamaged(StoreFault):
    """The catalogue's entry of a study is damaged."""


class QuotaReached(StoreFault):
    """A study would exceed the quota."""


class TooManyUnfinished(QuotaReached):
    """The limit of waiting and running studies is reached."""


def may_pass(error: StoreFault) -> bool:
    """Whether a store or its catalogue may recover without intervention, for example after a server's restart or a
    lock.
    """
    return type(error) in (StoreFault, StoreAway)


def cannot_use(place: str, error: OSError) -> StoreFault:
    """Translate for users an error of reading or writing cubes."""
    away = isinstance(error, (ShelfAway, PermissionError))
    return (StoreAway if away else StoreFault)(
        Fault(
            place,
            str(error),
            "a cube that can be read and written",
            "check the server and the AWS_… variables; stored data are not affected, and studies continue "
            "once it answers"
            if place.startswith("s3://")
            else "check the disk's free space and the folder's permissions; a cube that is lost can be "
            "computed again after `damperlab delete`",
            f"{place} cannot be read or written: {error}.",
        )
    )


@contextmanager
def using(place: str) -> Iterator[None]:
    """Translate for users an error of a disk or an object store; raise `StoreFault`."""
    try:
        yield
    except OSError as error:
        raise cannot_use(place, error) from error


def catalogue_damaged(study_id: str, found: str, advice: str = "") -> CatalogueDamaged:
    """Make the fault for a study whose rows in the catalogue are damaged."""
    return CatalogueDamaged(
        Fault(
            f"study {study_id}",
            f"{found} in the catalogue",
            "the rows as they were written",
            advice
            or f"compare everything with `damperlab store verify {study_id}`, and repair it with `damperlab store verify "
            f"{study_id} --repair`; a catalogue that is beyond repair is made again by `damperlab store rebuild`",
            f"The catalogue is damaged: study {study_id} has {found}.",
        )
    )


def lost_files(noun: str, name: str, why: str, advice: str) -> Fault:
    """Make the fault for a design or a record whose files are damaged."""
    found = f"{name}, whose files are lost or damaged ({why})"
    told = f"The files of {noun} {name} are lost or damaged: {why.rstrip('.')}."
    return Fault(noun, found, f"a {noun} whose files are complete", advice, told)
