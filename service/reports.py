"""The latest accuracy report of a data directory."""

import json
import os
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import Any, NotRequired

from typing_extensions import TypedDict

NAME = "accuracy.json"


class AccuracyReport(TypedDict):
    """A report, from `damperlab.worker.accuracy.report`."""

    created: str
    version: str
    diagrams: list[dict[str, Any]]
    stability: list[dict[str, Any]]
    passed: bool


class AboutReport(TypedDict):
    """Time and version of a report, and whether it passed."""

    created: NotRequired[str]
    version: NotRequired[str]
    passed: bool


class AccuracyReports(TypedDict):
    """The available reports."""

    reports: list[AboutReport]


def keep_report(data_dir: Path, report: dict[str, Any]) -> Path:
    """Store a report, replacing the previous one; a reader sees one of them completely.

    Parameters
    ----------
    data_dir : Path
        Created if it is missing.
    report : dict
        JSON-able.

    Returns
    -------
    Path
        Where it is.
    """
    data_dir.mkdir(parents=True, exist_ok=True)
    target = data_dir / NAME
    with NamedTemporaryFile("w", encoding="utf-8", dir=data_dir, suffix=".json", delete=False) as file:
        json.dump(report, file, ensure_ascii=False, allow_nan=False)
        file.flush()
        os.fsync(file.fileno())
    Path(file.name).replace(target)
    return target


def last_report(data_dir: Path) -> dict[str, Any] | None:
    """The latest report; None if there is none, or the file is not a report."""
    try:
        report = json.loads((data_dir / NAME).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return report if isinstance(report, dict) else None
