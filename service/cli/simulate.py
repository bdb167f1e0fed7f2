"""The command simulate: one design point from rest."""

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from damperlab.service.cli.dialect import names_a_design
from damperlab.service.cli.options import (
    AsJson,
    Contact,
    ContactModel,
    ContactTime,
    check_file,
    contact_document,
    read_at,
)
from damperlab.service.cli.output import make_parent, note, number, print_json, print_table, say, working
from damperlab.service.cli.warm import have_ready
from damperlab.service.cli.words import cell
from damperlab.studies.faults import counted
from damperlab.studies.variables import DIMENSIONS, VARIABLES
from damperlab.studies.vocabulary import DESIGN_POINT, OF_PARTICLE

if TYPE_CHECKING:
    import numpy as np

CYCLES_LIMIT = 10_000_000
"""Of a service's requests the settings are stricter; here nobody else waits."""
SAMPLES_LIMIT = 10_000_000
STEADY_HISTORY = 20
"""Cycles of a steady response in a file where no number is given."""
LONG_HISTORY = 200
"""Most cycles from rest in a file where no number is given."""
SHOWN_SAMPLES = 1000


class Method(StrEnum):
    """How to compute."""

    event = "event"
    rk4 = "rk4"


@names_a_design
def simulate(
    no_particle: Annotated[bool, typer.Option("--no-particle", help="Leave the particle out.")] = False,
    contact: Contact = ContactModel.instant,
    contact_time: ContactTime = None,
    cycles: Annotated[
        int | None,
        typer.Option(
            help="Integrate from rest for exactly this many excitation cycles; the steady response by default."
        ),
    ] = None,
    method: Annotated[
        Method,
        typer.Option(
            help="Integration method: event-driven, or the paper's Runge–Kutta scheme with fixed steps."
        ),
    ] = Method.event,
    history: Annotated[
        int | None,
        typer.Option(
            metavar="CYCLES",
            help="Length of the time history for -o and --json, in excitation cycles before the end.",
        ),
    ] = None,
    starts: Annotated[
        int,
        typer.Option(help="Number of initial states whose steady responses are compared; the first is rest."),
    ] = 0,
    seed: Annotated[int, typer.Option(help="Seed of the random initial states.")] = 0,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", metavar="FILE", help="Write the time history as .csv, .png, .svg or .pdf."
        ),
    ] = None,
    at: Annotated[
        list[str] | None,
        typer.Option(
            metavar="DIMENSION=VALUE",
            help="Another spelling of the six ratios, as in --at clearance_ratio=3. May be repeated.",
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Simulate one design point from rest: its response, its final state and its time history."""
    check_file(output)
    given = {**DESIGN_POINT, **read_at(at, DIMENSIONS)}
    document: dict[str, object] = {
        "particle": not no_particle,
        "method": method.value,
        "samples": SAMPLES_LIMIT,
    }
    document |= {name: given[name] for name in DIMENSIONS if not (no_particle and name in OF_PARTICLE)}
    document |= contact_document(contact, contact_time)
    document["history"] = _history(history, output, cycles, method, given["frequency_ratio"])
    if cycles is not None:
        document["cycles"] = cycles
    if starts or seed:
        document |= {"starts": starts, "seed": seed}
    with working("Reading the design"):
        from damperlab.service.simulation import compute, decimated, read_simulation, scenes_asked

        asked = read_simulation(document, CYCLES_LIMIT, SAMPLES_LIMIT)
    have_ready(scenes_asked(asked, CYCLES_LIMIT))
    with working("Computing"):
        answer = compute(asked, CYCLES_LIMIT)
    if output is not None:
        _write(answer["history"], {name: given[name] for name in DIMENSIONS if name in document}, output)
    if as_json:
        answer["history"] = decimated(answer["history"], SHOWN_SAMPLES)
        print_json(answer)
    elif output is None:
        _print(answer, steady=cycles is None)


def _history(
    history: int | None, output: Path | None, cycles: int | None, method: Method, frequency_ratio: float
) -> int:
    """Settle how many cycles of time history to ask for."""
    if output is not None and method is Method.rk4:
        raise typer.BadParameter(
            "Only --method event gives a time history. Leave out -o, or leave out --method rk4."
        )
    if history is not None:
        return history
    if output is None:
        return 0
    wanted = STEADY_HISTORY if cycles is None else min(cycles, LONG_HISTORY)
    # A slow excitation has long cycles, and a time history may cover a limited number of natural periods.
    return max(1, min(wanted, int(frequency_ratio * LONG_HISTORY))) if frequency_ratio > 0 else wanted


def _write(history: "dict[str, np.ndarray]", ratios: "dict[str, float]", output: Path) -> None:
    make_parent(output)
    if output.suffix == ".csv":
        with output.open("w", encoding="utf-8") as file:
            file.write(",".join(history) + "\n")
            columns = (column.tolist() for column in history.values())
            file.writelines(",".join(map(repr, row)) + "\n" for row in zip(*columns, strict=True))
    else:
        from damperlab.service.figures.curves import draw_history
        from damperlab.service.figures.style import save

        save(draw_history(history, ratios), output)
    note(f"Wrote {output}.")


def _print(answer: dict[str, Any], steady: bool) -> None:
    """Print the metrics, the state at the end, and what the status means."""
    metrics = answer["metrics"]
    print_table(
        ("metric", "value", "what"),
        (
            (name, cell(name, metrics[name]), VARIABLES[name].long_name)
            for name in VARIABLES
            if name in metrics
        ),
    )
    state = ", ".join(
        f"{name} = {number(value)}" for name, value in answer["state"].items() if value is not None
    )
    events = ", ".join(f"{count} {name}" for name, count in answer["events"].items())
    way = "on along the steady response" if steady else "from rest"
    say(f"After {counted(answer['cycles'], 'cycle')} {way}: {state}; {events}.")
    say(answer["status"])
    if "attractors" in answer:
        _print_attractors(answer["attractors"])


def _print_attractors(found: dict[str, Any]) -> None:
    """Print the responses that the starts lead to, and what decides between them."""
    names = (
        "response_class",
        "period",
        "amplitude_ratio",
        "amplitude_error",
        "impacts_per_cycle",
        "floquet_multiplier",
    )
    rows = (
        (f"{one['share']:.3g}", *(cell(name, one["metrics"][name]) for name in names)) for one in found["met"]
    )
    print_table(("share", *names), rows)
    say(found["note"])
