"""Commands for ground-motion records, and for the comparison of dampers under a record."""

from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from damperlab.service.cli.asked import Values, asks, names_a_design
from damperlab.service.cli.generated_record import (
    RECIPE_OPTIONS,
    Duration,
    Generate,
    PeakG,
    Written,
    recipe_of,
)
from damperlab.service.cli.options import (
    CONTACT_OPTIONS,
    AsJson,
    Contact,
    ContactTime,
    DataDir,
    Details,
    check_alone,
    check_file,
    contact_document,
)
from damperlab.service.cli.output import (
    make_parent,
    note,
    number,
    print_brief,
    print_json,
    print_table,
    say,
    two_digits,
    working,
)
from damperlab.service.cli.places import file_option
from damperlab.service.cli.spelled import in_options, options_of
from damperlab.service.cli.store import data_folder
from damperlab.service.cli.warm import have_ready
from damperlab.studies.field import given, option_of
from damperlab.studies.ground.quantities import QUANTITIES
from damperlab.studies.questions import Compared
from damperlab.studies.rounding import ROUNDING, ROUNDING_WORD

if TYPE_CHECKING:
    from damperlab.service.earthquakes import WithPaper

OPTIONS = (
    {name: option_of(name) for name in QUANTITIES}
    | options_of(Compared)
    | CONTACT_OPTIONS
    | RECIPE_OPTIONS
    | {"record": "RECORD"}
)
"""Command-line option for each field of a comparison."""

COLUMNS = (
    ("peak_relative_displacement_m", "peak x−z [mm]"),
    ("rms_relative_displacement_m", "rms x−z [mm]"),
    ("peak_absolute_displacement_m", "peak x [mm]"),
    ("peak_absolute_acceleration_m_s2", "peak x'' [m/s²]"),
    ("rms_absolute_acceleration_m_s2", "rms x'' [m/s²]"),
    ("impacts", "impacts"),
    ("impact_speed_max_m_s", "fastest [m/s]"),
    ("stick_fraction", "sticking"),
)


def records(
    file: Annotated[
        Path | None,
        typer.Argument(
            metavar="FILE",
            help="File to store: PEER .at2, or two columns (time, acceleration).",
            show_default=False,
        ),
    ] = None,
    units: Annotated[
        str | None,
        typer.Option(
            metavar="UNIT",
            help="Unit of the acceleration if the file states none, for example g, m/s2, gal or mg.",
        ),
    ] = None,
    name: Annotated[str, typer.Option(help="Name of the stored record.")] = "",
    seed: Generate = None,
    duration_s: Duration = None,
    peak_g: PeakG = None,
    generate: Written = None,
    data_dir: DataDir = None,
    as_json: AsJson = False,
) -> None:
    """List the ground-motion records, or store one."""
    from damperlab.studies.ground.motion import doubt_of
    from damperlab.studies.ground.shelf import Shelf

    recipe = recipe_of(seed, duration_s, peak_g, generate)
    if file is None:
        check_alone({"--units": units}, "FILE")
    if file is None and recipe is None:
        check_alone({"--name": name}, "FILE, --kanai-tajimi or --generate")
    shelf = Shelf(data_folder(data_dir))
    if file is None and recipe is None:
        listed = shelf.summaries()
        if as_json:
            print_json({"records": listed})
            return
        columns = ("id", "name", "step [s]", "duration [s]", "peak [g]", "peak displacement [mm]")
        print_table(
            columns,
            (
                (
                    one["id"],
                    one["name"],
                    number(one["step_s"]),
                    number(one["duration_s"], 4),
                    number(one["peak_acceleration_g"], 3),
                    number(_printed("peak_displacement_m", one["peak_displacement_m"]), 3),
                )
                for one in listed
            ),
        )
        return
    if file is not None and recipe is not None:
        raise typer.BadParameter(
            "A FILE cannot be combined with --kanai-tajimi or --generate. Leave one of them out."
        )
    with in_options(RECIPE_OPTIONS):
        motion = read_file(file, units, name) if file is not None else _generated(recipe or {}, name)
    record_id, new = shelf.put(motion)
    summary: dict[str, Any] = {"id": record_id, **motion.summary()}
    if as_json:
        print_json(summary)
        return
    known = "Stored" if new else f"Already stored with the name {shelf.summary(record_id)['name']}"
    say(
        f"{known}: {record_id}, {summary['samples']} samples at {motion.step_s:g} s, "
        f"peak {summary['peak_acceleration_g']:.3g} g."
    )
    if doubt := doubt_of(summary["peak_displacement_m"]):
        say(doubt)


