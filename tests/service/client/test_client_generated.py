"""A client that a generator makes from the OpenAPI document alone: it compiles, and the main journey works with it."""

import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

import httpx
import pytest
from numpy.testing import assert_allclose

TOOLS = Path(__file__).parents[3] / "node_modules" / ".bin"
JOURNEY = Path(__file__).with_name("generated_journey.ts")
PATIENCE_SECONDS = 600.0


def _run(*command: object, folder: Path) -> str:
    done = subprocess.run(
        [*map(str, command)], cwd=folder, capture_output=True, text=True, timeout=PATIENCE_SECONDS
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture
def journey(client: httpx.Client, tmp_path: Path) -> Path:
    """The journey and its client, compiled."""
    missing = not (TOOLS / "openapi-ts").exists() or shutil.which("node") is None
    if missing:
        how = "there is no generator of clients: `npm ci` installs it"
        if os.environ.get("CI") == "true":
            pytest.fail(how)
        pytest.skip(how)
    (tmp_path / "openapi.json").write_text(client.get("/openapi.json").raise_for_status().text)
    _run(TOOLS / "openapi-ts", "-i", "openapi.json", "-o", "client", "--no-log-file", folder=tmp_path)
    shutil.copy(JOURNEY, tmp_path / "journey.ts")
    strict = ["--strict", "--target", "es2022", "--module", "commonjs", "--lib", "es2023,dom,dom.iterable"]
    _run(TOOLS / "tsc", *strict, "--outDir", "built", "journey.ts", folder=tmp_path)
    return tmp_path / "built" / "journey.js"


@pytest.mark.night
def test_a_generated_client_runs_the_main_journey(service: Any, journey: Path) -> None:
    found = json.loads(_run("node", journey, service.url, "", folder=journey.parent))
    assert (found["points"], found["created"], found["state"]) == (22, 201, "done")
    # the structure alone, |X/Z| = √(1 + (2ζr)²) / √((1 − r²)² + (2ζr)²)
    x, viscous = found["x"], [2 * 0.0123 * r for r in found["x"]]
    expected = [((1 + v * v) / ((1 - r * r) ** 2 + v * v)) ** 0.5 for r, v in zip(x, viscous, strict=True)]
    assert_allclose(found["values"][0], expected, rtol=1e-9)
    assert len(found["values"]) == 2
    # friction that does not lock takes energy at resonance, where the peak is
    assert found["best"]["friction_ratio"] == 0.1
    assert found["refused"]["status"] == 422
    assert found["refused"]["fields"]
    assert (found["removed"], found["gone"]) == (204, 404)
