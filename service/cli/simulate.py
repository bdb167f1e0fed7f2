"""`damperlab simulate` computes one design point from rest."""

from collections.abc import Iterator
from dataclasses import replace
from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from damperlab.service.cli.asked import Values, asks, names_a_design
from damperlab.service.cli.options import (
    CONTACT_OPTIONS,
    AsJson,
    Contact,
    ContactTime,
    Details,
    check_file,
    contact_document,
)
from damperlab.service.cli.output import make_parent, note, number, print_json, print_table, say, working
from damperlab.service.cli.places import file_option
from damperlab.service.cli.spelled import in_options, options_of
from damperlab.service.cli.warm import have_ready
from damperlab.service.cli.words import cell
from damperlab.studies.brief import Brief, lines_of
from damperlab.studies.faults import counted
from damperlab.studies.field import given, option_of
from damperlab.studies.quantity import QUANTITY_OF
from damperlab.studies.questions import Simulated
from damperlab.studies.variables import (
    BEFORE,
    DIMENSION_LONG_NAMES,
    DIMENSIONS,
    VARIABLES,
    ResponseClass,
    Status,
)
from damperlab.studies.vocabulary import DESIGN_POINT, OF_PARTICLE

if TYPE_CHECKING:
    import numpy as np

    from damperlab.service.simulation import Met, SimulatedDocument

CYCLES_LIMIT = 10_000_000
"""Largest number of cycles. The limit of a service is lower, because users share the service."""
SAMPLES_LIMIT = 10_000_000
STEADY_HISTORY = 20
"""Default number of cycles in a file with the time history of a steady response."""
LONG_HISTORY = 200
"""Largest default number of cycles in a file with a time history from rest."""
SHOWN_SAMPLES = 1000
EVERY = (*DIMENSIONS, *BEFORE)
"""Names of the numbers that define a design point."""
OPTIONS = (
    {name: option_of(name) for name in EVERY}
    | options_of(Simulated)
    | CONTACT_OPTIONS
    | {"particle: false": "--no-particle", "method: event": "--method event"}
)
"""Command-line option for each field of a simulation."""
AMPLITUDE = "amplitude_ratio"
ROUNDING = 1e-6
"""Relative error of the amplitude above which the error is printed."""
LOSSES = {
    "impact": "in impacts",
    "friction": "in friction",
    "viscous": "in damping",
    "particle": "in friction of the particle",
}


MEANINGS = {name: f"{DIMENSION_LONG_NAMES[name]}; {DESIGN_POINT.get(name, 0):g} by default" for name in EVERY}


@names_a_design(MEANINGS, QUANTITY_OF)
@asks
def simulate(
    design: Values,
    asked: Simulated,
    no_particle: Annotated[bool, typer.Option("--no-particle", help="Leave the particle out.")] = False,
    contact: Contact = "instant",
    contact_time: ContactTime = None,
    output: Annotated[
        Path | None,
        file_option("--output", "-o", help="Write the time history as .csv, .png, .svg or .pdf."),
    ] = None,
    details: Details = False,
    as_json: AsJson = False,
) -> None:
    """Compute one design point from rest.

    The output describes the response; --details adds every result. -o writes the time history to a file.
    """
    check_file(output)
    at = {**DESIGN_POINT, **design}
    document: dict[str, object] = {**given(asked), "particle": not no_particle, "samples": SAMPLES_LIMIT}
    unneeded = [name for name in OF_PARTICLE if no_particle and name not in design]
    document |= {name: at[name] for name in EVERY if name in at and name not in unneeded}
    document |= contact_document(contact, contact_time)
    left_out = {
        name: value for name, value in DESIGN_POINT.items() if name in document and name not in design
    }
    document["history"] = _history(asked, output, at["frequency_ratio"])
    with working("Reading the design"):
        from damperlab.service.simulation import compute, decimated, read_simulation, scenes_asked

        with in_options(OPTIONS):
            checked = read_simulation(document, CYCLES_LIMIT, SAMPLES_LIMIT)
        checked = replace(checked, followed=as_json)  # only JSON contains the events of a cycle
    if not as_json:
        from damperlab.studies.cavity import left_open
        from damperlab.studies.understood import assumed

        if taken := assumed(left_out, [] if no_particle else left_open(design)):
            note(taken)
    have_ready(scenes_asked(checked, CYCLES_LIMIT))
    with working("Computing"):
        answer = compute(checked, CYCLES_LIMIT)
    if output is not None:
        _write(answer["history"], {name: at[name] for name in EVERY if name in document}, output)
    if as_json:
        answer["history"] = decimated(answer["history"], SHOWN_SAMPLES)
        print_json(answer)
    elif output is None:
        _print(answer, steady=asked.cycles is None, details=details)


