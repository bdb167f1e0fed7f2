"""What the schema of a study has but this version cannot compute yet: the one place that knows."""

RESERVED: dict[str, tuple[str, ...]] = {
    "contact": ("compliant",),
    "solver": ("rk4",),
    "start": (),
}
"""Choices that are refused, by field; whoever teaches the solver one of them deletes it here."""
