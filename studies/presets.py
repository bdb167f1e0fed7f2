"""Contact times measured in the paper, by name.

Each contact time has two values: the printed value, and a value that is 20 times shorter. The shorter value is correct
if the printed times were measured in a slow-motion film.
"""

from dataclasses import dataclass
from math import pi

NATURAL_FREQUENCY_HZ = 2.5
"""Natural frequency of the structure in the paper, for conversion of the contact times into units of 1/ω_n."""
SLOW_MOTION = 20.0
"""Slow-motion factor of the film from which the contact times may have been read."""


@dataclass(frozen=True)
class ContactTime:
    """A contact time that the paper uses.

    Parameters
    ----------
    seconds : float
        Contact time [s].
    doc : str
        Source of the contact time.
    """

    seconds: float
    doc: str

    @property
    def contact_time(self) -> float:
        """Contact time in units of 1/ω_n, for the natural frequency of the paper, 2.5 Hz."""
        return 2.0 * pi * NATURAL_FREQUENCY_HZ * self.seconds


_HARD_S = 0.046
_SOFT_S = 0.411

CONTACT_TIMES: dict[str, ContactTime] = {
    "paper_hard_printed": ContactTime(_HARD_S, "steel on aluminium, e = 0.82: 0.046 s as printed"),
    "paper_soft_printed": ContactTime(
        _SOFT_S, "steel on foam, e = 0.47: 0.411 s as printed, longer than the natural period of 0.4 s"
    ),
    "paper_hard_real": ContactTime(_HARD_S / SLOW_MOTION, "2.3 ms, if 0.046 s was read off slow motion"),
    "paper_soft_real": ContactTime(_SOFT_S / SLOW_MOTION, "20.55 ms, if 0.411 s was read off slow motion"),
}
"""Contact times from Table 1 of the paper. A study may contain the name instead of a number."""
