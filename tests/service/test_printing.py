"""Reports as PDF: what the page says, on sheets, and nothing from elsewhere."""

import io
import sys
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import httpx
import pytest
from tests.service.cli.commands import run

from damperlab.service.html import page, said, table
from damperlab.service.printing import printed, require_printer
from damperlab.studies.answers.query_fault import QueryFault

A4 = (210.0 / 25.4 * 72.0, 297.0 / 25.4 * 72.0)
"""Points."""


@pytest.fixture(scope="module", autouse=True)
def printer() -> None:
    """Leave the tests out where there is none; only they load it."""
    try:
        require_printer()
    except QueryFault as error:
        pytest.skip(str(error))


def sheets(content: bytes) -> tuple[list[Any], str]:
    """Give the sheets of a PDF, and the words on them with single spaces."""
    pypdf = pytest.importorskip("pypdf")
    reader = pypdf.PdfReader(io.BytesIO(content))
    return list(reader.pages), " ".join(" ".join(each.extract_text() for each in reader.pages).split())


def test_text_stays_text_on_sheets_of_a4_and_a_table_repeats_its_head() -> None:
    rows = [(f"row {number}", f"{number} mm ± 5 %") for number in range(120)]
    text = page(
        "<pad>",
        ["<h1>&lt;pad&gt;</h1>", said("γ_F = 0.4 & e ≤ 0.5"), table("All", ("quantity", "size"), rows)],
    )
    pages, words = sheets(printed(text))
    assert len(pages) > 2
    assert all(float(each.mediabox.width) == pytest.approx(A4[0], abs=0.01) for each in pages)
    assert all(float(each.mediabox.height) == pytest.approx(A4[1], abs=0.01) for each in pages)
    assert "<pad>" in words
    assert "γ_F = 0.4 & e ≤ 0.5" in words
    assert all(f"{first} {second}" in words for first, second in rows)
    assert words.count("quantity size") == len(pages)


def test_no_address_is_followed(tmp_path: Path) -> None:
    asked: list[str] = []

    class Listening(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            asked.append(self.path)
            self.send_error(404)

    (tmp_path / "secret.svg").write_text(
        '<svg xmlns="http://www.w3.org/2000/svg"><text y="20">secret</text></svg>'
    )
    with ThreadingHTTPServer(("127.0.0.1", 0), Listening) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        try:
            addresses = (f"http://127.0.0.1:{server.server_port}/a", (tmp_path / "secret.svg").as_uri())
            pictures = [f'<img alt="picture" src="{address}">' for address in addresses]
            style = f"<style>@import url(http://127.0.0.1:{server.server_port}/b);</style>"
            _, words = sheets(printed(page("pad", [*pictures, style])))
            httpx.get(f"http://127.0.0.1:{server.server_port}/heard")
        finally:
            server.shutdown()
    assert asked == ["/heard"]
    assert "secret" not in words


def test_a_study_and_its_report_as_pdf_say_the_same(
    client: httpx.Client, curve: dict[str, Any], service: Any, tmp_path: Path
) -> None:
    where = f"/api/v1/studies/{curve['id']}/report"
    answer = client.get(where, params={"format": "pdf"})
    assert answer.status_code == 200
    assert answer.headers["content-type"] == "application/pdf"
    assert f"{curve['id']}.pdf" in answer.headers["content-disposition"]
    run("report", curve["id"], "--data-dir", service.log.parent / "data", "-o", tmp_path / "report.pdf")
    written = sheets((tmp_path / "report.pdf").read_bytes())[1]
    assert sheets(answer.content)[1] == written
    assert f"Study {curve['id']}" in written
    assert client.get(where, params={"format": "docx"}).status_code == 422


@pytest.mark.night
def test_a_design_as_pdf_says_what_its_answer_says(client: httpx.Client, design: dict[str, Any]) -> None:
    answer = client.get(f"/api/v1/designs/{design['id']}/report", params={"format": "pdf"}).raise_for_status()
    words = sheets(answer.content)[1].replace(" ", "")
    for sentence in design["answer"]["words"]:
        assert sentence.replace(" ", "") in words.replace("-\n", "")


def test_where_nothing_prints_the_command_says_so_before_it_computes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "weasyprint", None)
    data, report = tmp_path / "data", tmp_path / "report.pdf"
    refused = run("design", "prototype", "--data-dir", data, "-o", report, status=2)
    assert "damperlab[pdf]" in refused.stderr
    assert not data.exists()
