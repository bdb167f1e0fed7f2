"""What README and reference say of the client is what happens, word for word."""

import inspect
import re
from pathlib import Path
from typing import Any

import httpx
import pytest

from damperlab.service.client import Client, Design, Study

ROOT = Path(__file__).parents[3]
README = (ROOT / "README.md").read_text()
EXAMPLE = README[README.index("## From Python") :].partition("\n## ")[0]
SECTION = (ROOT / "docs" / "reference" / "client.md").read_text().partition("\n## In full")[0]


def test_request_with_curl_is_accepted(service: Any, tmp_path: Path) -> None:
    command = re.search(r"^    curl (.*)$", EXAMPLE, re.MULTILINE)
    study = README.partition('```yaml title="cavities.yaml"\n')[2].partition("```")[0]
    assert command is not None
    assert "'Content-Type: application/yaml' --data-binary" in command[1]
    url = command[1].split()[-1].replace("http://127.0.0.1:8000", service.url)
    answer = httpx.post(
        url, content=study.encode(), headers={"Content-Type": "application/yaml"}, timeout=300
    )
    assert answer.status_code in (200, 201)
    assert answer.json()["name"] == "three cavities"


@pytest.mark.parametrize(
    ("kind", "opening"), [(Client, "| `Client("), (Study, "| `Study`"), (Design, "| `Design`")]
)
def test_table_has_every_method_with_its_arguments(kind: type, opening: str) -> None:
    table = SECTION[SECTION.index(opening) :].partition("\n\n")[0]
    for name, method in inspect.getmembers(kind, inspect.isfunction):
        if name.startswith("_") or name == "close":
            continue
        arguments = [
            str(each.replace(annotation=inspect.Parameter.empty)).replace("'", '"')
            for each in inspect.signature(method).parameters.values()
            if each.name != "self"
        ]
        if name in ("study", "simulate"):
            assert f".{name}(" in table
        else:
            assert f".{name}({', '.join(arguments)})" in table.replace("id_or_name", "reference")