@names_a_design(
    dict.fromkeys(QUANTITIES, ""),
    {name: quantity for name, (quantity, _) in QUANTITIES.items()},
    "Values that differ from the prototype's, as --at mass_kg=2 or --mass-kg 2: "
    + ", ".join(
        name if isnan(default) else f"{name} {default:g}" for name, (_, default) in QUANTITIES.items()
    )
    + ".",
)
@asks
def earthquake(
    design: Values,
    compared: Compared,
    record: Annotated[
        str, typer.Argument(metavar="RECORD", help="Name of an earthquake, id of a record, or a file.")
    ] = Compared.record,
    contact: Contact = "instant",
    contact_time: ContactTime = None,
    units: Annotated[
        str | None,
        typer.Option(
            metavar="UNIT",
            help="Unit of the acceleration if the file states none, for example g, m/s2, gal or mg.",
        ),
    ] = None,
    kanai_tajimi: Generate = None,
    duration_s: Duration = None,
    peak_g: PeakG = None,
    generate: Written = None,
    output: Annotated[
        Path | None,
        file_option(
            "--output",
            "-o",
            help="Write the histories as .png, .svg or .pdf, or the table as .csv.",
        ),
    ] = None,
    data_dir: DataDir = None,
    details: Details = False,
    as_json: AsJson = False,
) -> None:
    """Compare dampers under a ground-motion record.

    The cases are as in the paper's Table A1: no damper, a tuned mass damper, a particle, friction, and a particle with
    friction.
    """
    check_file(output)
    recipe = recipe_of(kanai_tajimi, duration_s, peak_g, generate)
    is_file = recipe is None and bool(Path(record).suffix)
    if not is_file:
        check_alone({"--units": units}, "a file as RECORD")
    if recipe is not None and record != Compared.record:
        raise typer.BadParameter(
            f"{record} and a generated record cannot be combined. Leave RECORD out, or --kanai-tajimi and --generate."
        )
    from damperlab.service.earthquakes import answer_comparison
    from damperlab.studies.ground.question import read_earthquake
    from damperlab.studies.ground.shelf import Shelf
    from damperlab.worker.ground.comparison import scenes_of

    shelf = Shelf(data_folder(data_dir))
    document: dict[str, Any] = {**design, **given(compared)}
    if compared.cases is not None:
        document["cases"] = list(compared.cases)
    document |= contact_document(contact, contact_time)
    if recipe is not None:
        document["record"] = recipe
    elif is_file:
        document["record"], _ = shelf.put(read_file(Path(record), units, ""))
    else:
        document["record"] = record
    with in_options(OPTIONS):
        asked = read_earthquake(document, shelf)
    have_ready(scenes_of(asked), apart=True)
    with working("Computing"):
        answer = answer_comparison(asked)
    if output is not None:
        if output.suffix == ".csv":
            _write_csv(answer, output)
        else:
            from damperlab.service.figures.earthquake import draw_earthquake
            from damperlab.service.figures.style import save

            with working("Drawing"):
                save(draw_earthquake(asked), make_parent(output))
        note(f"Wrote {output}.")
    if as_json:
        print_json(answer)
    elif output is None:
        print_brief(answer["brief"], (), details)
        if details:
            _print(answer)


def read_file(file: Path, units: str | None, name: str) -> Any:
    """Read a record from a file, in PEER's format if the suffix is .at2, otherwise as two columns."""
    from damperlab.studies.ground.files import read_record

    try:
        content = file.read_bytes()
    except OSError as error:
        raise typer.BadParameter(f"found {file}, which cannot be read ({error.strerror})") from None
    layout: Any = "at2" if file.suffix.lower() == ".at2" else "csv"
    return read_record(content, layout, name or file.stem, units)


def _generated(recipe: dict[str, Any], name: str) -> Any:
    from damperlab.studies.ground.generated import GENERATED

    ((way, values),) = recipe.items()
    return GENERATED[way](values | {"name": name} if name and isinstance(values, dict) else values)


def _write_csv(answer: "WithPaper", output: Path) -> None:
    with make_parent(output).open("w", encoding="utf-8") as file:
        names = [name for name in next(iter(answer["cases"].values())) if name not in ("label", "spread")]
        file.write(",".join(("damper", *names)) + "\n")
        for case, values in answer["cases"].items():
            file.write(",".join((case, *(repr(float(values[name])) for name in names))) + "\n")


def _contact_words(contact: dict[str, Any]) -> str:
    time = contact.get("contact_time")
    return "" if time is None else f"; contact {contact['model']}, {time:g}/ω_n"


def _printed(name: str, value: float) -> float:
    """Convert a quantity for printing. Lengths are converted to mm; other quantities stay in SI units."""
    return float(value) * (1e3 if name.endswith("_m") else 1.0)


def _print(answer: "WithPaper") -> None:
    from damperlab.studies.cavity import cavity_of

    record, design = answer["record"], answer["design"]
    say(
        f"{record['name']}: {record['duration_s']:.4g} s, peak {record['peak_acceleration_g']:.3g} g"
        f"{'' if design['scale'] == 1.0 else ', times ' + number(design['scale'])}."
    )
    say(
        f"Structure {design['mass_kg']:g} kg, {design['natural_frequency_hz']:g} Hz, ζ = {design['damping_ratio']:g}; "
        f"particle {design['particle_mass_kg']:g} kg, d = {_printed('clearance_m', design['clearance_m']):g} mm, "
        f"e = {design['restitution']:g}; "
        f"friction {design['friction_force_n']:g} N{_contact_words(answer['contact'])}; "
        f"cavity {cavity_of(design).words}."
    )
    rows = [
        (values["label"], *(number(_printed(name, values[name]), 4) for name, _ in COLUMNS))
        for values in answer["cases"].values()
    ]
    print_table(("damper", *(title for _, title in COLUMNS)), rows)
    for values in answer["cases"].values():
        over = values.get("spread")
        if over and over["sensitive"]:
            lowest, highest = (
                number(_printed("peak_m", over["peak_relative_displacement_m"][end]))
                for end in ("lowest", "highest")
            )
            say(
                f"With {values['label']}, a change of the start by {_printed('size_m', over['size_m']):g} mm "
                f"changes the response by up to {two_digits(over['growth'])} times as much: "
                f"peak x−z from {lowest} "
                f"to {highest} mm over "
                f"{over['starts']} starts."
            )
    worst = max(float(values["energy_residual"]) for values in answer["cases"].values())
    balance = ROUNDING_WORD if worst < ROUNDING else number(worst, 1)
    say(f"Energy balances to {balance}. x−z is the displacement relative to the base, x the absolute one.")
