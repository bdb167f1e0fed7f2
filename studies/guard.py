"""Checks before validation: a document that is too large, too deep or malformed is refused quickly."""

from typing import Any, Literal

from damperlab.studies.faults import WHOLE, Fault, StudyFaults, counted, describe, path

MAX_DEPTH = 8
"""Largest number of nested lists and mappings; a study needs four levels."""

MAX_CONTAINERS = 500
"""Largest number of lists and mappings in one document."""

MAX_VALUES = 20_000
"""Largest number of values in all lists of one document; a longer axis is written as a range."""

MAX_KEYS = 100
"""Largest number of keys of one mapping."""


Kind = Literal["study", "specification"]
OTHER: dict[Kind, tuple[Kind, str]] = {
    "study": ("specification", "damperlab design"),
    "specification": ("study", "damperlab run"),
}
"""For each kind of document: the other kind, and the command for that other kind."""


class Repeated(dict[str, Any]):
    """A mapping that was written with repeated keys. The repeated keys are stored, so that they can be refused."""

    keys_repeated: tuple[str, ...] = ()


def mapping(pairs: list[tuple[Any, Any]]) -> dict[Any, Any]:
    """Return a mapping made from pairs of a key and a value. If keys are repeated, the mapping is a `Repeated`."""
    built = dict(pairs)
    if len(built) == len(pairs):
        return built
    seen: set[Any] = set()
    again: list[str] = []
    for key, _ in pairs:
        if key in seen:
            again.append(key)
        seen.add(key)
    repeated = Repeated(built)
    repeated.keys_repeated = tuple(dict.fromkeys(again))[:MAX_KEYS]
    return repeated


def repeated_keys(document: object) -> list[Fault]:
    """Find repeated keys anywhere in a document."""
    faults: list[Fault] = []
    pending: list[tuple[tuple[object, ...], Any]] = [((), document)]
    while pending:
        where, held = pending.pop()
        if isinstance(held, dict):
            faults.extend(_repeats(where, held))
            pending.extend(((*where, key), v) for key, v in held.items() if isinstance(v, dict | list))
        elif isinstance(held, list):
            pending.extend(((*where, i), v) for i, v in enumerate(held) if isinstance(v, dict | list))
    return faults


def refuse_the_other(document: object, wanted: Kind) -> None:
    """Refuse a specification in place of a study, or a study in place of a specification. The fault names the right
    command.

    Raises
    ------
    StudyFaults
        If the document has keys of the other kind of document, and no keys of the wanted kind.
    """
    keys = document.keys() if isinstance(document, dict) else ()
    is_study, is_specification = (
        ("axes" in keys or "physical" in keys),
        ("structure" in keys or "choose" in keys),
    )
    if is_study == is_specification or is_study == (wanted == "study"):
        return
    found, command = OTHER[wanted]
    told = f"This is a {found}, not a {wanted}."
    raise StudyFaults([Fault(WHOLE, f"a {found}", f"a {wanted}", f"compute it with `{command}`", told)])


def guard(document: object) -> tuple[dict[str, Any], list[Fault]]:
    """Check that a document is a mapping of bounded depth and size, and collect repeated keys.

    Returns
    -------
    document : dict
        The document itself, unchanged.
    faults : list of Fault
        A fault for each repeated key.

    Raises
    ------
    StudyFaults
        If the document is not a mapping, is too deep or too large, or has keys or values that are not plain data.
    """
    if not isinstance(document, dict):
        raise StudyFaults([_no_mapping(document)])
    faults: list[Fault] = []
    pending: list[tuple[tuple[object, ...], Any]] = [((), document)]
    containers = values = 0
    while pending:
        where, held = pending.pop()
        containers += 1
        if len(where) >= MAX_DEPTH:
            raise StudyFaults([_too_much(where, f"more than {MAX_DEPTH} levels of nesting", f"{MAX_DEPTH}")])
        if containers > MAX_CONTAINERS:
            found = f"more than {MAX_CONTAINERS} lists and mappings"
            raise StudyFaults([_too_much((), found, f"{MAX_CONTAINERS}")])
        if isinstance(held, dict):
            if len(held) > MAX_KEYS:
                raise StudyFaults(
                    [_too_much(where, f"a mapping of {counted(len(held), 'key')}", f"{MAX_KEYS}")]
                )
            faults.extend(_repeats(where, held))
            faults_of_entries = [
                fault for key, value in held.items() for fault in _oddities(where, key, value)
            ]
            if faults_of_entries:
                raise StudyFaults(faults_of_entries)
            pending.extend(
                ((*where, key), v) for key, v in held.items() if isinstance(v, dict | list | tuple)
            )
        else:
            values += len(held)
            if values > MAX_VALUES:
                found = f"more than {MAX_VALUES:,} values in lists"
                raise StudyFaults([_too_much(where, found, f"{MAX_VALUES:,}")])
            pending.extend(((*where, i), v) for i, v in enumerate(held) if isinstance(v, dict | list | tuple))
    return document, faults


def _oddities(where: tuple[object, ...], key: object, value: object) -> list[Fault]:
    """Find keys that are not printable text, and values that are not plain data."""
    if not isinstance(key, str) or not key.isprintable():
        return [
            Fault(
                path((*where, key)),
                f"{describe(key)} as a key",
                "keys of printable text",
                "remove it",
                f"{{field}} is not a valid key: keys must be printable text, not {describe(key)}.",
            )
        ]
    if value is not None and not isinstance(value, str | int | float | list | tuple | dict):
        return [
            Fault(
                path((*where, key)),
                describe(value),
                "plain data, as in JSON",
                "write it as a number, a text, a list or a mapping",
            )
        ]
    return []


def _repeats(where: tuple[object, ...], held: dict[str, Any]) -> list[Fault]:
    repeated = held.keys_repeated if isinstance(held, Repeated) else ()
    return [
        Fault(
            path((*where, key)),
            "the key more than once in one mapping",
            "each key once",
            "keep one of them",
            "{field} is given more than once.",
        )
        for key in repeated
    ]


def _no_mapping(document: object) -> Fault:
    return Fault(WHOLE, describe(document), "a mapping", "write keys and their values")


def _too_much(where: tuple[object, ...], found: str, limit: str) -> Fault:
    return Fault(
        path(where) or WHOLE,
        found,
        f"at most {limit}",
        "write long axes as {start, stop, num}, and nest no deeper than a study needs",
        f"{{field}} has {found}; at most {limit} are allowed.",
    )
