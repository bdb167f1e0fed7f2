"""How much of one kind is kept beside the studies: ground-motion records, designs."""

from collections.abc import Sequence
from dataclasses import dataclass

from damperlab.studies.faults import Fault, counted
from damperlab.studies.store.provenance import submitter


@dataclass(frozen=True)
class KeptQuota:
    """The most that is kept of one kind; None for any number.

    Parameters
    ----------
    together : int, optional
        Of everybody.
    of_owner : int, optional
        Of each owner of keys.
    """

    together: int | None = 1000
    of_owner: int | None = None

    def reached(self, what: str, owners: Sequence[str | None]) -> Fault | None:
        """Say why the submitter may keep no further one; None where he may.

        Parameters
        ----------
        what : str
            The kind, in the singular, as addresses and settings have it.
        owners : sequence of str or None
            Whose those are that are kept.
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
"""The default."""
