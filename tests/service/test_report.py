"""The report: one document that loads nothing, whose numbers are the cube's."""

import io
import re
from html import unescape
from typing import Any

import httpx
import numpy as np
import pytest
import xarray as xr
from tests.service.cli.commands import run
from tests.service.conftest import computed

MASS, HERTZ, BASE = 2.0, 4.0, 0.003
STUDY: dict[str, Any] = {
    "name": "<b>pad</b> & floor",
    "particle": False,
    "damping_ratio": 0.02,
    "physical": {
        "mass_kg": MASS,
        "natural_frequency_hz": HERTZ,
        "base_amplitude_m": BASE,
        "friction_force_n": [0.4, 0.8, 1.2],
        "excitation_frequency_hz": {"start": 3.2, "stop": 4.8, "num": 5},
    },
    "steady": {"max_cycles": 100},
}


def tables(text: str) -> list[list[list[str]]]:
    """Give the cells of every table."""

    def inner(tag: str, within: str) -> list[str]:
        return re.findall(rf"<{tag}\b[^>]*>(.*?)</{tag}>", within, re.DOTALL)

    return [
        [
            [unescape(re.sub("<[^>]*>", "", cell)) for cell in inner("t[dh]", row)]
            for row in inner("tr", table)
        ]
        for table in inner("table", text)
    ]


@pytest.fixture(scope="module")
def written(service: Any, tmp_path_factory: pytest.TempPathFactory) -> tuple[str, xr.Dataset]:
    """What the command writes of a study, and the study's cube."""
    path = tmp_path_factory.mktemp("report") / "report.html"
    record = computed(service, STUDY)
    with service.client() as client:
        exported = client.get(f"/api/v1/studies/{record['id']}/export").raise_for_status().content
    run("report", record["id"], "--data-dir", service.log.parent / "data", "-o", path)
    return path.read_text(), xr.load_dataset(io.BytesIO(exported), engine="h5netcdf")


def test_designs_are_the_cubes_in_the_units_of_the_study(written: tuple[str, xr.Dataset]) -> None:
    text, cube = written
    worst = cube["amplitude_ratio"].squeeze().max("frequency_ratio").values
    order = np.argsort(worst, kind="stable")
    head, *rows = tables(text)[0]
    assert head[1] == "amplitude [mm]"
    assert head[3] == "friction force [N]"
    assert len(rows) == 3
    for row, place in zip(rows, order, strict=True):
        assert float(row[1]) == pytest.approx(1e3 * worst[place] * BASE, rel=1e-5)
        assert float(row[3]) == pytest.approx([0.4, 0.8, 1.2][place], rel=1e-5)
    assert f"{worst.min() * BASE * 1e3:.3g}" in text


def test_it_loads_nothing_and_text_stays_text(written: tuple[str, xr.Dataset]) -> None:
    text, _ = written
    assert "<h1>&lt;b&gt;pad&lt;/b&gt; &amp; floor</h1>" in text
    assert not {"script", "link", "iframe", "object", "b"} & set(re.findall(r"<(\w+)", text))
    addresses = re.findall(r'\b(?:src|href)="([^"]*)"', text)
    assert len(addresses) >= 2
    assert all(address.startswith("data:image/svg+xml;base64,") for address in addresses)
    assert not re.search(r"url\(|@import", text.split("</style>")[0])
    versions = {row[0]: row[1] for row in tables(text)[-1][1:]}
    assert versions["solver_version"]
    assert not {"host", "user"} & versions.keys()


def test_over_http_it_is_the_same_kind_of_page_for_a_suite(
    client: httpx.Client, suite: dict[str, Any]
) -> None:
    answer = client.get(f"/api/v1/studies/{suite['id']}/report")
    assert answer.status_code == 200
    assert answer.headers["content-type"] == "text/html; charset=utf-8"
    assert answer.headers["content-security-policy"].startswith("default-src 'none'")
    dampers = tables(answer.text)[0]
    best = client.get(f"/api/v1/studies/{suite['id']}/optimal-designs").json()["designs"][0]
    assert float(dampers[1][1]) == pytest.approx(1e3 * best["value"], rel=1e-5)
