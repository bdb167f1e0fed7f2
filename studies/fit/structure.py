"""What is known of a prototype, read from a file that is written as a study is."""

from pathlib import Path
from typing import Any

from damperlab.studies.faults import Fault, StudyFaults, describe, printable
from damperlab.studies.text import load_text, read_file


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
    document = load_text(*read_file(path, "structure"))
    if not isinstance(document, dict):
        told = f"The file {printable(str(path))} holds no mapping."
        advice = "write names and values, as in a study"
        raise StudyFaults([Fault("structure", describe(document), "a mapping", advice, told)])
    return document
