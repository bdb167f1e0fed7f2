"""A data folder that may not be written: one sentence that names it, nothing listens, and all is well when it may again."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest
from tests.service.cli.commands import END_SECONDS, LINEAR, command, environment, run

# Root may write where permissions say no; without two of its capabilities it is held to them like everybody else.
AS_A_USER = ["setpriv", "--bounding-set", "-dac_override,-dac_read_search"] if os.geteuid() == 0 else []

pytestmark = pytest.mark.skipif(
    bool(AS_A_USER) and shutil.which("setpriv") is None, reason="root, and no setpriv to lay its powers down"
)


@pytest.mark.parametrize(
    "words",
    [["serve", "--port", "0"], pytest.param(["run", "figure-7"], marks=pytest.mark.night)],
    ids=" ".join,
)
def test_a_folder_without_permission_is_named_in_one_sentence(words: list[str], tmp_path: Path) -> None:
    folder = tmp_path / "data"
    folder.mkdir(mode=0o555)
    ended = subprocess.run(
        [*AS_A_USER, *command(*words, "--data-dir", folder)],
        capture_output=True,
        text=True,
        stdin=subprocess.DEVNULL,
        env=environment(),
        timeout=END_SECONDS,
    )
    assert ended.returncode == 1
    assert str(folder) in ended.stderr
    assert "permissions" in ended.stderr
    assert "Traceback" not in ended.stderr
    assert list(folder.iterdir()) == []

    folder.chmod(0o755)
    study = tmp_path / "study.json"
    study.write_text(json.dumps(LINEAR))
    run("run", study, "--data-dir", folder)
