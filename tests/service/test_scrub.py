"""The service reads what it keeps: damage is logged with its mend, once, and no more when it is mended."""

import logging
from contextlib import closing
from pathlib import Path

import pytest
from tests.faults.damage import make_store
from tests.filling import flip

from damperlab.service.scrub import Scrub
from damperlab.studies.ground.kanai_tajimi import kanai_tajimi
from damperlab.studies.ground.shelf import Shelf as Records
from damperlab.studies.store.store import Store


def test_damage_is_found_logged_once_and_gone_when_it_is_mended(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    make_store(tmp_path)
    motion = kanai_tajimi(1, 1.0, rise_s=0.5, fall_s=0.5)
    record_id, _ = Records(tmp_path).put(motion)
    with closing(Store.open(tmp_path)) as store:
        scrub = Scrub(store, 0.0)
        scrub.look()
        assert not any(scrub.found.values())
        study_id = store.find("done").id
        block = next(Path(store.cube_path(study_id), "blocks").glob("3~*"))
        flip(block, -3, 4)
        flip(tmp_path / "records" / f"{record_id}.npy", -3, 4)
        with caplog.at_level(logging.ERROR, "damperlab.scrub"):
            scrub.look()
            scrub.look()
        about_study, about_catalogue = sorted(
            (record.getMessage() for record in caplog.records), key=lambda text: "catalogue" in text
        )
        assert "block 3" in about_study
        assert f"damperlab store verify {study_id} --repair" in about_study
        assert record_id in about_catalogue
        flip(block, -3, 4)
        Records(tmp_path).put(motion)
        scrub.look()
        assert not any(scrub.found.values())
