"""A measured table: a response over frequency or a history over time, told apart by its heading."""

from pathlib import Path

from damperlab.studies.fit.history.history import History
from damperlab.studies.fit.history.table import is_history, parse_history
from damperlab.studies.fit.lines import lines_of, read_bytes
from damperlab.studies.fit.measured import Measurement, parse_measurement


def read_table(path: Path | str) -> Measurement | History:
    """Read a measured table from a file; raises StudyFaults with every fault of it."""
    return parse_table(read_bytes(path), Path(path).stem)


def parse_table(text: bytes | str, name: str = "measurement") -> Measurement | History:
    """Read a measured table: one with a column of time is a history."""
    if is_history(lines_of(text)):
        return parse_history(text, name)
    return parse_measurement(text, name)
