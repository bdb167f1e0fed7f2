"""Format of the service's log: lines of text, or one JSON object per line for log collectors."""

import json
import logging
import re
import sys
from datetime import UTC, datetime
from typing import Literal

LogFormat = Literal["text", "json"]
_REQUEST = re.compile(r"\[([A-Za-z0-9._-]{1,64})\]$")
_WORKER = re.compile(r"\bworker (t(?:cp|ls)://\S+?)[:;,]?(?:\s|$)")
_BLOCK = re.compile(r"\bblock (\d+)\b")
_STUDY = re.compile(r"\bstudy ([0-9a-f]{12}(?:-\d+)?)\b")


class JsonLines(logging.Formatter):
    """Formats a log record as a JSON object. Ids of studies, blocks, workers and requests get separate keys."""

    def format(self, record: logging.LogRecord) -> str:
        """Return one line of the log."""
        message = record.getMessage()
        told = {
            "time": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": message,
        }
        for key, pattern in (("study", _STUDY), ("block", _BLOCK), ("worker", _WORKER)):
            if found := pattern.search(message):
                told[key] = found[1]
        if record.name == "damperlab.access" and (found := _REQUEST.search(message)):
            told["request"] = found[1]
        if record.exc_info:
            told["exception"] = self.formatException(record.exc_info)
        return json.dumps(told, ensure_ascii=False)


def start_logging(level: str, form: LogFormat) -> None:
    """Configure logging to standard error.

    Parameters
    ----------
    level : str
        Lowest level that is logged.
    form : {"text", "json"}
        Format of the lines.
    """
    handler = logging.StreamHandler(sys.stderr)
    text = logging.Formatter("%(asctime)s %(levelname)s %(name)s: %(message)s")
    handler.setFormatter(JsonLines() if form == "json" else text)
    logging.basicConfig(level=level.upper(), handlers=[handler])
