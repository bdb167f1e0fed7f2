"""Reading of studies from texts and files, and of the named studies of the package."""

from itertools import takewhile

from damperlab.studies.definition import Study, parse_harmonic, parse_study
from damperlab.studies.ground.shelf import Shelf
from damperlab.studies.ground.suite import Suite
from damperlab.studies.named import named_specifications, named_texts
from damperlab.studies.text import Format, is_file, load_text, read_file, unknown_name


def parse_study_text(text: bytes | str, format: Format, shelf: Shelf | None = None) -> Study | Suite:
    """Read and validate a study.

    Parameters
    ----------
    text : bytes or str
        The study; bytes are UTF-8.
    format : {"json", "yaml"}
        Format of the text.
    shelf : Shelf, optional
        The store in which the records of a suite are looked up.

    Raises
    ------
    StudyFaults
        If the text is not valid in its format, or if the study has faults. The error lists all faults.
    """
    return parse_study(load_text(text, format, guarded=True), shelf)


def read_study(path_or_name: str, shelf: Shelf | None = None) -> Study | Suite:
    """Read a study from a ``.json``, ``.yaml`` or ``.yml`` file, or by the name of a named study.

    Parameters
    ----------
    path_or_name : str
        The file or the name.
    shelf : Shelf, optional
        The store in which the records of a suite are looked up.

    Raises
    ------
    StudyFaults
        If there is no such file or named study, or if the study has faults.

    Examples
    --------
    >>> read_study("figure-11").points
    1617
    """
    if path_or_name in named_texts():
        return named_study(path_or_name)
    if not is_file(path_or_name):
        raise unknown_name(path_or_name, "study", named_texts(), named_specifications())
    text, written_in = read_file(path_or_name, "study")
    return parse_study_text(text, written_in, shelf)


def is_known(path_or_name: str) -> bool:
    """Return whether a text is the name of a file, or of a study or specification of the package."""
    return path_or_name in named_texts() or is_file(path_or_name) or path_or_name in named_specifications()


def named_study(name: str) -> Study:
    """Return one named study.

    Raises
    ------
    KeyError
        If no study has that name.
    """
    return parse_harmonic(load_text(named_texts()[name], "yaml"))


def named_studies() -> dict[str, Study]:
    """Return the named studies of the package: the scenes of the paper, by name."""
    return {name: named_study(name) for name in named_texts()}


def named_descriptions() -> dict[str, str]:
    """Return the description of each named study, which is the first paragraph of comments in its file."""
    found = {}
    for name, text in named_texts().items():
        lines = takewhile(lambda line: line.startswith("# "), text.decode("utf-8").splitlines())
        found[name] = " ".join(line.removeprefix("# ") for line in lines)
    return found
