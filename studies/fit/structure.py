"""What is known of a prototype, read from a file that is written as a study is."""

from pathlib import Path
from typing import Any

from damperlab.studies.faults import Fault, StudyFaults, describe, printable
from damperlab.studies.text import MAX_BYTES, Format, load_text

FORMATS: dict[str, Format] = {".json": "json", ".yaml": "yaml", ".yml": "yaml"}


def read_structure(path: Path | str) -> dict[str, Any]:
    """Read what is known of a prototype from a ``.json``, ``.yaml`` or ``.yml`` file.

    Returns
    -------
    dict
        As it is written; `damperlab.studies.fit.question.make_question` judges it.

    Raises
    ------
    StudyFaults
        Where the file cannot be read or breaks the rules of its format.
    """
    path = Path(path)
    written_in = FORMATS.get(path.suffix.lower())
    if written_in is None:
        told = f"The file {printable(path.name)} has no known ending; allowed are .json, .yaml and .yml."
        raise StudyFaults(
            [Fault("structure", describe(path.name), "a .json or .yaml file", "rename it", told)]
        )
    try:
        with path.open("rb") as file:
            text = file.read(MAX_BYTES[written_in] + 1)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else "not a path"
        told = f"The file {printable(str(path))} cannot be read: {reason}."
        raise StudyFaults(
            [Fault("structure", describe(str(path)), "a readable file", "check the path", told)]
        ) from None
    document = load_text(text, written_in)
    if not isinstance(document, dict):
        told = f"The file {printable(path.name)} holds no mapping."
        advice = "write names and values, as in a study"
        raise StudyFaults([Fault("structure", describe(document), "a mapping", advice, told)])
    return document
