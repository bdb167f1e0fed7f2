"""Workers that are jobs of Slurm: what is submitted, when, and studies that are computed so."""

import os
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest
import yaml
from tests.batch_system import make_queue, wait_until_ended

from damperlab.studies.store.store import Store
from damperlab.worker.cluster.batch import Jobs, Place, script, submit
from damperlab.worker.cluster.jobs import AGAIN_SECONDS, Hired, hire
from damperlab.worker.outcomes import ClusterUnusable

SECONDS = 3000
PLACE = Place("tls://10.0.0.1:40123", Path("/shared/jobs/one/tls"))
STUDY = {
    "name": "batch",
    "particle": False,
    "axes": {
        "friction_ratio": {"start": 0.1, "stop": 0.6, "num": 6},
        "frequency_ratio": {"start": 0.8, "stop": 1.2, "num": 20},
    },
}


@pytest.fixture
def queue(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return make_queue(tmp_path, monkeypatch)


def test_script_is_what_slurm_reads() -> None:
    text = script(Jobs(wall_seconds=5430.0, options="--partition=short"), PLACE, 2, 8)
    expected = (Path(__file__).parent / "job_scripts" / "slurm.sh").read_text()
    assert text == expected.replace("PYTHON", sys.executable)
    # what the shell would refuse the batch system could not begin
    subprocess.run(["sh", "-n"], input=text, text=True, check=True)


def test_jobs_are_submitted_as_there_is_work_and_replaced_when_their_workers_have_gone(
    tmp_path: Path,
) -> None:
    (tmp_path / "sbatch").write_text(
        "#!/bin/sh\ncat >> submitted\necho $(($(wc -l < calls) + 1)) | tee -a calls\n"
    )
    (tmp_path / "scancel").write_text('#!/bin/sh\necho "$1" >> cancelled\n')
    for name in ("sbatch", "scancel"):
        (tmp_path / name).chmod(0o755)
    (tmp_path / "calls").touch()
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path)
        patch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
        hired = Hired(Jobs(most=5), PLACE)

        def counts() -> list[int]:
            lines = (tmp_path / "submitted").read_text().splitlines()
            return [int(line.rpartition("-")[2]) for line in lines if "--array" in line]

        hired.look(3, set(), 0.0)
        assert counts() == [3]
        # jobs that wait in the queue are no reason for more of them
        hired.look(3, {"job-1-1"}, AGAIN_SECONDS)
        assert counts() == [3]
        hired.look(100, {"job-1-1", "job-1-3", "somebody"}, AGAIN_SECONDS)
        assert counts() == [3, 2]
        # one has left, and nobody is asked for again and again
        here = {"job-1-1", "job-1-2", "job-2-1", "job-2-2"}
        hired.look(100, here, AGAIN_SECONDS + 1.0)
        assert counts() == [3, 2]
        hired.look(100, here, 2 * AGAIN_SECONDS)
        assert counts() == [3, 2, 1]
        # nothing is left to compute: those that are there leave by themselves
        hired.look(0, set(), 4 * AGAIN_SECONDS)
        assert counts() == [3, 2, 1]
        hired.dismiss()
        # of the first two submissions all workers came and went; of the third nobody has come
        assert (tmp_path / "cancelled").read_text().split() == ["3"]


@pytest.mark.parametrize(
    ("jobs", "folder", "words"),
    [
        (Jobs(wall_seconds=60.0), "data", "job_seconds"),
        (Jobs(), "my data", "without blanks"),
    ],
)
def test_jobs_that_could_not_work_are_refused(tmp_path: Path, jobs: Jobs, folder: str, words: str) -> None:
    with pytest.raises(ClusterUnusable, match=words), hire(jobs, "127.0.0.1", tmp_path / folder, lambda: 1):
        pass
    assert not (tmp_path / folder).exists()


def test_system_that_is_not_there_or_refuses_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(ClusterUnusable, match="there is no such command"):
        submit("")
    refusing = tmp_path / "sbatch"
    refusing.write_text("#!/bin/sh\necho 'sbatch: error: invalid partition specified: short' >&2\nexit 1\n")
    refusing.chmod(0o755)
    with pytest.raises(ClusterUnusable, match="invalid partition"):
        submit("")
    with (
        pytest.raises(ClusterUnusable, match="invalid partition"),
        hire(Jobs(), "127.0.0.1", tmp_path / "jobs", lambda: 1),
    ):
        pass
    # neither keys nor folders stay
    assert list((tmp_path / "jobs").iterdir()) == []


def test_study_is_computed_in_jobs_that_are_taken_back_at_its_end(tmp_path: Path, queue: Path) -> None:
    (tmp_path / "study.yaml").write_text(yaml.safe_dump(STUDY))
    done = subprocess.run(
        [
            *(sys.executable, "-m", "damperlab", "run", "study.yaml", "--cluster", "slurm"),
            *("--data-dir", "data", "--workers", "1"),
        ],
        cwd=tmp_path, timeout=SECONDS, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    with closing(Store.open(tmp_path / "data")) as store:
        record = store.find("batch")
        assert (record.state, record.points_done, record.points_failed) == ("done", 120, 0)
    assert list(queue.glob("*.sh"))
    wait_until_ended(queue)
    # the keys of the cluster are gone with it
    assert not list((tmp_path / "data" / "jobs").rglob("*.pem"))
