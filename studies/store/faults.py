"""What the store tells its users when it cannot do what was asked."""

from collections.abc import Iterator
from contextlib import contextmanager

from damperlab.studies.faults import Fault
from damperlab.studies.store.files.shelf import ShelfAway
from damperlab.studies.user_error import UserError


class StoreFault(UserError):
    """Something that the user can put right; the text says how.

    Parameters
    ----------
    fault : Fault
        Which field, what was found, what is allowed, what to do.
    """

    def __init__(self, fault: Fault) -> None:
        super().__init__(str(fault))
        self.fault = fault

    def __reduce__(self) -> tuple[type["StoreFault"], tuple[Fault]]:
        """Pickle by the fault, so that it travels from a worker process whole."""
        return type(self), (self.fault,)


class StudyNotFound(StoreFault):
    """No study, or more than one, goes by the name or id that was given."""


class StudyBusy(StoreFault):
    """Something works on the study; the request has to wait until it ends."""


class KeyTaken(StoreFault):
    """The key of a submission belongs to another definition."""


class NothingToDo(StoreFault):
    """What was asked of a study would change nothing, or cannot help."""


class RevisionGone(StoreFault):
    """The study's cube cannot be shown as it was at that revision."""


class StoreAway(StoreFault):
    """What is stored cannot be reached, or may not be: nothing is known of its state."""


class CatalogueDamaged(StoreFault):
    """What the catalogue says of a study is not what was written."""


class QuotaReached(StoreFault):
    """A study would take more than studies may."""


class TooManyUnfinished(QuotaReached):
    """As many studies wait or run as may."""


def may_pass(error: StoreFault) -> bool:
    """Whether a store or its catalogue may answer again by itself: a server that restarts, a lock, a disk."""
    return type(error) in (StoreFault, StoreAway)


def cannot_use(place: str, error: OSError) -> StoreFault:
    """Put what keeps cubes from being read or written into the user's words."""
    away = isinstance(error, (ShelfAway, PermissionError))
    return (StoreAway if away else StoreFault)(
        Fault(
            place,
            str(error),
            "a cube that can be read and written",
            "check the server and the AWS_… variables; what is stored is not touched, and studies go on once it answers"
            if place.startswith("s3://")
            else "check the disk's free space and the folder's permissions; a cube that is lost can be "
            "computed again after `damperlab delete`",
            f"{place} cannot be read or written: {error}.",
        )
    )


@contextmanager
def using(place: str) -> Iterator[None]:
    """Put what a disk or an object store refuses into the user's words; raise `StoreFault`."""
    try:
        yield
    except OSError as error:
        raise cannot_use(place, error) from error


def catalogue_damaged(study_id: str, found: str, advice: str = "") -> CatalogueDamaged:
    """Make the fault for a study whose rows in the catalogue are not what was written."""
    return CatalogueDamaged(
        Fault(
            f"study {study_id}",
            f"{found} in the catalogue",
            "the rows that were written",
            advice
            or f"compare everything with `damperlab store verify {study_id}`, and repair it with `damperlab store verify "
            f"{study_id} --repair`; a catalogue that is beyond repair is made again by `damperlab store rebuild`",
            f"The catalogue is damaged: study {study_id} has {found}.",
        )
    )


def lost_files(noun: str, name: str, why: str, advice: str) -> Fault:
    """Make the fault for a design or a record whose files are not what was written."""
    found = f"{name}, whose files are lost or damaged ({why})"
    told = f"The files of {noun} {name} are lost or damaged: {why.rstrip('.')}."
    return Fault(noun, found, f"a {noun} whose files are complete", advice, told)
