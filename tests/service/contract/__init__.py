"""The OpenAPI document as a contract: the copy that clients rely on, and what a change of it breaks."""

import json
from pathlib import Path
from typing import Any

COPY = Path(__file__).with_name("openapi.json")
NOTES = Path(__file__).with_name("breaks.md")


def document_now() -> dict[str, Any]:
    """Give the document that the service has now, without its version."""
    from damperlab.service.app import create_app
    from damperlab.service.settings import Settings

    document: dict[str, Any] = json.loads(json.dumps(create_app(Settings()).openapi()))
    del document["info"]["version"]
    return document


def document_kept() -> dict[str, Any]:
    """Give the copy."""
    document: dict[str, Any] = json.loads(COPY.read_text())
    return document


def keep(document: dict[str, Any]) -> None:
    """Write the copy."""
    COPY.write_text(json.dumps(document, indent=1, ensure_ascii=False, sort_keys=True) + "\n")
