"""A study handed to a service that faults are done to."""

import json
import sys
import urllib.error
import urllib.request

from tests.faults.report import Report

from damperlab.studies.definition import Study


def submit(url: str, study: Study, key: str, report: Report) -> str | None:
    """Submit a study by HTTP; the key makes it one, however often it is sent. None where the service did not take it."""
    request = urllib.request.Request(
        f"{url}/api/v1/studies",
        json.dumps(study.document()).encode(),
        {"Content-Type": "application/json", "Idempotency-Key": key},
    )
    try:
        with urllib.request.urlopen(request, timeout=5) as answer:
            return str(json.load(answer)["id"])
    except urllib.error.HTTPError as error:
        report.unavailable += error.code == 503
        report.defects += error.code != 503
        if error.code != 503:
            print(f"POST answered {error.code}: {error.read()[:500]!r}", file=sys.stderr)
        error.close()
    except (urllib.error.URLError, ConnectionError, TimeoutError):
        report.unavailable += 1
    return None
