"""Quota of items stored with the studies: ground-motion records, designs."""

from collections.abc import Sequence
from dataclasses import dataclass

from damperlab.studies.faults import Fault, counted
from damperlab.studies.store.provenance import submitter


@dataclass(frozen=True)
class KeptQuota:
    """Largest number of items of one kind; None for no limit.

    Parameters
    ----------
    together : int, optional
        For all owners together.
    of_owner : int, optional
        For each owner of keys.
    """

    together: int | None = 1000
    of_owner: int | None = None

    def reached(self, what: str, owners: Sequence[str | None]) -> Fault | None:
        """Give the reason why the submitter may store no more; None if more are allowed.

        Parameters
        ----------
        what : str
            The kind, in the singular, as in addresses and settings.
        owners : sequence of str or None
            Owners of the stored items.
        """
        owner = submitter.get()
        his = None if owner is None else self.of_owner
        for setting, count, most in (
            (f"quota_{what}s", len(owners), self.together),
            (f"key_quota_{what}s", owners.count(owner), his),
        ):
            if most is not None and count >= most:
                found = counted(count, what)
                advice = f"remove some with DELETE /api/v1/{what}s/{{id}}"
                told = f"{{field}} is reached: {found} of at most {most:,} are stored."
                return Fault(setting, found, f"at most {most:,}", advice, told)
        return None


USUAL = KeptQuota()
"""The default quota."""
