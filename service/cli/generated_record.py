"""Options that generate a ground-motion record, and the document that they make."""

from typing import Annotated, Any

import typer

Generate = Annotated[
    int | None,
    typer.Option(
        "--kanai-tajimi",
        metavar="SEED",
        help="Generate an artificial (Kanai–Tajimi) record from this seed in place of a file.",
    ),
]
Duration = Annotated[float | None, typer.Option(help="Duration of the artificial record, in seconds.")]
PeakG = Annotated[float | None, typer.Option(help="Peak acceleration of the artificial record, in g.")]
Swept = Annotated[
    str | None,
    typer.Option(
        "--sweep",
        metavar="KEY=NUMBER,…",
        help="Generate a swept sine of the base in place of a file, as in "
        "start_hz=6,stop_hz=10,rate_hz_per_s=0.2,base_amplitude_m=0.001.",
    ),
]

RECIPE_OPTIONS = {
    "kanai_tajimi.seed": "--kanai-tajimi",
    "kanai_tajimi.duration_s": "--duration-s",
    "kanai_tajimi.peak_g": "--peak-g",
}
"""Fields of a generated record as options."""


def recipe_of(
    seed: int | None, duration_s: float | None, peak_g: float | None, sweep: str | None
) -> dict[str, Any] | None:
    """Give what the options generate a record from, as documents have it; None where they generate none.

    Raises
    ------
    typer.BadParameter
        Where options do not belong together, or a sweep is not made of keys and numbers.
    """
    for option, value in (("--duration-s", duration_s), ("--peak-g", peak_g)):
        if seed is None and value is not None:
            message = f"found {value:g}, allowed: only with --kanai-tajimi; leave it out, or name a seed"
            raise typer.BadParameter(message, param_hint=option)
    if seed is not None and sweep is not None:
        raise typer.BadParameter("--kanai-tajimi and --sweep cannot be combined. Leave one of them out.")
    if sweep is not None:
        return {"sweep": dict(_pair(part) for part in sweep.split(","))}
    if seed is None:
        return None
    given = {"seed": seed, "duration_s": duration_s, "peak_g": peak_g}
    return {"kanai_tajimi": {key: value for key, value in given.items() if value is not None}}


def _pair(part: str) -> tuple[str, float]:
    key, _, number = part.partition("=")
    try:
        return key.strip(), float(number)
    except ValueError:
        message = f"found {part!r}, allowed: a key, an equals sign and a number, such as start_hz=6"
        raise typer.BadParameter(message, param_hint="--sweep") from None
