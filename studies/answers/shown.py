"""Which two dimensions a map shows where nobody says."""

from collections.abc import Collection, Mapping

FAVOURITES = (
    "clearance_ratio",
    "friction_ratio",
    "frequency_ratio",
    "mass_ratio",
    "restitution",
    "damping_ratio",
)
"""In this order, those with more than one value first."""

OF_SURVEYS = ("clearance_m", "friction_force_n", "scale", "particle_mass_kg", "natural_frequency_hz")
"""The same in a survey, before what both kinds of study have."""


def shown_axes(
    sizes: Mapping[str, int], x: str | None, y: str | None, taken: Collection[str | None]
) -> tuple[str, str]:
    """Fill in the axes that were not named with dimensions that vary and are not spoken for.

    Parameters
    ----------
    sizes : mapping of int
        Points along each dimension.
    x, y : str, optional
        What was named.
    taken : collection of str
        Dimensions that the question uses otherwise.
    """
    favourites = [name for name in (*OF_SURVEYS, *FAVOURITES) if name in sizes]
    free = [name for name in favourites if name not in {*taken, x, y}]
    free.sort(key=lambda name: sizes[name] == 1)
    # where none is left the question is refused for naming a dimension twice
    free += favourites
    return x or free.pop(0), y or free.pop(0)
