"""Stores and reads the latest accuracy report in a data directory."""

import json
import os
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import Any, NotRequired

from typing_extensions import TypedDict

NAME = "accuracy.json"


class AccuracyReport(TypedDict):
    """An accuracy report, made by `damperlab.worker.accuracy.report`."""

    created: str
    version: str
    diagrams: list[dict[str, Any]]
    stability: list[dict[str, Any]]
    passed: bool


class AboutReport(TypedDict):
    """Time and version of an accuracy report, and whether all checks passed."""

    created: NotRequired[str]
    version: NotRequired[str]
    passed: bool


class AccuracyReports(TypedDict):
    """List of the available accuracy reports."""

    reports: list[AboutReport]


def keep_report(data_dir: Path, report: dict[str, Any]) -> Path:
    """Store an accuracy report, and atomically replace the previous report.

    Parameters
    ----------
    data_dir : Path
        Data directory. A missing directory is created.
    report : dict
        The report, which must be representable as JSON.

    Returns
    -------
    Path
        Path of the stored report.
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
    """Return the latest accuracy report; None if there is no report, or the file cannot be read as a report."""
    try:
        report = json.loads((data_dir / NAME).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return report if isinstance(report, dict) else None
