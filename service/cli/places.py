"""Options for output files and folders. A path is checked when the option is read, before anything is computed."""

import os
import tempfile
from pathlib import Path
from typing import Any

import typer

from damperlab.service.cli.failures import UsageFault
from damperlab.studies.faults import Fault

IN_A_FOLDER = "a file in a folder that can be written"
A_FOLDER = "a folder that can be written"


def file_option(*spellings: str, help: str, metavar: str = "FILE", **more: Any) -> Any:
    """Return an option for an output file. A file that cannot be written is refused."""
    return typer.Option(*spellings, metavar=metavar, help=help, callback=_check_file, **more)


def folder_option(*spellings: str, help: str) -> Any:
    """Return an option for an output folder. A folder in which no file can be written is refused."""
    return typer.Option(*spellings, metavar="DIR", help=help, callback=_check_folder)


def _check_file(param: typer.CallbackParam, value: Path | None) -> Path | None:
    if value is not None:
        _refuse("file", value, IN_A_FOLDER, _why_no_file(value), param)
    return value


def _check_folder(param: typer.CallbackParam, value: Path | None) -> Path | None:
    if value is not None:
        _refuse("folder", value, A_FOLDER, _why_no_files_in(value), param)
    return value


def _refuse(what: str, value: Path, allowed: str, why: str, param: typer.CallbackParam) -> None:
    """Refuse a path for the reason `why`; nothing is refused if `why` is empty."""
    if why:
        advice = f"name another {what} with {param.opts[0]}"
        told = f"The {what} {value} cannot be written: {why}."
        raise UsageFault(Fault(param.opts[0], str(value), allowed, advice, told))


def _why_no_file(path: Path) -> str:
    """Return the reason why a file cannot be written; the text is empty if the file can be written."""
    if path.is_dir():
        return "it is a folder"
    if path.exists() and not os.access(path, os.W_OK):
        return "its permissions forbid it"
    return _why_no_files_in(path.parent)


def _why_no_files_in(folder: Path) -> str:
    """Return the reason why no file can be created in a folder; the text is empty if a file can be created."""
    while not folder.exists():
        folder = folder.parent
    if not folder.is_dir():
        return f"{folder} is a file"
    try:
        # A check of permissions is not sufficient: on a read-only or special file system even root cannot write.
        with tempfile.TemporaryFile(dir=folder):
            return ""
    except OSError as error:
        return f"no file can be made in the folder {folder} ({(error.strerror or str(error)).lower()})"
