"""A stored study keeps the coordinates that its results were computed at, whichever rule made them."""

from typing import Any

import numpy as np
import pytest

from damperlab.studies.definition import parse_study
from damperlab.studies.store.cube.definition import DefinitionDamaged, parse_stored

DOCUMENT: dict[str, Any] = {
    "damping_ratio": 0.05,
    "axes": {
        "friction_ratio": {"start": 0.1, "stop": 0.7, "num": 7},
        "frequency_ratio": {"start": 0.5, "stop": 1.5, "num": 401},
    },
    "particle": False,
}
SUMMED = parse_study(
    DOCUMENT
    | {
        "axes": {
            "friction_ratio": np.linspace(0.1, 0.7, 7).tolist(),
            "frequency_ratio": np.linspace(0.5, 1.5, 401).tolist(),
        }
    }
)


def test_the_digest_tells_by_which_rule_ranges_were_expanded() -> None:
    exact = parse_study(DOCUMENT)
    definition = exact.document()
    assert SUMMED.digest != exact.digest
    for study in (exact, SUMMED):
        read = parse_stored(definition, study.digest)
        assert read.digest == study.digest
        for name, values in study.coordinates.items():
            assert read.coordinates[name].tobytes() == values.tobytes()


@pytest.mark.parametrize(
    "change",
    [
        {"damping_ratio": 0.03},
        {"damping_ratio": 3},
        {"axes": {"frequency_ratio": {"start": 0.5, "stop": 1.5, "num": 402}}},
    ],
)
def test_a_definition_that_changed_is_refused(change: dict[str, Any]) -> None:
    study = parse_study(DOCUMENT)
    with pytest.raises(DefinitionDamaged, match=study.digest[:12]):
        parse_stored(study.document() | change, study.digest)
