"""Contact times, friction ratios and base amplitudes that the paper may have meant."""

from damperlab.studies.paper import paper_numbers
from damperlab.studies.presets import CONTACT_TIMES

INSTANT, PRINTED, REAL = "instant", "dwell, 0.411 s", "dwell, 20.55 ms"
SOFT: dict[str, dict[str, object]] = {
    INSTANT: {"model": "instant"},
    PRINTED: {"model": "dwell", "contact_time": "paper_soft_printed"},
    REAL: {"model": "dwell", "contact_time": "paper_soft_real"},
}
"""Contact models of the foam cushion by name: without contact time, with the printed contact time, and with the printed
contact time converted from slow motion to real time.
"""
HARD: dict[str, dict[str, object]] = {
    INSTANT: {"model": "instant"},
    PRINTED: {"model": "dwell", "contact_time": "paper_hard_printed"},
    REAL: {"model": "dwell", "contact_time": "paper_hard_real"},
}
"""Contact models of the aluminium wall, with the same names as in `SOFT`."""

LABELS = "labels of Figure 12"
FRICTION_RATIOS = (0.6, 0.69, 0.8)
"""Candidates for the friction ratio at a compression of 4 mm; the paper does not print this ratio."""
CHOSEN_FRICTION = 0.69
"""Friction ratio with which friction alone gives X/Z of about 16.22, as in Table 3."""


def clearances() -> dict[str, tuple[float, float, float]]:
    """Return d/Z of the three cavities by reading: the labels of Figure 12, or d/Z for the Z that one label implies."""
    known = paper_numbers()
    lengths = [known[f"clearance_{k}_mm"].value for k in (1, 2, 3)]
    labels = [known[f"clearance_ratio_{k}"].value for k in (1, 2, 3)]
    found = {LABELS: (labels[0], labels[1], labels[2])}
    for length, label in zip(lengths, labels, strict=True):
        amplitude = length / label
        first, second, third = (round(other / amplitude, 12) for other in lengths)
        found[f"Z = {amplitude:g} mm"] = (first, second, third)
    return found


def contacts_in_words() -> str:
    """Describe the contact models."""
    named = [f"`{name}` ({CONTACT_TIMES[name].doc})" for name in ("paper_soft_printed", "paper_soft_real")]
    return (
        "The paper adds contact times to all its simulations without saying how. Two models were tried: "
        "`instant`, without a contact time, and `dwell`, in which the particle moves with the wall for that time. "
        f"The contact times are {' and '.join(named)}."
    )
