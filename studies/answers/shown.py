"""Which two dimensions a map shows where nobody says."""

from collections.abc import Collection, Mapping

from damperlab.studies.kinds import kind_of


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
    favourites = [name for name in kind_of(sizes).axes if name in sizes]
    free = [name for name in favourites if name not in {*taken, x, y}]
    free.sort(key=lambda name: sizes[name] == 1)
    # where none is left the question is refused for naming a dimension twice
    free += favourites
    return x or free.pop(0), y or free.pop(0)
