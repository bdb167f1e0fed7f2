"""The audit log. Each line is a JSON document with the owner, the request and the status of one change."""

import json
import logging
import os
import time
from datetime import UTC, datetime
from pathlib import Path

AUDIT_FILE = "audit.jsonl"
"""Name of the audit log in the data directory."""

_log = logging.getLogger("damperlab.audit")


class Audit:
    """Writes the audit log. The file is opened for each line, so an operator may move the file at any time.

    Parameters
    ----------
    path : Path
        The file of the log; created with mode 0600 if it is missing.
    """

    def __init__(self, path: Path) -> None:
        self._path = path

    def note(self, **facts: object) -> None:
        """Add a line to the audit log. If the line cannot be written, report an error to the service's own log."""
        at = datetime.fromtimestamp(time.time(), UTC).isoformat(timespec="milliseconds")
        line = json.dumps({"at": at, **facts}) + "\n"
        try:
            file = os.open(self._path, os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC, 0o600)
            try:
                os.write(file, line.encode())
            finally:
                os.close(file)
        except OSError as error:
            _log.error("the audit log cannot be written: %s; the lost line is %s", error, line.strip())