def _history(asked: Simulated, output: Path | None, frequency_ratio: float) -> int:
    """Determine the number of cycles of time history to compute."""
    if output is not None and asked.method == "rk4":
        raise typer.BadParameter(
            "Only --method event gives a time history. Leave out -o, or leave out --method rk4."
        )
    if asked.history is not None:
        return asked.history
    if output is None:
        return 0
    wanted = STEADY_HISTORY if asked.cycles is None else min(asked.cycles, LONG_HISTORY)
    # A slow excitation has long cycles, and the length of a time history is limited in natural periods.
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


def _print(answer: "SimulatedDocument", steady: bool, details: bool) -> None:
    """Print a short description of the response. With `details`, also print every metric and the final state."""
    metrics = answer["metrics"]
    status = answer["status"] if details or not steady else _outcome(metrics)
    for line in lines_of(Brief(None, (status,), tuple(_rows(answer))).document()):
        say(line)
    if details or not steady:
        say(_end(answer, steady))
    if details:
        print_table(
            ("metric", "value", "what"),
            (
                (name, cell(name, metrics[name]), VARIABLES[name].long_name)
                for name in VARIABLES
                if name in metrics
            ),
        )
    if "attractors" in answer:
        _print_attractors(answer["attractors"])
    if not details:
        say("Details: --details.")


def _outcome(metrics: "dict[str, float]") -> str:
    """Describe a steady response that was found, or why none was found."""
    status = Status(int(metrics["status"]))
    if status is not Status.CONVERGED:
        return status.outcome
    period = int(metrics["period"])
    if metrics.get("response_class") == ResponseClass.LOCKED:
        return "Friction clamps the structure to its base: nothing is damped."
    if period:
        return f"The steady response repeats after {counted(period, 'cycle')}."
    return "The steady response does not repeat; its mean is known to within `steady.tolerance`."


def _rows(answer: "SimulatedDocument") -> Iterator[tuple[str, str, str]]:
    """Yield a row for each known result: amplitude, class of the response, impacts, and energy losses."""
    known = {name: value for name, value in answer["metrics"].items() if not isnan(value)}
    if AMPLITUDE in known:
        error = known.get("amplitude_error", 0.0)
        within = f" ± {error:.1g}" if error > ROUNDING * known[AMPLITUDE] else ""
        # `amplitude_ratio_rms` is the amplitude of the sine with the same rms
        beside = {"largest": known.get("amplitude_ratio_max"), "√2·rms": known.get("amplitude_ratio_rms")}
        told = ", ".join(f"{name} {value:.4g}" for name, value in beside.items() if value is not None)
        yield "amplitude X/Z", f"{known[AMPLITUDE]:.4g}{within}", told
    if known.get("response_class", -1) >= 0:
        name = cell("response_class", known["response_class"])
        settles = answer.get("settles_after_cycles")
        settling = (
            "" if settles is None else f"a small disturbance falls to a hundredth in {settles:.3g} cycles"
        )
        yield "response", name, settling
    if known.get("impacts_per_cycle", 0.0) > 0.0:
        speed = known.get("impact_speed_max")
        at_most = "" if speed is None else f"at most {speed:.4g} Z·ω_n"
        yield "impacts", f"{known['impacts_per_cycle']:.4g} a cycle", at_most
    shares = {
        name: known.get(f"dissipation_{name}", 0.0) for name in ("impact", "friction", "viscous", "particle")
    }
    if any(shares.values()):
        parts = (f"{100 * share:.3g} % {LOSSES[name]}" for name, share in shares.items() if share > 0.0)
        yield "energy lost", "", ", ".join(parts)


def _end(answer: "SimulatedDocument", steady: bool) -> str:
    """Describe the state after the computed cycles.

    If no cycle was computed, describe the state at the start of a cycle.
    """
    state = ", ".join(
        f"{name} = {number(value)}" for name, value in answer["state"].items() if value is not None
    )
    if answer["cycles"] or not steady:
        events = ", ".join(f"{count} {name}" for name, count in answer["events"].items())
        cycles = counted(answer["cycles"], "cycle")
        cycles += " along the steady response" if steady else " from rest"
        return f"After {cycles}: {state}; {events}."
    u = answer["state"]["u"]
    known = u is not None and not isnan(u)
    return f"Steady response at the start of an excitation cycle: {state}." if known else ""


def _print_attractors(found: "Met") -> None:
    """Print a table of the responses reached from different starts, and a note on these responses."""
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
