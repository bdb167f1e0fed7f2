import json
from pathlib import Path
from typing import Any

import pytest
from tests.service.cli.commands import LINEAR, run


@pytest.fixture(scope="session")
def linear_study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("study") / "linear.json"
    path.write_text(json.dumps(LINEAR))
    return path


@pytest.fixture(scope="session")
def stored(tmp_path_factory: pytest.TempPathFactory, linear_study: Path) -> tuple[Path, dict[str, Any]]:
    """A data directory in which `run --json` has computed the linear study, and what it printed."""
    data_dir = tmp_path_factory.mktemp("data")
    ended = run("run", linear_study, "--data-dir", data_dir, "--json")
    return data_dir, json.loads(ended.stdout)
