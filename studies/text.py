"""Reading of JSON and YAML as plain data, in bounded time. Repeated keys, aliases and tags are refused."""

import json
import math
import re
from collections.abc import Container, Iterable
from pathlib import Path
from typing import Any, Literal

import yaml

from damperlab.studies.faults import WHOLE, Fault, StudyFaults, describe, listing, nearest, printable
from damperlab.studies.guard import MAX_CONTAINERS, MAX_DEPTH, MAX_VALUES, OTHER, Kind, mapping, repeated_keys

Format = Literal["json", "yaml"]

FORMATS: dict[str, Format] = {".json": "json", ".yaml": "yaml", ".yml": "yaml"}
"""Format of a file, by its suffix."""

MAX_BYTES: dict[Format, int] = {"json": 4 * 1024 * 1024, "yaml": 32 * 1024}
"""Largest size of a document in bytes. Reading YAML takes about a hundred times as long as reading JSON."""

MOST_STUDIES = 200
"""Largest number of studies in one list."""

MAX_YAML_VALUES = 6000
"""Largest number of texts, numbers, lists and mappings in a YAML document. Longer documents must be JSON."""

_NULL = re.compile(r"(?:null|Null|NULL|~|)\Z")
_TRUE = re.compile(r"(?:true|True|TRUE)\Z")
_FALSE = re.compile(r"(?:false|False|FALSE)\Z")
_INTEGER = re.compile(r"[-+]?[0-9]+\Z")
_FLOAT = re.compile(r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?\Z")
_INFINITE = re.compile(r"([-+]?)\.(?:inf|Inf|INF)\Z")
_NAN = re.compile(r"\.(?:nan|NaN|NAN)\Z")
_PLAIN_DIGITS = 400
"""Largest number of digits of an integer. Longer whole numbers are read as floats, which is much faster."""

_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def is_file(path_or_name: str) -> bool:
    """Return whether a text has the suffix of a document file or is the path of an existing file."""
    return Path(path_or_name).suffix.lower() in FORMATS or Path(path_or_name).is_file()


def read_file(path: Path | str, what: str) -> tuple[bytes, Format]:
    """Read the text of a file, at most one byte more than `load_text` accepts.

    Parameters
    ----------
    path : Path or str
        A ``.json``, ``.yaml`` or ``.yml`` file.
    what : str
        One word for the expected content, for example ``study``. Error messages use the word as the field.

    Raises
    ------
    StudyFaults
        If the file has another suffix, cannot be read, is empty, or is binary.
    """
    shown = printable(str(path))
    written_in = FORMATS.get(Path(path).suffix.lower())
    allowed = "a .json, .yaml or .yml file"
    if written_in is None:
        found, advice = describe(str(path)), f"name the file of a {what}"
        told = f"The file {shown} is no {what}: a {what} is {allowed}."
        raise StudyFaults([Fault(what, found, allowed, advice, told)])
    try:
        with Path(path).open("rb") as file:
            text = file.read(MAX_BYTES[written_in] + 1)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else "not a path"
        found, told = f"{describe(str(path))} ({reason})", f"The file {shown} cannot be read: {reason}."
        raise StudyFaults([Fault(what, found, "a readable file", "check the path", told)]) from None
    wrong = "empty" if not text.strip() else "binary, not text" if b"\0" in text else ""
    if wrong:
        told, advice = f"The file {shown} is {wrong}.", f"name the file of a {what}"
        raise StudyFaults([Fault(what, f"a file that is {wrong}", allowed, advice, told)])
    return text, written_in


def load_text(text: bytes | str, written_in: Format, *, guarded: bool = False) -> Any:
    """Read a document.

    YAML is read by the core schema of YAML 1.2: ``1e-4`` is a number, and ``yes`` and dates are texts.

    Parameters
    ----------
    text : bytes or str
        The document; bytes are UTF-8, with or without a byte order mark.
    written_in : {"json", "yaml"}
        Format of the text.
    guarded : bool
        Whether `damperlab.studies.guard.guard` checks the document afterwards. The guard then reports repeated keys
        together with other faults.

    Raises
    ------
    StudyFaults
        If the text is too large, is not UTF-8, is not valid in its format, or has repeated keys. A fault of
        the format names its line and column.
    """
    document = _load(text, written_in)
    if not guarded and (faults := repeated_keys(document)):
        raise StudyFaults(faults)
    return document


def unknown_name(name: str, wanted: Kind, named: Iterable[str], others: Container[str]) -> StudyFaults:
    """Return the fault of a text that is neither a file nor the name of a document of the package.

    If the text names a study in place of a specification, or the reverse, the fault names the right command.
    """
    allowed = f"a .json, .yaml or .yml file, or one of {listing(named)}"
    told = f"{printable(name)} is neither a file nor a named {wanted}: give {allowed}."
    near = nearest(name, named)
    stored = "; `damperlab studies` lists the stored studies" if wanted == "study" else ""
    advice = f"did you mean {near}?" if near else f"name the file with its ending{stored}"
    if name in others:
        other, command = OTHER[wanted]
        told = f"{name} is a named {other}, not a {wanted}."
        advice = f"run `{command} {name}`"
    return StudyFaults([Fault(wanted, describe(name), allowed, advice, told)])


def _load(text: bytes | str, written_in: Format) -> Any:
    limit = MAX_BYTES[written_in]
    if len(text) > limit:
        size = f"{len(text):,} {'bytes' if isinstance(text, bytes) else 'characters'}"
        told = f"The document has {size}; {written_in.upper()} may have at most {limit:,} bytes."
        raise _refused(size, f"at most {limit:,} bytes of {written_in.upper()}", _SHORTER, told)
    if isinstance(text, bytes):
        try:
            text = text.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            found = f"byte 0x{text[error.start]:02x} at offset {error.start}"
            told = f"The document is not UTF-8: {found} is not part of a valid character."
            raise _refused(found, "text in UTF-8", "save the document as UTF-8", told) from None
    if written_in == "yaml":
        return _load_yaml(text)
    return _load_json(text, MOST_STUDIES if text.lstrip().startswith("[") else 1)


_CORRECT = "correct the text there"
_SHORTER = "write long axes as {start, stop, num}, and long lists as JSON"


def _refused(found: str, allowed: str, advice: str, told: str = "") -> StudyFaults:
    return StudyFaults([Fault(WHOLE, found, allowed, advice, told)])


def _load_json(text: str, studies: int) -> Any:
    # Counting characters is much faster than parsing, and the guard would refuse such a document later.
    most = 2 * studies
    if text.count("{") + text.count("[") > most * MAX_CONTAINERS or text.count(",") > most * MAX_VALUES:
        told = f"The document has far more values than a study needs; at most {MAX_VALUES:,} are allowed."
        raise _refused("far more values than a study needs", f"at most {MAX_VALUES:,} values", _SHORTER, told)
    try:
        return json.loads(text, object_pairs_hook=mapping, parse_int=_integer)
    except json.JSONDecodeError as error:
        found = f"at line {error.lineno}, column {error.colno}: {error.msg}"
        raise _refused(
            found, "a JSON document", _CORRECT, f"The document is not valid JSON {found}."
        ) from None
    except RecursionError:
        told = f"The document is nested more than {MAX_DEPTH} levels deep."
        found = "lists or mappings nested too deeply"
        raise _refused(found, f"{MAX_DEPTH} levels", "flatten it", told) from None


def _integer(digits: str) -> int | float:
    return int(digits) if len(digits) <= _PLAIN_DIGITS else float(digits)


def _load_yaml(text: str) -> Any:
    try:
        return _build(text)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        if mark and (fault := _tab(text, mark.line)):
            raise StudyFaults([fault]) from None
        at = f"at line {mark.line + 1}, column {mark.column + 1}: " if mark else ""
        told = f"The document is not valid YAML {at}{error.problem}."
        raise _refused(f"{at}{error.problem}", "a YAML document", _CORRECT, told) from None
    except (yaml.YAMLError, UnicodeEncodeError) as error:
        found = printable(str(error).splitlines()[0])
        told = f"The document holds characters that YAML does not allow: {found}."
        allowed = "a YAML document of printable characters"
        raise _refused(found, allowed, "remove these characters", told) from None


def _tab(text: str, line: int) -> Fault | None:
    """Return a fault if a tab indents the line, otherwise None.

    The parser does not report such a tab clearly.
    """
    written = text.splitlines()[: line + 1][-1:]
    indent = re.match(r"\s*", written[0]) if written else None
    if indent is None or "\t" not in indent[0]:
        return None
    place = f"line {line + 1}, column {indent[0].index(chr(9)) + 1}"
    told = f"The document is not valid YAML at {place}: a tab indents the line, and YAML allows only spaces there."
    return Fault(WHOLE, f"a tab at {place}", "spaces before a key", "write spaces in place of the tab", told)


class _Level:
    """A list or mapping that is being read. In the `items` of a mapping, keys and values alternate."""

    def __init__(self, is_mapping: bool) -> None:
        self.is_mapping = is_mapping
        self.items: list[Any] = []

    def close(self) -> Any:
        if not self.is_mapping:
            return self.items
        return mapping(list(zip(self.items[::2], self.items[1::2], strict=True)))


def _build(text: str) -> Any:
    """Build a document from the events of the parser, without recursion."""
    levels = [_Level(is_mapping=False)]
    values = 0
    for event in yaml.parse(text, Loader=_LOADER):
        here = levels[-1]
        values += isinstance(event, yaml.NodeEvent)
        if values > MAX_YAML_VALUES:
            told = f"The document has more than {MAX_YAML_VALUES:,} values, the limit for YAML."
            found = f"more than {MAX_YAML_VALUES:,} values"
            raise _refused(found, f"at most {MAX_YAML_VALUES:,} values in YAML", _SHORTER, told)
        if isinstance(event, yaml.AliasEvent):
            found = f"the alias {printable(event.anchor or '')}"
            raise _at(event, found, "no aliases", "write the value out", "aliases are not allowed")
        if isinstance(event, yaml.NodeEvent):
            is_key = here.is_mapping and len(here.items) % 2 == 0
            if is_key and not isinstance(event, yaml.ScalarEvent):
                raise _at(
                    event,
                    "a list or mapping as a key",
                    "texts as keys",
                    "write a plain key",
                    "a key must be a text",
                )
            tag = getattr(event, "tag", None)
            if tag not in (None, "!"):
                found = f"the tag {printable(tag)}"
                raise _at(event, found, "no tags", "write the plain value", "tags are not allowed")
        if isinstance(event, yaml.ScalarEvent):
            here.items.append(event.value if is_key or not event.implicit[0] else _scalar(event.value))
        elif isinstance(event, yaml.CollectionStartEvent):
            if len(levels) > MAX_DEPTH:
                found = "a list or mapping that is nested too deeply"
                rule = f"a document may be nested at most {MAX_DEPTH} levels deep"
                raise _at(event, found, f"{MAX_DEPTH} levels", "flatten it", rule)
            levels.append(_Level(isinstance(event, yaml.MappingStartEvent)))
        elif isinstance(event, yaml.CollectionEndEvent):
            levels.pop()
            levels[-1].items.append(here.close())
        elif isinstance(event, yaml.DocumentStartEvent) and here.items:
            advice = "remove the line `---` and what follows it"
            raise _at(event, "a second document", "one document", advice, "a file holds one document")
    documents = levels[0].items
    return documents[0] if documents else None


def _at(event: Any, found: str, allowed: str, advice: str, rule: str) -> StudyFaults:
    mark = event.start_mark
    place = f"line {mark.line + 1}, column {mark.column + 1}"
    told = f"There is {found} at {place}: {rule}."
    return _refused(f"at {place}: {found}", allowed, advice, told)


def _scalar(text: str) -> Any:
    """Return the value of a scalar written without quotes, by the YAML 1.2 core schema."""
    if _INTEGER.match(text):
        return _integer(text)
    if _FLOAT.match(text):
        return float(text)
    if _NULL.match(text):
        return None
    if _TRUE.match(text):
        return True
    if _FALSE.match(text):
        return False
    if found := _INFINITE.match(text):
        return -math.inf if found.group(1) == "-" else math.inf
    return math.nan if _NAN.match(text) else text
