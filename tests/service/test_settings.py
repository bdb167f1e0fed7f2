"""Settings from the environment and from arguments."""

from pathlib import Path

import pytest
from pydantic import ValidationError

from damperlab.service.settings import Settings
from damperlab.studies.store.opening import default_data_dir


@pytest.fixture(autouse=True)
def _bare(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for name in Settings.model_fields:
        monkeypatch.delenv(f"DAMPERLAB_{name.upper()}", raising=False)
    monkeypatch.delenv("XDG_DATA_HOME", raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))


def test_service_listens_on_loopback_unless_told_otherwise() -> None:
    settings = Settings()
    assert (settings.host, settings.port, settings.cors_origins) == ("127.0.0.1", 8000, ())


def test_data_lies_where_the_desktop_standard_says(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    assert default_data_dir() == tmp_path / ".local/share/damperlab"
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "share"))
    assert default_data_dir() == tmp_path / "share/damperlab"
    # The standard asks to ignore a relative path.
    monkeypatch.setenv("XDG_DATA_HOME", "share")
    assert default_data_dir() == tmp_path / ".local/share/damperlab"


def test_data_dir_does_not_depend_on_the_working_directory(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    assert Settings(data_dir=Path("data")).data_dir == tmp_path / "data"
    assert Settings(data_dir=Path("~/data")).data_dir == tmp_path / "data"


@pytest.mark.parametrize(
    "values", [{"port": 65536}, {"workers": 0}, {"workers": 1, "scheduler": "tcp://a:1"}, {"colour": "red"}]
)
def test_impossible_settings_are_refused(values: dict[str, object]) -> None:
    with pytest.raises(ValidationError):
        Settings(**values)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["hosts", "trusted_proxies", "cors_origins"])
@pytest.mark.parametrize("text", ["10.0.0.1, 10.0.0.2", '["10.0.0.1", "10.0.0.2"]'])
def test_every_list_is_written_with_commas_or_in_json(
    monkeypatch: pytest.MonkeyPatch, name: str, text: str
) -> None:
    monkeypatch.setenv(f"DAMPERLAB_{name.upper()}", text)
    assert getattr(Settings(), name) == ("10.0.0.1", "10.0.0.2")
