"""The batch script of the page on SLURM, run by bash: a stand-in for srun starts real workers on this machine."""

import os
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest
import yaml
from docs.console import ROOT, put_files
from tests.ports import free_port

from damperlab import open_store

SECONDS = 300
SRUN = '#!/bin/bash\ntrap \'kill $(jobs -p)\' TERM\n"$@" &\n"$@" &\nwait\nwait\n'
"""Two tasks on one node, told to end where srun is: it hands signals on."""
STUDY = {
    "name": "batch",
    "particle": False,
    "axes": {
        "friction_ratio": {"start": 0.1, "stop": 0.6, "num": 6},
        "frequency_ratio": {"start": 0.8, "stop": 1.2, "num": 20},
    },
}


@pytest.mark.night
def test_the_batch_script_computes_a_study_and_ends_all_it_started(tmp_path: Path) -> None:
    put_files((ROOT / "docs" / "how-to" / "slurm.md").read_text(), tmp_path)
    script = tmp_path / "study.sbatch"
    script.write_text(script.read_text().replace("8786", str(free_port())))
    (tmp_path / "damper.yaml").write_text(yaml.safe_dump(STUDY))
    for name, text in (("srun", SRUN), ("hostname", "#!/bin/sh\necho 127.0.0.1\n")):
        command = tmp_path / "bin" / name
        command.parent.mkdir(exist_ok=True)
        command.write_text(text)
        command.chmod(0o755)
    data_dir, tls = tmp_path / "data", tmp_path / "tls"
    environment = os.environ | {
        "DAMPERLAB_DATA_DIR": str(data_dir),
        "DAMPERLAB_CLUSTER_TLS": str(tls),
        "PATH": f"{tmp_path / 'bin'}:{Path(sys.executable).parent}:{os.environ['PATH']}",
    }
    subprocess.run(["damperlab", "admin", "certificates", tls], env=environment, check=True, timeout=SECONDS)
    # what it started holds the pipe open: reading ends only when all of it has
    done = subprocess.run(
        ["bash", script, "damper.yaml"], cwd=tmp_path, env=environment, timeout=SECONDS,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
    with closing(open_store(data_dir)) as store:
        record = store.find("batch")
        assert (record.state, record.points_done, record.points_failed) == ("done", 120, 0)
