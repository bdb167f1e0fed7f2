"""Arguments and options shared by several commands, and functions that read option values."""

from collections.abc import Iterable, Mapping
from contextlib import suppress
from datetime import datetime, time, timedelta
from pathlib import Path
from typing import Annotated, Any, get_args

import typer

from damperlab.service.cli.failures import UsageFault
from damperlab.service.cli.places import file_option
from damperlab.service.scheduler_address import FORM, is_address
from damperlab.studies.faults import Fault, describe, nearest
from damperlab.studies.presets import CONTACT_TIMES
from damperlab.studies.spelled_numbers import NUMBER_ALONE, QUOTED, number_advice
from damperlab.studies.vocabulary import (
    CONTACT_MODELS,
    PRIORITIES,
    BatchSystem,
    ContactModel,
)

PLACE = "Where to compute"
"""Heading of the cluster options in the help."""

DataDir = Annotated[
    Path | None,
    typer.Option(
        "--data-dir",
        metavar="DIR",
        help="Folder of the studies; by default DAMPERLAB_DATA_DIR, or ~/.local/share/damperlab.",
        show_default=False,
    ),
]

StoreAddress = Annotated[
    str | None,
    typer.Option(
        "--store",
        metavar="URL",
        help="Store the cubes at s3://BUCKET/PREFIX; by default at the address in DAMPERLAB_STORE, or in the data folder.",
        show_default=False,
    ),
]

QuotaBytes = Annotated[
    str | None,
    typer.Option(
        "--quota",
        metavar="SIZE",
        help="Largest total size of all studies, as in 50GB; by default DAMPERLAB_QUOTA_BYTES, or no limit.",
        show_default=False,
    ),
]

StudyId = Annotated[
    str,
    typer.Argument(
        metavar="ID",
        help="Id of a study, its first four digits, or its name.",
        show_default=False,
    ),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON document, and nothing else.")]
Details = Annotated[bool, typer.Option("--details", help="Print all details, not only the short answer.")]
Workers = Annotated[
    int | None,
    typer.Option(
        min=1,
        metavar="N",
        rich_help_panel=PLACE,
        help="Number of processes on this machine; one per core by default.",
    ),
]
Cluster = Annotated[
    BatchSystem | None,
    typer.Option(
        "--cluster",
        metavar="SYSTEM",
        rich_help_panel=PLACE,
        help="Use jobs of a batch system as workers, at most --workers (16 by default): "
        f"{', '.join(get_args(BatchSystem))}.",
        show_default=False,
    ),
]


def check_address(param: typer.CallbackParam, value: str | None) -> str | None:
    """Refuse a text that is not the address of a scheduler, because the command would wait in vain."""
    if value is not None and not is_address(value):
        field = param.opts[0] if param.opts[0].startswith("-") else str(param.metavar)
        raise UsageFault(
            Fault(field, describe(value), f"an address of the form {FORM}", "name the host and its port")
        )
    return value


Scheduler = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS",
        callback=check_address,
        rich_help_panel=PLACE,
        help="Use the workers of this Dask scheduler, tcp://HOST:8786.",
    ),
]
WAIT_SECONDS = 60.0
QUEUE_SECONDS = 86_400.0
"""Default of --wait with a batch system [s]."""
Wait = Annotated[
    float | None,
    typer.Option(
        "--wait",
        metavar="SECONDS",
        min=0.0,
        rich_help_panel=PLACE,
        help=f"Longest wait for a worker, in seconds; {WAIT_SECONDS:g} by default, {QUEUE_SECONDS:g} with --cluster.",
        show_default=False,
    ),
]
Budget = Annotated[
    float | None,
    typer.Option(
        "--budget",
        metavar="HOURS",
        min=0.0,
        help="Stop after this many core hours; `run ID` continues.",
        show_default=False,
    ),
]
Priority = Annotated[
    int,
    typer.Option(
        "--priority",
        min=PRIORITIES[0],
        max=PRIORITIES[1],
        metavar="N",
        help="The waiting study with the highest priority starts first.",
    ),
]
Until = Annotated[
    str | None,
    typer.Option(
        "--until",
        metavar="TIME",
        help="Start no block after this time, as in 06:30 or 2026-11-23T06:30; `run ID` continues.",
        show_default=False,
    ),
]
Output = Annotated[
    Path | None,
    file_option("--output", "-o", help="Write a .png, .svg, .pdf or .csv file instead of a table."),
]


Contact = Annotated[
    ContactModel,
    typer.Option(
        metavar="MODEL",
        help=f"Model of an impact: {', '.join(CONTACT_MODELS)}; the first by default.",
        show_default=False,
    ),
]
ContactTime = Annotated[
    str | None,
    typer.Option(metavar="TIME", help="Contact time, in units of 1/ω_n."),
]

CONTACT_OPTIONS = {
    "contact": "--contact",
    "contact.model": "--contact",
    "contact.contact_time": "--contact-time",
}
"""Command-line option for each field of a contact."""

FIGURES = (".png", ".svg", ".pdf", ".csv")
"""Formats of -o, by the suffix of the file."""


