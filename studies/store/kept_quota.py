"""Quota of the items that are stored beside the studies: ground-motion records and designs."""

from collections.abc import Sequence
from dataclasses import dataclass

from damperlab.studies.faults import counted
from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.provenance import submitter


@dataclass(frozen=True)
class KeptQuota:
    """Largest number of stored items of one kind, such as designs.

    Parameters
    ----------
    together : int, optional
        Largest number of items of all owners together; None for no limit.
    of_owner : int, optional
        Largest number of items of each owner; None for no limit.
    """

    together: int | None = 1000
    of_owner: int | None = None

    def require(self, what: str, owners: Sequence[str | None], full: type[StoreFault]) -> None:
        """Raise the error `full` if the submitter may not store another item.

        Parameters
        ----------
        what : str
            Kind of the items: `design` or `record`.
        owners : sequence of str or None
            Owner of each stored item.
        full : type
            Class of the error.
        """
        owner = submitter.get()
        for setting, count, most in (
            (f"quota_{what}s", len(owners), self.together),
            (f"key_quota_{what}s", owners.count(owner), None if owner is None else self.of_owner),
        ):
            if most is not None and count >= most:
                found = counted(count, what)
                advice = f"remove some with DELETE /api/v1/{what}s/{{id}}"
                told = f"{{field}} is reached: {found} of at most {most:,} are stored."
                raise full(setting, found, f"at most {most:,}", advice, told)


USUAL = KeptQuota()
"""The default quota."""
