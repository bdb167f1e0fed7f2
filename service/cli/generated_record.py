"""Options that generate a ground-motion record, and the document that these options describe."""

from typing import Annotated, Any

import typer

PANEL = "A generated record, in place of the argument"

Generate = Annotated[
    int | None,
    typer.Option(
        "--kanai-tajimi",
        metavar="SEED",
        rich_help_panel=PANEL,
        help="Generate an artificial (Kanai–Tajimi) record from this seed.",
    ),
]
Duration = Annotated[
    float | None,
    typer.Option(metavar="SECONDS", rich_help_panel=PANEL, help="Duration of the artificial record."),
]
PeakG = Annotated[
    float | None,
    typer.Option(metavar="G", rich_help_panel=PANEL, help="Peak acceleration of the artificial record."),
]
Written = Annotated[
    str | None,
    typer.Option(
        "--generate",
        metavar="YAML",
        rich_help_panel=PANEL,
        help="Generate a sweep, random_vibration or shock. Write it as in a study, for example '{shock: "
        "{shape: half_sine, peak_g: 15, duration_ms: 11}}', or name a file that contains it.",
    ),
]

RECIPE_OPTIONS = {
    "kanai_tajimi.seed": "--kanai-tajimi",
    "kanai_tajimi.duration_s": "--duration-s",
    "kanai_tajimi.peak_g": "--peak-g",
}
"""Command-line option for each field of a generated record."""


def recipe_of(
    seed: int | None, duration_s: float | None, peak_g: float | None, written: str | None
) -> dict[str, Any] | None:
    """Return the document that defines a generated record; None if no option generates a record.

    Raises
    ------
    typer.BadParameter
        If options exclude each other, or the document does not define a record.
    StudyFaults
        If the document is not YAML.
    """
    for option, value in (("--duration-s", duration_s), ("--peak-g", peak_g)):
        if seed is None and value is not None:
            message = f"found {value:g}, allowed: only with --kanai-tajimi; leave it out, or name a seed"
            raise typer.BadParameter(message, param_hint=option)
    if seed is not None and written is not None:
        raise typer.BadParameter("--kanai-tajimi and --generate cannot be combined. Leave one of them out.")
    if written is not None:
        return _read(written)
    if seed is None:
        return None
    given = {"seed": seed, "duration_s": duration_s, "peak_g": peak_g}
    return {"kanai_tajimi": {key: value for key, value in given.items() if value is not None}}


def _read(written: str) -> dict[str, Any]:
    from damperlab.studies.ground.generated import WRITTEN, recipe_in
    from damperlab.studies.text import is_file, load_text, read_file

    document = load_text(*read_file(written, "record")) if is_file(written) else load_text(written, "yaml")
    if not isinstance(document, dict) or len(document) != 1 or not recipe_in(document):
        raise typer.BadParameter(f"found {written!r}, allowed: {WRITTEN}", param_hint="--generate")
    return document
