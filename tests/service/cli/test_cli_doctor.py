import json
from pathlib import Path

from tests.service.cli.commands import run


def test_doctor_tries_everything_but_the_cluster(tmp_path: Path) -> None:
    report = json.loads(run("doctor", "--no-cluster", "--data-dir", tmp_path / "data", "--json").stdout)
    assert report["ok"] is True
    found = {check["name"]: check["found"] for check in report["checks"]}
    assert list(found) == ["versions", "cores", "closed form", "kernels", "store"]
    assert "131.5827473" in found["closed form"]
    assert str(tmp_path / "data") in found["store"]


def test_doctor_names_what_does_not_work_and_exits_1(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    report = json.loads(
        run(
            "doctor", "--scheduler", "tcp://127.0.0.1:1", "--data-dir", tmp_path / "file", "--json", status=1
        ).stdout
    )
    assert report["ok"] is False
    assert [check["name"] for check in report["checks"] if not check["ok"]] == ["store", "cluster"]
