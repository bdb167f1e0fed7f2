"""Requests to a service that faults are done to."""

import http.client
import json
import urllib.error
import urllib.request
from typing import Any


def ask(method: str, address: str, document: Any = None) -> tuple[int, Any]:
    """Ask the service: status and document of its answer, or the words of a refusal; status 0 where nobody answers."""
    body = None if document is None else json.dumps(document).encode()
    request = urllib.request.Request(address, body, {"Content-Type": "application/json"}, method=method)
    try:
        with urllib.request.urlopen(request, timeout=10) as answer:
            content = answer.read()
            return answer.status, json.loads(content) if content else None
    except urllib.error.HTTPError as error:
        with error:
            return error.code, error.read()[:500]
    except (OSError, http.client.HTTPException, ValueError):
        return 0, None
