"""Reading of the list of result variables in a study."""

from collections.abc import Collection

from damperlab.studies.faults import Fault, StudyFaults, describe, listing, nearest


def read_metrics(raw: object, variables: Collection[str], field: str = "") -> tuple[str, ...]:
    """Read a list of names of variables.

    Parameters
    ----------
    raw : object
        The value in the document.
    variables : collection of str
        Every allowed name, in the cube's order.
    field : str
        Path of `raw`, for the faults.

    Returns
    -------
    tuple of str
        Names in the order of the cube. `status` is always included, because it shows whether the other values are
        valid.

    Raises
    ------
    StudyFaults
        If the list has faults; the error lists every fault.
    """
    if not isinstance(raw, list | tuple) or not raw:
        allowed = "a list of at least one name of a result variable"
        advice = "leave `metrics` out to store every variable"
        raise StudyFaults([Fault(field, describe(raw), allowed, advice)])
    faults: list[Fault] = []
    seen: set[str] = set()
    for index, item in enumerate(raw[: 4 * len(variables)]):
        place = f"{field}[{index}]"
        if not isinstance(item, str) or item not in variables:
            near = nearest(item, variables) if isinstance(item, str) else None
            advice = f"write `{near}` if that is meant" if near else "write the name of a result variable"
            faults.append(Fault(place, describe(item), f"one of {listing(variables)}", advice))
        elif item in seen:
            told = f"{{field}} names {item} a second time."
            faults.append(
                Fault(place, f"{item} a second time", "each name once", "remove one of the two", told)
            )
        else:
            seen.add(item)
    if len(raw) > len(variables):
        allowed = f"at most the {len(variables)} result variables"
        told = f"{{field}} has {len(raw):,} entries; there are {len(variables)} result variables."
        faults.append(Fault(field, describe(raw), allowed, "leave `metrics` out to store all", told))
    if faults:
        raise StudyFaults(faults)
    return tuple(name for name in variables if name in seen or name == "status")
