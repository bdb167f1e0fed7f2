"""Query parameters and docstrings for the client's methods, made from the fields of questions."""

from collections.abc import Callable, Iterable, Mapping
from inspect import cleandoc
from typing import Any, Literal, TypeVar, get_args, get_origin

from damperlab.service.client.transport import Transport
from damperlab.studies.field import Field, Ranges, fields_of, given

Function = TypeVar("Function", bound=Callable[..., Any])


class Asked:
    """A study of a service, to which requests can be sent.

    Parameters
    ----------
    transport : Transport
        The connection to the service.
    id : str
        Id of the study.
    sizes : mapping of int
        Number of points along each dimension of the study.
    """

    def __init__(self, transport: Transport, id: str, sizes: Mapping[str, int]) -> None:
        self._transport = transport
        self.id = id
        self._sizes = dict(sizes)

    def _ask(self, method: str, path: str = "", **how: Any) -> Any:
        return self._transport.ask(method, f"/studies/{self.id}{path}", **how)


def values_of(kinds: Iterable[type], given: Mapping[str, Any]) -> list[Any]:
    """Make the inputs of a question from keyword arguments. A field without an argument has its default value."""
    found = []
    for kind in kinds:
        mine: dict[str, Any] = {}
        for each in fields_of(kind):
            if each.name not in given:
                continue
            value = given[each.name]
            if each.studies:
                named = () if value is None else ids(value)
                value = named if each.is_list else next(iter(named), None)
            elif each.is_list and value is not None:
                value = tuple(value)
            mine[each.name] = value
        found.append(kind(**mine))
    return found


def parameters(*questions: object) -> dict[str, Any]:
    """Return the query parameters for the inputs of a question; values equal to their defaults are omitted."""
    found: dict[str, Any] = {}
    for question in questions:
        kind: Any = type(question)
        fields = {each.name: each for each in fields_of(kind)}
        for name, value in given(question).items():
            found |= value if fields[name].is_named else {fields[name].key: value}
    return found


def ids(studies: "Asked | str | Iterable[Asked | str]") -> tuple[str, ...]:
    """Return the ids of one or several studies."""
    several = [studies] if isinstance(studies, Asked | str) else studies
    return tuple(each.id if isinstance(each, Asked) else each for each in several)


def explained(*questions: type) -> Callable[[Function], Function]:
    """Make a decorator that adds the section Parameters to the docstring of a method.

    Parameters
    ----------
    *questions : type
        Types whose fields are the parameters of the method. The section is inserted before the section Returns.
    """
    fields = [each for question in questions for each in fields_of(question) if "client" in each.doors]
    entries = [entry(each) for each in sorted(fields, key=lambda each: each.is_named)]

    def explain(function: Function) -> Function:
        summary, heading, rest = cleandoc(function.__doc__ or "").partition("Returns\n---")
        section = "\n".join(["Parameters", "----------", *entries])
        function.__doc__ = f"{summary}{section}\n\n{heading}{rest}"
        return function

    return explain


def entry(field: Field) -> str:
    """Write one field as an entry of the section Parameters."""
    name = f"**{field.name}" if field.is_named else field.name
    optional = ", optional" if field.default is None else ""
    return f"{name} : {_type(field)}{optional}\n    {field.help}"


def _type(field: Field) -> str:
    if field.is_named:
        return "(float, float)" if field.core == Ranges else "float or str"
    if field.is_range:
        return "(float, float)"
    if field.is_list:
        return "iterable of str"
    if get_origin(field.core) is Literal:
        return "{" + ", ".join(f'"{name}"' for name in get_args(field.core)) + "}"
    return str(field.core.__name__)
