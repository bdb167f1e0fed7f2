"""The audit log: owner, request and answer of each change; one JSON document per line."""

import json
import logging
import os
import time
from datetime import UTC, datetime
from pathlib import Path

AUDIT_FILE = "audit.jsonl"
"""Its file in the data directory."""

_log = logging.getLogger("damperlab.audit")


class Audit:
    """Writes the audit log; the file is opened for each line, so that it may be moved away at any time.

    Parameters
    ----------
    path : Path
        The file; created with mode 0600 if it is missing.
    """

    def __init__(self, path: Path) -> None:
        self._path = path

    def note(self, **facts: object) -> None:
        """Add a line. If it cannot be written, the service's log says so, and requests continue."""
        at = datetime.fromtimestamp(time.time(), UTC).isoformat(timespec="milliseconds")
        line = json.dumps({"at": at, **facts}) + "\n"
        try:
            file = os.open(self._path, os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC, 0o600)
            try:
                os.write(file, line.encode())
            finally:
                os.close(file)
        except OSError as error:
            _log.error("the audit log cannot be written: %s; it would say %s", error, line.strip())
