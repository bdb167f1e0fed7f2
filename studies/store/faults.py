"""Errors of the store, with messages for users."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TypeVar

from damperlab.studies.faults import Fault, sentence
from damperlab.studies.store.files.shelf import Shelf, ShelfAway
from damperlab.studies.user_error import UserError


class StoreFault(UserError):
    """An error whose message tells the user how to correct the problem. The parameters are those of `Fault`."""

    def __init__(self, field: str, found: str, allowed: str, advice: str, message: str = "") -> None:
        # pass the arguments, and not the message, to Exception, so that a worker process can pickle the error
        super().__init__(field, found, allowed, advice, message)
        self.fault = Fault(field, found, allowed, advice, message)

    def __str__(self) -> str:
        """Describe the error, the allowed values, and the remedy."""
        return str(self.fault)


Kind = TypeVar("Kind", bound=StoreFault)


class StudyNotFound(StoreFault):
    """No study or several studies have the given name or id."""


class StudyBusy(StoreFault):
    """A process works on the study, so the request is refused until this work has ended."""


class NothingToDo(StoreFault):
    """The request is not possible in the present state of the study, or would have no effect."""


class RevisionGone(StoreFault):
    """The cube is not available at the requested revision."""


class StoreAway(StoreFault):
    """The store cannot be reached or denies access, so the state of the data is unknown."""


class CatalogueDamaged(StoreFault):
    """The catalogue's entry of a study is damaged."""


class BlockDamaged(StoreFault):
    """Stored data of a study are lost or damaged: a block with a done-mark, or a cube's description."""


class QuotaReached(StoreFault):
    """A new study would exceed the quota."""


class TooManyUnfinished(QuotaReached):
    """The limit of waiting and running studies is reached."""


def may_pass(error: StoreFault) -> bool:
    """Whether an error may disappear by itself, for example after a server restarts or a lock is released."""
    return type(error) in (StoreFault, StoreAway)


def cannot_use(place: str, error: OSError) -> StoreFault:
    """Return the `StoreFault` for an OSError that occurred while files of the store were read or written."""
    away = isinstance(error, (ShelfAway, PermissionError))
    return (StoreAway if away else StoreFault)(
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


@contextmanager
def using(place: str) -> Iterator[None]:
    """Convert an error of a disk or an object store to a `StoreFault`."""
    try:
        yield
    except OSError as error:
        raise cannot_use(place, error) from error


def catalogue_damaged(study_id: str, found: str, advice: str = "") -> CatalogueDamaged:
    """Return the error for a study whose rows in the catalogue are damaged."""
    return CatalogueDamaged(
        f"study {study_id}",
        f"{found} in the catalogue",
        "the rows as they were written",
        advice
        or f"list the damage with `damperlab store verify {study_id}`, and repair the study with "
        f"`damperlab store verify {study_id} --repair`; if that fails, make the catalogue again with "
        "`damperlab store rebuild`",
        f"The catalogue is damaged: study {study_id} has {found}.",
    )


def damaged(shelf: Shelf, index: int | None, what: str, found: str) -> BlockDamaged:
    """Return the error for lost or damaged data. `index` is None if `what` is not part of a block."""
    study_id = shelf.name.removesuffix(".zarr").rpartition("-")[0]
    where = f"{'' if index is None else f'block {index} of '}study {study_id}"
    return BlockDamaged(
        where,
        f"{what}: {found}",
        "what was written",
        f"list all damage with `damperlab store verify {study_id}`, and repair the study with `damperlab store verify "
        f"--repair {study_id}`: descriptions are written again, lost blocks are computed again",
        sentence(f"{where} cannot be read: {what}: {found}"),
    )


@contextmanager
def reporting_damage(
    shelf: Shelf, index: int | None, what: str, lost: str = "its file is lost"
) -> Iterator[None]:
    """Raise a `StoreFault` in place of an error that occurs while a cube is read.

    Raises
    ------
    BlockDamaged
        If the block, or another part of the cube, is missing or damaged.
    StoreFault
        If the disk or the server reports an error.
    """
    try:
        yield
    except FileNotFoundError as error:
        raise damaged(shelf, index, what, lost) from error
    except OSError as error:
        raise cannot_use(shelf.address, error) from error
    except (ValueError, RuntimeError) as error:
        raise damaged(shelf, index, what, str(error)) from error


def lost_files(kind: type[Kind], noun: str, name: str, why: str, advice: str) -> Kind:
    """Return the error for a design or a ground-motion record whose files are lost or damaged."""
    found = f"{name}, whose files are lost or damaged ({why})"
    told = f"The files of {noun} {name} are lost or damaged: {why.rstrip('.')}."
    return kind(noun, found, f"a {noun} whose files are complete", advice, told)