def contact_document(contact: ContactModel, written: str | None) -> dict[str, Any]:
    """Return the field `contact` of a document.

    A number is converted. Any other text is kept, because the validation of the study checks the field later.
    """
    if written is None:
        if contact != "instant":
            message = (
                f"--contact {contact} needs the duration of a contact. Add --contact-time TIME, in units "
                f"of 1/ω_n, as in --contact-time 0.1, or one of the times that the paper gives: {', '.join(CONTACT_TIMES)}."
            )
            raise typer.BadParameter(message, param_hint="--contact")
        return {}
    if contact == "instant":
        lasting = " or ".join(f"--contact {model}" for model in CONTACT_MODELS if model != contact)
        message = (
            f"found {written} without {lasting}. An instant contact takes no time: add --contact dwell, or "
            "leave --contact-time out."
        )
        raise typer.BadParameter(message, param_hint="--contact-time")
    try:
        return {"contact": {"model": contact, "contact_time": float(written)}}
    except ValueError:
        return {"contact": {"model": contact, "contact_time": written}}


def check_cluster(workers: int | None, scheduler: str | None, cluster: str | None = None) -> None:
    """Refuse a scheduler together with a number of workers or a batch system: a scheduler has its own workers."""
    if cluster is not None and scheduler is not None:
        raise typer.BadParameter(
            "--cluster and --scheduler cannot be combined: jobs of a batch system work for their own "
            "scheduler. Leave one of them out."
        )
    if workers is not None and scheduler is not None:
        raise typer.BadParameter(
            "--workers and --scheduler cannot be combined: a scheduler has its own workers. Leave one of "
            "them out."
        )


def read_time(text: str | None) -> datetime | None:
    """Read the value of --until: a date with a time, or a time of day within the next 24 hours.

    A time without a time zone is a local time of this machine.
    """
    if text is None:
        return None
    now = datetime.now().astimezone()
    with suppress(ValueError):
        # a time of day without a date means today or tomorrow
        alone = datetime.combine(now.date(), time.fromisoformat(text)).astimezone()
        return alone if alone > now else (alone.replace(tzinfo=None) + timedelta(days=1)).astimezone()
    try:
        found = datetime.fromisoformat(text).astimezone()
    except ValueError:
        message = f"found {text!r}, allowed: a time in the future, as in 06:30 or {now + timedelta(hours=8):%Y-%m-%dT%H:%M}"
        raise typer.BadParameter(message, param_hint="--until") from None
    if found <= now:
        message = f"found {text}, which is in the past; allowed: a time after {now:%Y-%m-%dT%H:%M}"
        raise typer.BadParameter(message, param_hint="--until")
    return found


def read_range(option: str, text: str) -> tuple[float, float]:
    """Read two numbers of an option, written as `lo,hi`."""
    parts = text.split(",")
    if len(parts) != 2:
        raise typer.BadParameter(f"found {text!r}, allowed: two numbers, lo,hi", param_hint=option)
    low, high = (read_number(option, part) for part in parts)
    if not low <= high:
        raise typer.BadParameter(f"found {text!r}, allowed: lo not above hi; swap them", param_hint=option)
    return low, high


def check_name(option: str, name: str | None, allowed: tuple[str, ...]) -> None:
    """Refuse a name that is not among `allowed`."""
    if name is not None and name not in allowed:
        near = nearest(name, allowed)
        meant = f"Did you mean {near}? " if near else ""
        raise typer.BadParameter(f"found {name!r}. {meant}Allowed: {', '.join(allowed)}.", param_hint=option)


def check_alone(options: Mapping[str, object], needed: str) -> None:
    """Refuse options that would have no effect.

    Parameters
    ----------
    options : mapping
        Value of each option. None, False, an empty text or an empty list means that the option was not given.
    needed : str
        What the options need to have an effect, as a phrase for the error message.
    """
    for option, value in options.items():
        if value:
            message = f"it has no effect without {needed}; leave it out"
            raise typer.BadParameter(message, param_hint=option)


def check_file(output: Path | None, suffixes: tuple[str, ...] = FIGURES) -> None:
    """Refuse a file of unknown format before anything is computed."""
    if output is not None and output.suffix not in suffixes:
        raise typer.BadParameter(
            f"found {output.name!r}, allowed: a name that ends in {', '.join(suffixes)}", param_hint="-o"
        )


def read_named(
    option: str,
    assignments: Iterable[str] | None,
    names: tuple[str, ...],
    form: str = "name=value",
) -> list[tuple[str, str]]:
    """Read the texts ``name=value`` of an option that may be repeated.

    A name that is not among `names`, or that is given twice, is refused.
    """
    pairs: dict[str, str] = {}
    for assignment in assignments or ():
        name, equals, text = assignment.partition("=")
        if not equals:
            raise typer.BadParameter(f"found {assignment!r}, allowed: {form}", param_hint=option)
        check_name(option, name, names)
        if name in pairs:
            raise typer.BadParameter(f"{name} is given twice. Leave one of them out.", param_hint=option)
        pairs[name] = text
    return list(pairs.items())


def read_number(option: str, text: str, allowed: str = "a finite number") -> float:
    """Read the value of an option as a finite number. The error message says which values are `allowed`."""
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not abs(value) < float("inf"):
        spelled = number_advice(text)
        advice = f"; {spelled}" if spelled not in (NUMBER_ALONE, QUOTED) else ""
        raise typer.BadParameter(f"found {text!r}, allowed: {allowed}{advice}", param_hint=option)
    return value
