"""Kernels that workers lack: compiled before the blocks, once, and said meanwhile. The cheapest kernels serve: fixed steps."""

import threading
from pathlib import Path

import pytest
from tests.worker.run_here import submit

from damperlab.studies.definition import Study, parse_study
from damperlab.studies.store.store import Store
from damperlab.worker.cluster.cluster import connect
from damperlab.worker.run.progress import Progress
from damperlab.worker.run.runner import run_study


def _study(damping_ratio: float) -> Study:
    return parse_study(
        {
            "damping_ratio": damping_ratio,
            "particle": False,
            "axes": {"friction_ratio": [0.0, 0.3], "frequency_ratio": [0.8, 1.2]},
            "solver": {"method": "rk4", "steps_per_cycle": 100},
            "steady": {"max_cycles": 50},
        }
    )


@pytest.mark.night
def test_what_is_missing_is_compiled_first_and_said_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # workers are processes of their own: they alone find the empty folder
    monkeypatch.setenv("DAMPERLAB_CACHE_DIR", str(tmp_path / "kernels"))
    store = Store.open(tmp_path / "data")
    seen: list[tuple[str, int | None, int | None]] = []
    made: dict[str, set[Path]] = {}
    stored = set()

    def run(study: Study) -> None:
        study_id = submit(store, study, None).id

        def note(progress: Progress) -> None:
            now = progress.phase, progress.phase_done, progress.phase_total
            if not seen or seen[-1] != now:
                seen.append(now)
                made[progress.phase] = set(tmp_path.rglob("*.nbc"))
            record = store.find(study_id)
            stored.add((record.phase, record.phase_done, record.phase_total))

        record = run_study(store, study_id, lambda: connect(workers=2), note, threading.Event())
        assert (record.state, record.points_failed) == ("done", 0)

    run(_study(0.05))
    compiling = [one for one in seen if one[0] == "compiling"]
    assert compiling[0] == ("compiling", 0, 2)
    assert compiling[-1] == ("compiling", 2, 2)
    assert seen[0] == ("running", None, None) or seen[0][0] == "starting"
    assert [phase for phase, _, _ in seen].index("starting") < seen.index(compiling[0])
    assert seen[-1] == ("running", None, None)
    # so no block was timed while it compiled
    assert len(made["running"]) == 2
    assert set(tmp_path.rglob("*.nbc")) == made["running"]
    assert {("starting", None, None), ("compiling", 0, 2), ("running", None, None)} <= stored

    seen.clear()
    run(_study(0.06))
    assert "compiling" not in {phase for phase, _, _ in seen}
