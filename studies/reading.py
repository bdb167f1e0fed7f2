"""Reading studies: from text, from files, and the named studies of the package."""

from functools import cache
from importlib.resources import files
from itertools import takewhile
from pathlib import Path

from damperlab.studies.definition import Study, parse_harmonic, parse_study
from damperlab.studies.faults import Fault, StudyFaults, describe, listing, nearest, printable
from damperlab.studies.ground.shelf import Shelf
from damperlab.studies.ground.suite import Suite
from damperlab.studies.text import MAX_BYTES, Format, load_text

_FORMATS: dict[str, Format] = {".json": "json", ".yaml": "yaml", ".yml": "yaml"}


def parse_study_text(text: bytes | str, format: Format, shelf: Shelf | None = None) -> Study | Suite:
    """Read and validate a study.

    Parameters
    ----------
    text : bytes or str
        The study; bytes are UTF-8.
    format : {"json", "yaml"}
        How it is written.
    shelf : Shelf, optional
        Where a suite's records are looked up.

    Raises
    ------
    StudyFaults
        Where the text breaks the rules of its format, or with every fault of the study.
    """
    return parse_study(load_text(text, format, guarded=True), shelf)


def read_study(path_or_name: str, shelf: Shelf | None = None) -> Study | Suite:
    """Read a study from a ``.json``, ``.yaml`` or ``.yml`` file, or by the name of a named study.

    A suite's records are looked up on the shelf.

    Raises
    ------
    StudyFaults
        Where there is neither such a file nor such a name, or the study has faults.
    """
    path = Path(path_or_name)
    known = path.suffix.lower() in _FORMATS
    if not known and path_or_name in _named_files():
        return named_study(path_or_name)
    if not known:
        near = nearest(path_or_name, _named_files())
        advice = (
            f"did you mean {near}?"
            if near
            else (
                "name the file with its ending; a study that is stored already is shown by `damperlab show` and continued by "
                "`damperlab resume`, and `damperlab studies --named` describes the named ones"
            )
        )
        allowed = f"a {', '.join(_FORMATS)} file, or one of the named studies {listing(_named_files())}"
        told = f"{printable(path_or_name)} is neither a file nor a named study: name {allowed}."
        raise StudyFaults([Fault("study", describe(path_or_name), allowed, advice, told)])
    written_in = _FORMATS[path.suffix.lower()]
    try:
        with path.open("rb") as file:
            # One byte more than allowed is enough to be refused, however large the file is.
            text = file.read(MAX_BYTES[written_in] + 1)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else "not a path"
        found = f"{describe(path_or_name)} ({reason})"
        told = f"The file {printable(path_or_name)} cannot be read: {reason}."
        raise StudyFaults([Fault("study", found, "a readable file", "check the path", told)]) from None
    return parse_study_text(text, written_in, shelf)


def named_study(name: str) -> Study:
    """Return one named study.

    Raises
    ------
    KeyError
        Where there is none of that name.
    """
    return parse_harmonic(load_text(_named_files()[name], "yaml"))


def named_studies() -> dict[str, Study]:
    """Return the named studies of the package: the scenes of the paper, by name."""
    return {name: named_study(name) for name in _named_files()}


def named_texts() -> dict[str, bytes]:
    """Return the named studies as they were written: YAML in UTF-8 with comments, by name."""
    return dict(_named_files())


def named_descriptions() -> dict[str, str]:
    """Return what each named study is and what to look at in it: the first paragraph above its definition."""
    found = {}
    for name, text in _named_files().items():
        lines = takewhile(lambda line: line.startswith("# "), text.decode("utf-8").splitlines())
        found[name] = " ".join(line.removeprefix("# ") for line in lines)
    return found


@cache
def _named_files() -> dict[str, bytes]:
    entries = sorted((files("damperlab.studies") / "catalog").iterdir(), key=lambda entry: entry.name)
    return {
        entry.name.removesuffix(".yaml"): entry.read_bytes()
        for entry in entries
        if entry.name.endswith(".yaml")
    }
