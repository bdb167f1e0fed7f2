"""Each condition of a mean that counts as known, broken alone."""

from typing import Any

import pytest

from damperlab.worker.steady.response.standard_errors import Estimate
from damperlab.worker.steady.stopping_rules import FEWEST_MEASURED, Settings, is_known

SETTINGS = Settings(4000, 0.02, 1e-9)
KNOWN = {
    "mean": 5.0,
    "error": 0.1,
    "correlation": 3.0,
    "first": 100,
    "last": 100 + FEWEST_MEASURED,
    "stationary": True,
}


@pytest.mark.parametrize(
    ("broken", "known"),
    [
        ({}, True),
        ({"error": 0.101}, False),
        ({"last": 99 + FEWEST_MEASURED}, False),
        ({"correlation": FEWEST_MEASURED / 99.0}, False),
        ({"stationary": False}, False),
    ],
    ids=["all hold", "error", "too short", "correlated", "drift"],
)
def test_a_mean_is_known_where_every_condition_holds(broken: dict[str, Any], known: bool) -> None:
    assert is_known(Estimate(**(KNOWN | broken)), SETTINGS) is known
