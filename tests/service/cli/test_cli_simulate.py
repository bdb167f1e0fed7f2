import csv
import json
import math
from pathlib import Path

import pytest
from tests.service.cli.commands import run

PNG = b"\x89PNG\r\n\x1a\n"


def test_the_bare_structure_has_no_particle_and_the_closed_form_amplitude() -> None:
    answer = json.loads(run("simulate", "--no-particle", "--json").stdout)
    zeta = 0.0038
    exact = math.sqrt(1 + 4 * zeta**2) / (2 * zeta)
    assert answer["metrics"]["amplitude_ratio"] == pytest.approx(exact, rel=1e-9)
    assert answer["state"]["p"] is None
    assert answer["state"]["p_rate"] is None
    assert answer["events"]["impacts"] == 0


def test_a_force_on_the_structure_has_the_closed_form_amplitude() -> None:
    answer = json.loads(run("simulate", "--no-particle", "--excitation", "force", "--json").stdout)
    assert answer["metrics"]["amplitude_ratio"] == pytest.approx(1 / (2 * 0.0038), rel=1e-9)
    refused = run("simulate", "--excitation", "force", "--method", "rk4", "--cycles", "3", status=2)
    assert "excitation" in refused.stderr


def test_a_number_of_cycles_ends_exactly_there_and_every_digit_is_printed(tmp_path: Path) -> None:
    from damperlab.service.simulation import compute, read_simulation

    point = {"clearance_ratio": 5.0, "friction_ratio": 0.3, "restitution": 0.5, "frequency_ratio": 1.1}
    flags = [part for name, value in point.items() for part in (f"--{name.replace('_', '-')}", str(value))]
    answer = json.loads(run("simulate", *flags, "--cycles", "5", "--json").stdout)
    expected = compute(read_simulation({**point, "cycles": 5, "history": 0}, 10_000, 1000), 10_000)
    assert answer["cycles"] == 5
    assert answer["metrics"]["amplitude_error"] is None
    assert "over the 5 cycles from rest that were asked for" in answer["status"]
    assert answer["state"] == expected["state"]
    assert answer["events"] == expected["events"]
    assert set(answer["state"]) == {"u", "u_rate", "p", "p_rate"}
    assert set(answer["events"]) == {"impacts", "turns", "attachments"}

    table, figure = tmp_path / "history.csv", tmp_path / "history.png"
    run("simulate", *flags, "--cycles", "5", "-o", table)
    with table.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert float(rows[0]["time"]) == 0.0
    # τ = 2πN/r, to the rounding of the sum of half cycles.
    assert float(rows[-1]["time"]) == pytest.approx(2 * math.pi * 5 / 1.1, rel=1e-12)
    assert float(rows[-1]["u"]) == pytest.approx(answer["state"]["u"], rel=1e-9)
    run("simulate", *flags, "--cycles", "5", "-o", figure)
    assert figure.read_bytes().startswith(PNG)


def test_the_table_names_every_metric_and_the_end_state() -> None:
    text = run("simulate", "--no-particle", "--frequency-ratio", "0.5", "--cycles", "3").stdout
    assert "amplitude_ratio_rms" in text
    assert "After 3 cycles from rest: u = " in text
    assert "p =" not in text


def test_a_contact_time_wants_a_contact_that_lasts() -> None:
    refused = run("simulate", "--contact-time", "0.1", status=2).stderr
    assert "add --contact dwell" in refused
    assert "--contact compliant" in refused
