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
    free = [name for name in FAVOURITES if name not in {*taken, x, y}]
    free.sort(key=lambda name: sizes[name] == 1)
    # where none is left the question is refused for naming a dimension twice
    free += FAVOURITES
    return x or free.pop(0), y or free.pop(0)
