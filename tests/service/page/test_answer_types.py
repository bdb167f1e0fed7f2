"""The types by which the page reads answers are held against what the service answers."""

import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

import httpx
import pytest

ROOT = Path(__file__).parents[3]
TSC = ROOT / "node_modules" / ".bin" / "tsc"
POINT = {"clearance_ratio": 5, "friction_ratio": 0.2, "frequency_ratio": 1, "history": 2, "samples": 100}
STRUCTURE = {"mass_kg": 1.605, "natural_frequency_hz": 2.5, "base_amplitude_m": 0.0015}


@pytest.fixture
def answers(client: httpx.Client, small_map: dict[str, Any]) -> dict[str, Any]:
    """One answer of each type of the page, by the type's name."""
    study = f"/api/v1/studies/{small_map['id']}"
    new = {
        "name": "new",
        "physical": STRUCTURE,
        "axes": {"clearance_ratio": 5, "friction_ratio": 0.2, "frequency_ratio": 1},
    }

    def get(path: str, **parameters: Any) -> Any:
        return client.get(path, params=parameters).raise_for_status().json()

    return {
        "StudyRecord": get(study),
        "OfStudy['axes']": get(f"{study}/axes"),
        "MapAnswer": get(f"{study}/resonance-map", x="clearance_ratio", y="friction_ratio"),
        "MapDifference": get(
            f"{study}/resonance-map", x="clearance_ratio", y="friction_ratio", minus=small_map["id"]
        ),
        "Curve": get(f"{study}/frequency-response", clearance_ratio=10, friction_ratio=0.4),
        "Comparison": get(f"{study}/tmd-comparison", clearance_ratio=10, friction_ratio=0.4),
        "Catalogue": get("/api/v1/catalog"),
        "GroundRecordShown": get("/api/v1/records/el-centro-180"),
        "Others['records']": get("/api/v1/records"),
        "Others['session']": get("/api/v1/session"),
        "Others['designs']": get("/api/v1/designs"),
        "Simulated": client.post("/api/v1/simulate", json=POINT).raise_for_status().json(),
        "Estimate": client.post("/api/v1/studies", params={"dry_run": True}, json=new)
        .raise_for_status()
        .json(),
        "Readiness": client.post("/api/v1/simulate", params={"dry_run": True}, json=POINT)
        .raise_for_status()
        .json(),
    }


def test_answers_have_the_types_that_the_page_reads_them_by(answers: dict[str, Any], tmp_path: Path) -> None:
    if not TSC.exists() or shutil.which("node") is None:
        how = "the compiler of types is not here: `npm ci` installs it"
        if os.environ.get("CI") == "true":
            pytest.fail(how)
        pytest.skip(how)
    lines = [f'import type {{ OfStudy, Others }} from "{ROOT}/service/page/answers.js";']
    lines += [f'import type * as page from "{ROOT}/service/page/answers.js";']
    for i, (name, answer) in enumerate(answers.items()):
        kind = name if "[" in name else f"page.{name}"
        # not fresh where it is assigned: the service may answer more than the page reads
        lines.append(f"const answer{i} = {json.dumps(answer)};\nexport const held{i}: {kind} = answer{i};")
    (tmp_path / "held.ts").write_text("\n".join(lines))
    options = json.loads((ROOT / "tsconfig.json").read_text())["compilerOptions"]
    (tmp_path / "tsconfig.json").write_text(json.dumps({"compilerOptions": options, "files": ["held.ts"]}))
    checked = subprocess.run([TSC], cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False)
    assert checked.returncode == 0, checked.stdout
